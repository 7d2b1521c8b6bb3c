// Behaviour cloning: the policy learns to do what was done in recorded experience (Pomerleau 1988).
#pragma once

#include <array>
#include <vector>

#include "common/model/networks.h"
#include "common/nn/adam.h"
#include "common/nn/thread_team.h"
#include "learner/algorithms/algorithm.h"
#include "learner/algorithms/network_pass.h"

namespace dadrl {

// Minimises the mean square of tanh(mean) - action over a batch, summed over the action's elements. Whoever
// acted, and what came of it, does not matter; the policy's deviations stay as they were initialised, so only
// its mode is cloned. Threads share the batch in blocks of sixteen, each with gradients of its own, as Sac
// does.
class BehaviourCloning final : public Algorithm {
 public:
  explicit BehaviourCloning(const Config& config);
  static AlgorithmSpec SpecOf(const Config& config);

  const AlgorithmSpec& spec() const override { return declared_; }
  Status Update(const TrajectoryBatch& batch) override;
  std::span<const double> scalars() const override { return scalars_; }
  std::span<const float> priorities() const override { return {}; }
  std::vector<NamedNetwork> networks() const override;
  std::vector<StateBlock> state() override;

 private:
  // One thread's share of a batch on its way through the network, laid out in an arena.
  struct Share {
    Share(nn::Arena& arena, const PolicyNetwork& network, int blocks);

    int first = 0;    // sample of the batch
    int samples = 0;  // the rest of the last block is padding
    LaneObservations observations;
    NetworkPass pass;
    double loss = 0.0;  // summed over the samples
    bool finite = true;
  };
  static std::vector<Share> MakeShares(nn::Arena& arena, const PolicyNetwork& network, int batch,
                                       int threads);

  void UpdateShare(const TrajectoryBatch& batch, const uint8_t* context, int member);
  void Backpropagate(Share& share, std::span<const float> actions, int batch_size);
  double TotalLoss() const;

  const Config config_;
  const AlgorithmSpec declared_;
  const PolicyNetwork network_;
  const nn::LaneKernels& kernels_;
  nn::FloatBuffer parameters_;
  nn::AdamMoments moments_;
  uint64_t updates_ = 0;
  std::array<double, 1> scalars_{};
  std::vector<uint8_t> padded_;  // context planes of a batch that is no multiple of sixteen
  nn::Arena arena_;
  std::vector<Share> shares_;
  std::vector<float*> gradients_;
  nn::ThreadTeam team_;
};

}  // namespace dadrl
