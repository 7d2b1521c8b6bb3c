// The scene representation transformer: soft actor-critic on the scene encoder, which also learns to predict
// what it will say next (Liu et al. 2022).
#pragma once

#include "common/nn/adam.h"
#include "learner/algorithms/sac.h"
#include "learner/algorithms/slt/latent_prediction.h"

namespace dadrl {

// Before each update of Sac, a step of the critics' encoder and of the latent prediction on the mean negative
// cosine between prediction and target over the steps that have a next observation, with moments of its own.
// The target comes from the same encoder and carries no gradient.
class Slt final : public Algorithm {
 public:
  // As Sac. config.model.scene is true.
  explicit Slt(const Config& config, std::unique_ptr<NoiseSource> noise = nullptr);
  static AlgorithmSpec SpecOf(const Config& config);

  const AlgorithmSpec& spec() const override { return declared_; }
  Status Update(const TrajectoryBatch& batch) override;
  std::span<const double> scalars() const override { return scalars_; }
  std::span<const float> priorities() const override { return sac_.priorities(); }
  std::vector<NamedNetwork> networks() const override { return sac_.networks(); }
  std::vector<StateBlock> state() override;

  const Sac& sac() const { return sac_; }
  const nn::ParamLayout& prediction_layout() const { return prediction_.layout; }

 private:
  // One thread's part of a batch.
  struct Share {
    int first = 0;  // sample of the batch
    int samples = 0;
    nn::Tape encoder;  // of every step
    nn::Tape next;     // of what is behind each
    nn::Tape prediction;
    float* encoder_gradient = nullptr;     // of the critics' layout
    float* prediction_gradient = nullptr;  // of prediction_.layout
    double loss = 0.0;
    bool finite = true;
  };

  Status StepPrediction(const TrajectoryBatch& batch);
  void PredictShare(const TrajectoryBatch& batch, int member);
  void Encode(const TrajectoryBatch& batch, Share& share);
  void CompareLatents(const TrajectoryBatch& batch, Share& share);
  void Step(int member);
  double TotalLoss() const;
  // Steps of trajectory `sample` that are followed by an observation.
  int Followed(const TrajectoryBatch& batch, int sample) const;
  const SceneEncoder& scene() const { return *sac_.critic().encoder.scene; }

  const Config config_;
  const AlgorithmSpec declared_;
  Sac sac_;
  const LatentPrediction prediction_;
  const nn::LaneKernels& kernels_;
  TrajectoryBatch transitions_;  // of the batch, for Sac
  nn::FloatBuffer parameters_;   // of the prediction
  nn::AdamMoments encoder_moments_;
  nn::AdamMoments prediction_moments_;
  uint64_t updates_ = 0;
  std::vector<double> scalars_;
  int followed_ = 0;  // of the running update
  nn::Arena arena_;
  std::vector<Share> shares_;
  std::vector<float*> encoder_gradients_;
  std::vector<float*> prediction_gradients_;
  nn::ThreadTeam team_;
};

}  // namespace dadrl
