// Proximal policy optimisation (Schulman et al. 2017) on rollouts that come through the replay.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/model/networks.h"
#include "common/nn/adam.h"
#include "common/nn/squashed_gaussian.h"
#include "common/nn/thread_team.h"
#include "learner/algorithms/algorithm.h"
#include "learner/algorithms/network_pass.h"
#include "learner/algorithms/noise_source.h"
#include "learner/algorithms/ppo/advantages.h"

namespace dadrl {

// One update: values and log-probabilities of the whole rollout as they are, advantages from them
// (EstimateAdvantages), normalised over the rollout; then algorithm.epochs passes over its steps in random
// order, in minibatches of at most algorithm.batch_size, each a step of both networks:
//
//   policy loss = mean of -min(ratio A, clip(ratio) A) + entropy_weight log pi(a'|s),  a' drawn anew
//   value loss  = mean of (V - value target)^2
//
// `ratio` is to the policy that acted, by the log-probability that it recorded; the recorded action is the
// stored one, so that tanh's slope cancels. The entropy is that of the squashed action.
//
// model.encoders: `separate`: policy and value own an encoder each. `shared`: one, trained by the value loss
// alone; the policy's copy follows it. Threads share a minibatch in blocks of sixteen, each with gradients of
// its own, as Sac does. All memory is taken by the constructor.
class Ppo final : public Algorithm {
 public:
  // Draws from `noise`, or from a generator seeded by config.seed if null.
  explicit Ppo(const Config& config, std::unique_ptr<NoiseSource> noise = nullptr);

  static AlgorithmSpec SpecOf(const Config& config);
  const AlgorithmSpec& spec() const override { return declared_; }
  Status Update(const TrajectoryBatch& batch) override;
  std::span<const double> scalars() const override { return scalars_; }
  std::span<const float> priorities() const override { return {}; }
  std::vector<NamedNetwork> networks() const override;
  std::vector<StateBlock> state() override;

  const PolicyNetwork& policy() const { return policy_; }
  const ValueNetwork& value() const { return value_; }

 private:
  // Sums over samples, added up over threads in a fixed order.
  struct Sums {
    double policy_loss = 0.0;
    double value_loss = 0.0;
    double log_probability = 0.0;  // of actions drawn anew
    double divergence = 0.0;       // from the policies that acted
    double clipped = 0.0;          // samples
    void Add(const Sums& other);
  };
  // One thread's share of a minibatch on its way through the networks.
  struct Share {
    Share(nn::Arena& arena, const PolicyNetwork& policy, const ValueNetwork& value, int blocks);

    int first = 0;    // sample of the minibatch
    int samples = 0;  // the rest of the last block is padding
    LaneObservations observations;
    NetworkPass policy, value;
    Sums sums;
    double policy_square = 0.0, value_square = 0.0;  // of its part of the gradients
    bool finite = true;
  };
  // A network as its optimiser sees it.
  struct Trained {
    nn::Range range;  // of the parameters
    nn::FloatBuffer& parameters;
    nn::AdamMoments& moments;
    std::span<float* const> gradients;  // one a thread
    double learning_rate;
  };
  static std::vector<Share> MakeShares(nn::Arena& arena, const PolicyNetwork& policy,
                                       const ValueNetwork& value, int batch, int threads);

  // Each on the training thread.
  Status CheckBatch(const TrajectoryBatch& batch) const;
  void FindRows(const TrajectoryBatch& batch);
  void Evaluate(const TrajectoryBatch& batch);
  void NormaliseAdvantages();
  Status TrainEpoch(const TrajectoryBatch& batch);
  Status CheckFinite() const;
  void Report();

  // Each on every thread of the team. `rows`: places in [L, B].
  void Forward(const TrajectoryBatch& batch, std::span<const uint32_t> rows, int member);
  void Record(const TrajectoryBatch& batch, std::span<const uint32_t> rows, const Share& share);
  void TrainShare(const TrajectoryBatch& batch, std::span<const uint32_t> rows, std::span<const float> noise,
                  int member);
  void PolicyGradient(const TrajectoryBatch& batch, std::span<const uint32_t> rows,
                      std::span<const float> noise, Share& share);
  void ValueGradient(std::span<const uint32_t> rows, Share& share);
  void Backward(const Share& share);
  double SquareOf(const Trained& network, int member) const;
  bool Step(const Trained& network, double square, int member);
  void CopyEncoder(int member);

  Sums TotalSums() const;
  Trained trained_policy();
  Trained trained_value();
  bool shared() const { return config_.model.encoders == EncoderSharing::kShared; }

  const Config config_;
  const AlgorithmSpec declared_;
  const PolicyNetwork policy_;
  const ValueNetwork value_;
  const size_t log_probability_column_;
  const nn::LaneKernels& kernels_;
  const nn::GaussianLimits limits_;
  nn::FloatBuffer policy_parameters_, value_parameters_;
  nn::AdamMoments policy_moments_, value_moments_;
  uint64_t steps_ = 0;  // of the optimisers
  std::unique_ptr<NoiseSource> noise_source_;

  // Of the running update; rows are places in [L, B].
  std::vector<uint32_t> rows_;       // that hold a step
  std::vector<uint32_t> seen_rows_;  // and those of the observations behind
  std::vector<uint32_t> order_;      // of rows_, in this epoch
  std::vector<float> order_noise_;   // [rows]
  std::vector<float> action_noise_;  // [rows, 2]
  std::vector<float> values_;        // [L + 1, B], before the first step
  std::vector<float> ratios_;        // [L, B]
  Advantages advantages_;
  Columns minibatch_;     // observations, gathered
  Sums sums_;             // over all minibatches
  double trained_ = 0.0;  // samples in them
  std::array<double, 8> scalars_{};

  nn::Arena arena_;
  std::vector<Share> shares_;
  std::vector<float*> policy_gradients_, value_gradients_;
  nn::ThreadTeam team_;
};

}  // namespace dadrl
