#include "learner/algorithms/dt/decision_transformer_learner.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/util/random.h"

namespace dadrl {
namespace {

constexpr std::array kScalars = {ScalarSpec{"action_error", "loss/action_error"},
                                 ScalarSpec{"gradient_norm", "loss/gradient_norm"}};
constexpr int kContext = DecisionTransformer::kContext;

}  // namespace

AlgorithmSpec DecisionTransformerLearner::SpecOf(const Config& config) {
  return {.batch = {.count = config.algorithm.batch_size, .steps = kContext, .all_observations = true},
          .scalars = kScalars};
}

DecisionTransformerLearner::DecisionTransformerLearner(const Config& config)
    : config_(config),
      declared_(SpecOf(config)),
      network_(DrivingShape::From(config.observation)),
      kernels_(nn::LaneKernelsFor(ActiveIsa())),
      parameters_(network_.layout.size()),
      moments_(network_.layout.size()),
      team_(config.learner.threads) {
  network_.layout.Initialize(DeriveSeed(config.seed, 1), parameters_.span());
  const int threads = config.learner.threads;
  const int batch = (config.algorithm.batch_size + threads - 1) / threads;
  nn::Arena measure;
  const nn::Tape measured(measure, network_.graph, batch, true);
  measure.Allocate(network_.layout.size());
  arena_ = nn::Arena(measure.used() * static_cast<size_t>(threads));
  for (int i = 0; i < threads; ++i) {
    Share& share = shares_.emplace_back();
    share.tape = nn::Tape(arena_, network_.graph, batch, true);
    share.gradient = arena_.Allocate(network_.layout.size());
    gradients_.push_back(share.gradient);
    FillConstants(network_, share.tape, batch);
  }
}

std::vector<NamedNetwork> DecisionTransformerLearner::networks() const {
  return {{kPolicyNetwork, network_.layout.hash(), parameters_.span()}};
}

std::vector<StateBlock> DecisionTransformerLearner::state() {
  return {{"policy", parameters_.bytes()},
          {"policy.adam_first", moments_.first.bytes()},
          {"policy.adam_second", moments_.second.bytes()},
          {"updates", std::as_writable_bytes(std::span(&updates_, 1))}};
}

double DecisionTransformerLearner::LearningRate() const {
  const auto& a = config_.algorithm;
  const double warm =
      a.warmup_updates == 0
          ? 1.0
          : std::min(1.0, static_cast<double>(updates_ + 1) / static_cast<double>(a.warmup_updates));
  return warm * a.actor_learning_rate;
}

Status DecisionTransformerLearner::Update(const TrajectoryBatch& batch) {
  decisions_ = std::accumulate(batch.steps.begin(), batch.steps.end(), 0);
  auto work = [&](int member) { UpdateShare(batch, member); };
  team_.Run(work);
  double loss = 0.0;
  double squares = 0.0;
  for (const Share& share : shares_) {
    loss += share.loss;
    squares += share.squares;
  }
  scalars_ = {loss / (decisions_ * kActionSize), std::sqrt(squares)};
  const bool finite = std::ranges::all_of(shares_, &Share::finite);
  if (!std::isfinite(scalars_[0]) || !std::isfinite(scalars_[1]) || !finite) {
    return Fail(ErrorCode::kInternal, "{} is not finite in update {}",
                finite ? std::string_view("the action error or its gradient")
                       : network_.layout.FirstNonFinite(parameters_.span()),
                updates_ + 1);
  }
  ++updates_;
  return {};
}

void DecisionTransformerLearner::Pack(const TrajectoryBatch& batch, Share& share) {
  for (int i = 0; i < share.samples; ++i) {
    const int sample = share.first + i;
    for (int t = 0; t < batch.steps[static_cast<size_t>(sample)]; ++t) {
      WriteState(network_, batch.ObservationsAt(t), sample, share.tape, i, t);
      std::ranges::copy(
          batch.DecisionsAt(0, t).subspan(static_cast<size_t>(sample) * kActionSize, kActionSize),
          share.tape.input(network_.actions) + OffsetOf(network_, network_.actions, i, t));
    }
  }
}

void DecisionTransformerLearner::CompareActions(const TrajectoryBatch& batch, Share& share, int count) {
  share.tape.BeginBackward();
  for (int i = 0; i < share.samples; ++i) {
    const auto sample = static_cast<size_t>(share.first + i);
    for (int t = 0; t < batch.steps[sample]; ++t) {
      const size_t at = OffsetOf(network_, network_.output, i, t);
      for (size_t d = 0; d < kActionSize; ++d) {
        const float error =
            share.tape.value(network_.output)[at + d] - batch.DecisionsAt(0, t)[sample * kActionSize + d];
        share.loss += static_cast<double>(error) * static_cast<double>(error);
        share.tape.gradient(network_.output)[at + d] = 2.0f * error / static_cast<float>(count);
      }
    }
  }
}

void DecisionTransformerLearner::UpdateShare(const TrajectoryBatch& batch, int member) {
  Share& share = shares_[static_cast<size_t>(member)];
  share.first = batch.shape.count * member / team_.size();
  share.samples = batch.shape.count * (member + 1) / team_.size() - share.first;
  share.loss = share.squares = 0.0;
  share.finite = true;
  Pack(batch, share);
  share.tape.Forward(parameters_.data(), share.samples);
  CompareActions(batch, share, decisions_ * kActionSize);
  share.tape.Backward(parameters_.data(), share.gradient);
  team_.Barrier();
  Step(member);
}

void DecisionTransformerLearner::Step(int member) {
  Share& share = shares_[static_cast<size_t>(member)];
  const nn::Range range = nn::ShareOf({0, network_.layout.size()}, member, team_.size());
  float* const sum = gradients_[0];
  for (size_t i = range.first; i < range.first + range.count; ++i) {
    for (size_t thread = 1; thread < gradients_.size(); ++thread) {
      sum[i] += gradients_[thread][i];
      gradients_[thread][i] = 0.0f;
    }
    share.squares += static_cast<double>(sum[i]) * static_cast<double>(sum[i]);
  }
  if (member == 0) Decay(LearningRate());
  team_.Barrier();
  // Every thread adds the same numbers in the same order and so takes the same way.
  double squares = 0.0;
  for (const Share& other : shares_) squares += other.squares;
  if (!std::isfinite(squares)) return;
  const double limit = config_.algorithm.max_gradient_norm;
  const double scale = limit > 0.0 ? std::min(1.0, limit / (std::sqrt(squares) + 1e-6)) : 1.0;
  for (size_t i = range.first; i < range.first + range.count; ++i) sum[i] *= static_cast<float>(scale);
  share.finite =
      nn::ApplyAdam(kernels_, {.learning_rate = LearningRate(), .epsilon = config_.algorithm.adam_epsilon},
                    {.range = range,
                     .parameters = parameters_.data() + range.first,
                     .moments = &moments_,
                     .gradients = std::span(gradients_).first(1),
                     .step = updates_ + 1});
}

void DecisionTransformerLearner::Decay(double learning_rate) {
  const auto kept = static_cast<float>(1.0 - learning_rate * config_.algorithm.weight_decay);
  for (const nn::TensorInfo& tensor : network_.layout.tensors()) {
    if (!tensor.name.ends_with(".weight")) continue;
    for (float& value : parameters_.span().subspan(tensor.offset, tensor.size)) value *= kept;
  }
}

}  // namespace dadrl
