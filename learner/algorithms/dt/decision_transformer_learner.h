// The decision transformer (Chen et al. 2021), learnt from what others did.
#pragma once

#include <array>
#include <vector>

#include "common/model/decision_transformer.h"
#include "common/nn/adam.h"
#include "common/nn/thread_team.h"
#include "learner/algorithms/algorithm.h"

namespace dadrl {

// Minimises the mean square of the actions' error over all decisions of a batch of stretches of episodes,
// each asked for the return of a success: what it is given should mostly succeed. AdamW (Loshchilov and
// Hutter 2019) on the matrices' decay, a linear warm-up, and the gradient's norm clipped. Threads share the
// batch by samples, each with gradients of its own.
class DecisionTransformerLearner final : public Algorithm {
 public:
  explicit DecisionTransformerLearner(const Config& config);
  static AlgorithmSpec SpecOf(const Config& config);

  const AlgorithmSpec& spec() const override { return declared_; }
  Status Update(const TrajectoryBatch& batch) override;
  std::span<const double> scalars() const override { return scalars_; }
  std::span<const float> priorities() const override { return {}; }
  std::vector<NamedNetwork> networks() const override;
  std::vector<StateBlock> state() override;

  const DecisionTransformer& network() const { return network_; }

 private:
  // One thread's part of a batch.
  struct Share {
    int first = 0;  // sample of the batch
    int samples = 0;
    nn::Tape tape;
    float* gradient = nullptr;  // of the layout
    double loss = 0.0;          // summed over actions
    double squares = 0.0;       // of the gradient, of the range that it steps
    bool finite = true;
  };

  void UpdateShare(const TrajectoryBatch& batch, int member);
  void Pack(const TrajectoryBatch& batch, Share& share);
  // Loss and gradient of the share's actions, of `count` numbers in the batch.
  void CompareActions(const TrajectoryBatch& batch, Share& share, int count);
  // Sums the threads' gradients and their squares, then steps.
  void Step(int member);
  void Decay(double learning_rate);
  double LearningRate() const;

  const Config config_;
  const AlgorithmSpec declared_;
  const DecisionTransformer network_;
  const nn::LaneKernels& kernels_;
  nn::FloatBuffer parameters_;
  nn::AdamMoments moments_;
  uint64_t updates_ = 0;
  std::array<double, 2> scalars_{};
  int decisions_ = 0;  // of the running update
  nn::Arena arena_;
  std::vector<Share> shares_;
  std::vector<float*> gradients_;
  nn::ThreadTeam team_;
};

}  // namespace dadrl
