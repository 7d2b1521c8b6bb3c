// Soft actor-critic with twin critics and a learned temperature (Haarnoja et al. 2018), in hand-written
// passes.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "common/config/config.h"
#include "common/nn/thread_team.h"
#include "learner/algorithms/algorithm.h"
#include "learner/algorithms/n_step.h"
#include "learner/algorithms/noise_source.h"
#include "learner/algorithms/sac_workspace.h"

namespace dadrl {

// One update: critics towards the soft n-step target, then the actor against the new critics, then the
// temperature towards the target entropy; the target network's Polyak step rides on the critics' optimiser
// pass.
//
// model.encoders: `separate`: actor, critics and target own an encoder each (paper, Stable-Baselines3); the
// actor's is trained by the actor loss, in which the critics' features carry no gradient. `shared`: one
// encoder, trained by the critic loss alone; the actor's copy follows it, and the actor loss uses the critic
// pass's features, detached.
//
// algorithm.shift_pixels above 0 makes it DrQ (Kostrikov, Yarats and Fergus 2021): the critics learn from two
// views of the batch, their bird's-eye planes shifted at random; the target is the mean over two views of
// what followed, the losses of both views are added, and the actor sees the planes as they are.
//
// The batch is split over learner.threads in blocks of sixteen; each thread has its own gradients, which are
// summed in thread order, so results are reproducible for a thread count and differ in rounding between
// counts. All memory is taken by the constructor.
class Sac final : public Algorithm {
 public:
  // Draws its noise from `noise`, or from a generator seeded by config.seed if null.
  explicit Sac(const Config& config, std::unique_ptr<NoiseSource> noise = nullptr);

  static AlgorithmSpec SpecOf(const Config& config);
  const AlgorithmSpec& spec() const override { return declared_; }
  // Batches of up to algorithm.batch_size trajectories; kInvalidArgument beyond.
  Status Update(const TrajectoryBatch& batch) override;
  // The update itself.
  Status Update(const Transitions& batch);
  std::span<const double> scalars() const override { return scalars_; }
  // |error| of the critics' mean.
  std::span<const float> priorities() const override { return {td_error_.data(), td_error_count_}; }
  std::vector<NamedNetwork> networks() const override;
  std::vector<StateBlock> state() override;

  const PolicyNetwork& policy() const { return policy_; }
  const CriticNetwork& critic() const { return critic_; }
  // Of the critics' encoder, for another loss to step between updates; EncoderChanged then lets the policy's
  // copy of a shared encoder follow.
  std::span<float> encoder_parameters() {
    return critic_parameters_.span().first(critic_.encoder_range.count);
  }
  void EncoderChanged();

 private:
  // The four parts of an update, on one thread's share.
  void PackShare(const Transitions& batch, SacWorkspace& workspace, int member);
  void TargetPass(const Transitions& batch, SacWorkspace& workspace, BatchView view);
  void CriticPass(const Transitions& batch, SacWorkspace& workspace, BatchView view);
  void ActorPass(const Transitions& batch, SacWorkspace& workspace);

  // The share's planes in `view`; `shifts` [batch, 2] are its draws.
  const uint8_t* PlanesOf(const uint8_t* context, std::span<const float> shifts, BatchView view,
                          SacWorkspace& workspace) const;

  // Everything one thread does in an update; all return together.
  void UpdateShare(const Transitions& batch, int member);
  void StepCritic(int member);
  void StepPolicy(int member);
  SacSums TotalSums() const;
  bool AllStepsFinite() const;

  Status CheckBatch(const Transitions& batch) const;
  const uint8_t* WholeBlocks(ColumnRows observations, std::vector<uint8_t>& padded) const;
  Status Finish(int batch_size);

  int views() const { return config_.algorithm.shift_pixels > 0 ? 2 : 1; }
  bool shared() const { return config_.model.encoders == EncoderSharing::kShared; }

  Config config_;
  AlgorithmSpec declared_;
  DrivingShape spec_;
  PolicyNetwork policy_;
  CriticNetwork critic_;
  const nn::LaneKernels& kernels_;
  nn::GaussianLimits limits_;

  nn::FloatBuffer policy_parameters_;
  nn::FloatBuffer average_parameters_;
  nn::FloatBuffer critic_parameters_;
  nn::FloatBuffer target_parameters_;
  nn::AdamMoments policy_moments_;
  nn::AdamMoments critic_moments_;
  nn::ScalarAdam log_alpha_;
  uint64_t updates_ = 0;
  NStepReturns returns_;
  std::unique_ptr<NoiseSource> noise_source_;

  // Of the running update.
  double alpha_ = 0.0;
  std::vector<float> next_noise_;   // [views, batch, 2]
  std::vector<float> now_noise_;    // [batch, 2]
  std::vector<float> now_shifts_;   // [views, batch, 2], standard normal; empty without views
  std::vector<float> next_shifts_;  // the same
  std::array<double, 7> scalars_{};
  std::vector<float> td_error_;
  size_t td_error_count_ = 0;
  std::vector<uint8_t> padded_now_;  // context planes of a batch that is no multiple of sixteen
  std::vector<uint8_t> padded_next_;
  const uint8_t* now_context_ = nullptr;
  const uint8_t* next_context_ = nullptr;

  nn::Arena arena_;
  std::vector<SacWorkspace> workspaces_;  // one a thread
  std::vector<float*> policy_gradients_;  // theirs
  std::vector<float*> critic_gradients_;
  nn::ThreadTeam team_;
};

}  // namespace dadrl
