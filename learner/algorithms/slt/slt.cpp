#include "learner/algorithms/slt/slt.h"

#include <algorithm>
#include <cmath>

#include "common/util/random.h"

namespace dadrl {
namespace {

// Sac's, and what is added.
std::span<const ScalarSpec> Scalars(const Config& config) {
  static const std::vector<ScalarSpec> scalars = [&] {
    const auto of_sac = Sac::SpecOf(config).scalars;
    std::vector<ScalarSpec> all(of_sac.begin(), of_sac.end());
    all.push_back({"latent_loss", "loss/latent"});
    return all;
  }();
  return scalars;
}

}  // namespace

AlgorithmSpec Slt::SpecOf(const Config& config) {
  AlgorithmSpec spec = Sac::SpecOf(config);
  spec.batch.steps = std::max(config.algorithm.n_step, config.algorithm.latent_steps);
  spec.batch.all_observations = true;
  spec.scalars = Scalars(config);
  spec.trains_scene = true;
  return spec;
}

Slt::Slt(const Config& config, std::unique_ptr<NoiseSource> noise)
    : config_(config),
      declared_(SpecOf(config)),
      sac_(config, std::move(noise)),
      prediction_(SceneEncoder::kFeatures, config.algorithm.latent_steps),
      kernels_(nn::LaneKernelsFor(ActiveIsa())),
      transitions_(DrivingStepSpec(config), Sac::SpecOf(config).batch),
      parameters_(prediction_.layout.size()),
      encoder_moments_(sac_.critic().encoder_range.count),
      prediction_moments_(prediction_.layout.size()),
      scalars_(declared_.scalars.size()),
      team_(config.learner.threads) {
  prediction_.layout.Initialize(DeriveSeed(config.seed, 4), parameters_.span());
  const int threads = config.learner.threads;
  const int samples = (config.algorithm.batch_size + threads - 1) / threads;
  const auto lay_out = [&](nn::Arena& arena, Share& share) {
    const int steps = config.algorithm.latent_steps;
    share.encoder = nn::Tape(arena, scene().graph, samples * steps, true);
    share.next = nn::Tape(arena, scene().graph, samples * steps, false);
    share.prediction = nn::Tape(arena, prediction_.graph, samples, true);
    share.encoder_gradient = arena.Allocate(sac_.critic().encoder_range.count);
    share.prediction_gradient = arena.Allocate(prediction_.layout.size());
  };
  nn::Arena measure;
  Share measured;
  lay_out(measure, measured);
  arena_ = nn::Arena(measure.used() * static_cast<size_t>(threads));
  for (int i = 0; i < threads; ++i) {
    Share& share = shares_.emplace_back();
    lay_out(arena_, share);
    encoder_gradients_.push_back(share.encoder_gradient);
    prediction_gradients_.push_back(share.prediction_gradient);
  }
}

std::vector<StateBlock> Slt::state() {
  std::vector<StateBlock> blocks = sac_.state();
  blocks.insert(blocks.end(), {{"latent", parameters_.bytes()},
                               {"latent.adam_first", prediction_moments_.first.bytes()},
                               {"latent.adam_second", prediction_moments_.second.bytes()},
                               {"latent.encoder_adam_first", encoder_moments_.first.bytes()},
                               {"latent.encoder_adam_second", encoder_moments_.second.bytes()},
                               {"latent.updates", std::as_writable_bytes(std::span(&updates_, 1))}});
  return blocks;
}

Status Slt::Update(const TrajectoryBatch& batch) {
  DADRL_RETURN_IF_ERROR(StepPrediction(batch));
  FirstSteps(batch, transitions_);
  DADRL_RETURN_IF_ERROR(sac_.Update(transitions_));
  *std::ranges::copy(sac_.scalars(), scalars_.begin()).out = TotalLoss();
  return {};
}

int Slt::Followed(const TrajectoryBatch& batch, int sample) const {
  const auto index = static_cast<size_t>(sample);
  const int steps = batch.steps[index] - (batch.terminated[index] != 0 ? 1 : 0);
  return std::min(steps, config_.algorithm.latent_steps);
}

Status Slt::StepPrediction(const TrajectoryBatch& batch) {
  followed_ = 0;
  for (int i = 0; i < batch.shape.count; ++i) followed_ += Followed(batch, i);
  auto work = [&](int member) { PredictShare(batch, member); };
  team_.Run(work);
  const bool finite = std::ranges::all_of(shares_, &Share::finite);
  if (!std::isfinite(TotalLoss()) || !finite) {
    const std::string_view tensor = prediction_.layout.FirstNonFinite(parameters_.span());
    return Fail(ErrorCode::kInternal, "{} is not finite in update {}",
                finite           ? "the latent loss"
                : tensor.empty() ? "the encoder"
                                 : tensor,
                updates_ + 1);
  }
  sac_.EncoderChanged();
  ++updates_;
  return {};
}

void Slt::PredictShare(const TrajectoryBatch& batch, int member) {
  Share& share = shares_[static_cast<size_t>(member)];
  share.first = batch.shape.count * member / team_.size();
  share.samples = batch.shape.count * (member + 1) / team_.size() - share.first;
  share.loss = 0.0;
  share.finite = true;
  Encode(batch, share);
  share.prediction.Forward(parameters_.data(), share.samples);
  CompareLatents(batch, share);
  share.prediction.Backward(parameters_.data(), share.prediction_gradient);
  const auto latents =
      static_cast<size_t>(share.samples) * prediction_.graph.shape(prediction_.latents).floats();
  share.encoder.BeginBackward();
  std::copy_n(share.prediction.gradient(prediction_.latents), latents,
              share.encoder.gradient(scene().features));
  share.encoder.Backward(sac_.encoder_parameters().data(), share.encoder_gradient);
  team_.Barrier();
  // Every thread sees the same sum and so takes the same way out; nothing has been stepped yet.
  if (!std::isfinite(TotalLoss())) return;
  Step(member);
}

void Slt::Encode(const TrajectoryBatch& batch, Share& share) {
  const int steps = config_.algorithm.latent_steps;
  for (int i = 0; i < share.samples; ++i) {
    for (int t = 0; t < steps; ++t) {
      const int sample = share.first + i;
      PackScene(scene(), batch.ObservationsAt(t), sample, share.encoder, i * steps + t);
      PackScene(scene(), batch.ObservationsAt(t + 1), sample, share.next, i * steps + t);
      std::ranges::copy(
          batch.DecisionsAt(0, t).subspan(static_cast<size_t>(sample) * kActionSize, kActionSize),
          share.prediction.input(prediction_.actions) + ptrdiff_t{i * steps + t} * nn::kLanes);
    }
  }
  const float* const parameters = sac_.encoder_parameters().data();
  share.encoder.Forward(parameters, share.samples * steps);
  share.next.Forward(parameters, share.samples * steps);
  // Rows of both graphs lie alike: a step a row.
  const auto floats =
      static_cast<size_t>(share.samples) * prediction_.graph.shape(prediction_.latents).floats();
  std::copy_n(share.encoder.value(scene().features), floats, share.prediction.input(prediction_.latents));
  std::copy_n(share.next.value(scene().features), floats, share.prediction.input(prediction_.next));
}

void Slt::CompareLatents(const TrajectoryBatch& batch, Share& share) {
  share.prediction.BeginBackward();
  constexpr size_t kUnits = LatentPrediction::kUnits;
  for (int i = 0; i < share.samples; ++i) {
    for (int t = 0; t < Followed(batch, share.first + i); ++t) {
      const size_t at = static_cast<size_t>(i * config_.algorithm.latent_steps + t) * kUnits;
      share.loss += NegativeCosine({share.prediction.value(prediction_.prediction) + at, kUnits},
                                   {share.prediction.value(prediction_.target) + at, kUnits}, 1.0 / followed_,
                                   {share.prediction.gradient(prediction_.prediction) + at, kUnits});
    }
  }
}

void Slt::Step(int member) {
  Share& share = shares_[static_cast<size_t>(member)];
  const nn::AdamSettings settings{.learning_rate = config_.algorithm.critic_learning_rate,
                                  .epsilon = config_.algorithm.adam_epsilon};
  const auto step = [&](float* parameters, nn::AdamMoments& moments, std::span<float* const> gradients) {
    const nn::Range range = nn::ShareOf({0, moments.first.size()}, member, team_.size());
    return nn::ApplyAdam(kernels_, settings,
                         {.range = range,
                          .parameters = parameters + range.first,
                          .moments = &moments,
                          .gradients = gradients,
                          .step = updates_ + 1});
  };
  const bool encoder = step(sac_.encoder_parameters().data(), encoder_moments_, encoder_gradients_);
  const bool prediction = step(parameters_.data(), prediction_moments_, prediction_gradients_);
  share.finite = encoder && prediction;
}

double Slt::TotalLoss() const {
  double sum = 0.0;
  for (const Share& share : shares_) sum += share.loss;
  return sum;
}

}  // namespace dadrl
