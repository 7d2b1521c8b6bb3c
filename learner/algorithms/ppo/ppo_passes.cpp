// What each training thread does in an update of PPO.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "learner/algorithms/ppo/ppo.h"

namespace dadrl {

using nn::kLanes;

namespace {

// Feature `row` of sample `i` of the share.
float& At(nn::LaneSpan span, int row, int i) { return span.block(i / kLanes)[row * kLanes + i % kLanes]; }

void Clear(nn::LaneSpan span, int features, int blocks) {
  for (int b = 0; b < blocks; ++b) {
    std::memset(span.block(b), 0, static_cast<size_t>(features * kLanes) * sizeof(float));
  }
}

// One element of a row of every column, from one set of columns to another.
void CopyRow(const Columns& from, uint32_t from_row, Columns& to, int to_row) {
  const ColumnRows source(from, static_cast<int>(from_row), 1);
  const MutableColumnRows target(to, to_row, 1);
  for (size_t c = 0; c < from.columns(); ++c) {
    std::ranges::copy(source.floats(c), target.floats(c).begin());
    std::ranges::copy(source.bits(c), target.bits(c).begin());
  }
}

}  // namespace

void Ppo::Forward(const TrajectoryBatch& batch, std::span<const uint32_t> rows, int member) {
  Share& share = shares_[static_cast<size_t>(member)];
  const int samples = static_cast<int>(rows.size());
  const int blocks = (samples + kLanes - 1) / kLanes;
  const int first = blocks * member / team_.size();
  const int count = blocks * (member + 1) / team_.size() - first;
  share.first = first * kLanes;
  share.samples = std::clamp(samples - share.first, 0, count * kLanes);
  share.sums = {};
  share.finite = true;
  if (share.samples == 0) return;
  for (int i = share.first; i < share.first + share.samples; ++i) {
    CopyRow(batch.observations, rows[static_cast<size_t>(i)], minibatch_, i);
  }
  share.observations.blocks = count;
  const ColumnRows gathered(minibatch_, share.first, count * kLanes);
  share.observations.Pack(kernels_, gathered, gathered.bits(policy_.encoder.spec.context_column).data(), 0);
  ForwardPass(kernels_, value_.encoder, value_.head, value_parameters_.data(), share.observations,
              share.value);
  if (shared()) {
    MlpForward(kernels_, policy_.head, policy_parameters_.data(), share.value.features, count,
               share.policy.head, share.policy.output);
  } else {
    ForwardPass(kernels_, policy_.encoder, policy_.head, policy_parameters_.data(), share.observations,
                share.policy);
  }
}

namespace {

// Of a stored action, under the policy's output for sample `i`.
std::array<nn::SquashedDensity, kActionSize> DensitiesOf(std::span<const float> action, nn::LaneSpan output,
                                                         int i, const nn::GaussianLimits& limits) {
  std::array<nn::SquashedDensity, kActionSize> densities;
  for (int d = 0; d < kActionSize; ++d) {
    const auto at = static_cast<size_t>(d);
    densities[at] = nn::DensityOf(static_cast<double>(action[at]), static_cast<double>(At(output, d, i)),
                                  static_cast<double>(At(output, kActionSize + d, i)), limits);
  }
  return densities;
}

double LogProbability(std::span<const nn::SquashedDensity> densities) {
  double sum = 0.0;
  for (const nn::SquashedDensity& density : densities) sum += density.log_probability;
  return sum;
}

std::span<const float> ActionOf(const TrajectoryBatch& batch, uint32_t row) {
  return std::span(batch.decisions[0]).subspan(size_t{row} * kActionSize, kActionSize);
}

}  // namespace

// Values of all observations, ratios of those with a step.
void Ppo::Record(const TrajectoryBatch& batch, std::span<const uint32_t> rows, const Share& share) {
  for (int i = 0; i < share.samples; ++i) {
    const uint32_t row = rows[static_cast<size_t>(share.first + i)];
    values_[row] = At(share.value.output, 0, i);
    if (row >= ratios_.size()) continue;
    const auto densities = DensitiesOf(ActionOf(batch, row), share.policy.output, i, limits_);
    const auto recorded = static_cast<double>(batch.decisions[log_probability_column_][row]);
    ratios_[row] = static_cast<float>(std::exp(LogProbability(densities) - recorded));
  }
}

void Ppo::PolicyGradient(const TrajectoryBatch& batch, std::span<const uint32_t> rows,
                         std::span<const float> noise, Share& share) {
  const nn::LaneSpan gradient = share.policy.output_gradient;
  Clear(gradient, 2 * kActionSize, share.observations.blocks);
  const double clip = config_.algorithm.clip_ratio;
  const double entropy_weight = config_.algorithm.entropy_weight;
  const double scale = 1.0 / static_cast<double>(rows.size());
  for (int i = 0; i < share.samples; ++i) {
    const auto sample = static_cast<size_t>(share.first + i);
    const uint32_t row = rows[sample];
    const auto densities = DensitiesOf(ActionOf(batch, row), share.policy.output, i, limits_);
    const auto recorded = static_cast<double>(batch.decisions[log_probability_column_][row]);
    const double log_ratio = LogProbability(densities) - recorded;
    const double ratio = std::exp(log_ratio);
    const auto advantage = static_cast<double>(advantages_.advantage[row]);
    const double bounded = std::clamp(ratio, 1.0 - clip, 1.0 + clip);
    const bool cut = bounded * advantage < ratio * advantage;  // no gradient beyond the bound
    share.sums.policy_loss -= std::min(ratio * advantage, bounded * advantage);
    share.sums.divergence += ratio - 1.0 - log_ratio;
    share.sums.clipped += bounded != ratio ? 1.0 : 0.0;
    const double slope = cut ? 0.0 : -scale * advantage * ratio;  // of the log-probability
    for (int d = 0; d < kActionSize; ++d) {
      const auto draw = static_cast<double>(noise[sample * kActionSize + static_cast<size_t>(d)]);
      const nn::SquashedSample anew =
          nn::SampleSquashed(static_cast<double>(At(share.policy.output, d, i)),
                             static_cast<double>(At(share.policy.output, kActionSize + d, i)), draw, limits_);
      const nn::SquashedGradient entropy = nn::SquashedBackward(anew, draw, 0.0, scale * entropy_weight);
      const nn::SquashedDensity& density = densities[static_cast<size_t>(d)];
      share.sums.policy_loss += entropy_weight * anew.log_probability;
      share.sums.log_probability += anew.log_probability;
      At(gradient, d, i) = static_cast<float>(slope * density.mean_gradient + entropy.mean);
      At(gradient, kActionSize + d, i) =
          static_cast<float>(slope * density.log_std_gradient + entropy.log_std);
    }
  }
}

void Ppo::ValueGradient(std::span<const uint32_t> rows, Share& share) {
  Clear(share.value.output_gradient, 1, share.observations.blocks);
  const double scale = 2.0 / static_cast<double>(rows.size());
  for (int i = 0; i < share.samples; ++i) {
    const uint32_t row = rows[static_cast<size_t>(share.first + i)];
    const double error = static_cast<double>(At(share.value.output, 0, i)) -
                         static_cast<double>(advantages_.value_target[row]);
    share.sums.value_loss += error * error;
    At(share.value.output_gradient, 0, i) = static_cast<float>(scale * error);
  }
}

void Ppo::Backward(const Share& share) {
  // The policy's first: both read the value pass's features, which its backward pass uses up.
  if (shared()) {
    MlpBackward(kernels_, policy_.head, policy_parameters_.data(), share.value.features,
                share.observations.blocks, share.policy.head, share.policy.output_gradient,
                {.parameters = share.policy.gradient}, share.policy.head_scratch);
  } else {
    BackwardPass(kernels_, policy_.encoder, policy_.head, policy_parameters_.data(), share.observations,
                 share.policy);
  }
  BackwardPass(kernels_, value_.encoder, value_.head, value_parameters_.data(), share.observations,
               share.value);
}

void Ppo::TrainShare(const TrajectoryBatch& batch, std::span<const uint32_t> rows,
                     std::span<const float> noise, int member) {
  Forward(batch, rows, member);
  Share& share = shares_[static_cast<size_t>(member)];
  if (share.samples > 0) {
    PolicyGradient(batch, rows, noise, share);
    ValueGradient(rows, share);
    Backward(share);
  }
  team_.Barrier();
  // Every thread sees the same sums and so takes the same way out; nothing has been stepped yet.
  const Sums sums = TotalSums();
  if (!std::isfinite(sums.policy_loss) || !std::isfinite(sums.value_loss)) return;
  const Trained policy = trained_policy();
  const Trained value = trained_value();
  share.policy_square = SquareOf(policy, member);
  share.value_square = SquareOf(value, member);
  team_.Barrier();
  double policy_square = 0.0, value_square = 0.0;
  for (const Share& other : shares_) {
    policy_square += other.policy_square;
    value_square += other.value_square;
  }
  const bool policy_finite = Step(policy, policy_square, member);
  share.finite = Step(value, value_square, member) && policy_finite;
  if (!shared()) return;
  team_.Barrier();
  CopyEncoder(member);
}

Ppo::Trained Ppo::trained_policy() {
  return {shared() ? policy_.head_range : nn::Range{0, policy_.layout.size()}, policy_parameters_,
          policy_moments_, policy_gradients_, config_.algorithm.actor_learning_rate};
}

Ppo::Trained Ppo::trained_value() {
  return {nn::Range{0, value_.layout.size()}, value_parameters_, value_moments_, value_gradients_,
          config_.algorithm.critic_learning_rate};
}

// Of this thread's part of the gradient, which is the sum over threads.
double Ppo::SquareOf(const Trained& network, int member) const {
  if (config_.algorithm.max_gradient_norm <= 0.0) return 0.0;
  const nn::Range part = nn::ShareOf(network.range, member, team_.size());
  std::array<double, kLanes> squares{};
  for (size_t i = part.first; i < part.first + part.count; i += kLanes) {
    std::array<double, kLanes> sums{};
    for (const float* gradient : network.gradients) {
      for (size_t lane = 0; lane < kLanes; ++lane) sums[lane] += static_cast<double>(gradient[i + lane]);
    }
    for (size_t lane = 0; lane < kLanes; ++lane) squares[lane] += sums[lane] * sums[lane];
  }
  return std::accumulate(squares.begin(), squares.end(), 0.0);
}

// Steps this thread's part; false when a parameter of it is no longer finite.
bool Ppo::Step(const Trained& network, double square, int member) {
  constexpr double kGuard = 1e-6;  // against division by zero
  const nn::Range part = nn::ShareOf(network.range, member, team_.size());
  const double most = config_.algorithm.max_gradient_norm;
  const double scale = most > 0.0 ? most / (std::sqrt(square) + kGuard) : 1.0;
  if (scale < 1.0) {
    for (float* gradient : network.gradients) {
      for (size_t i = part.first; i < part.first + part.count; ++i) gradient[i] *= static_cast<float>(scale);
    }
  }
  return nn::ApplyAdam(kernels_,
                       {.learning_rate = network.learning_rate, .epsilon = config_.algorithm.adam_epsilon},
                       {.range = part,
                        .parameters = network.parameters.data() + part.first,
                        .moments = &network.moments,
                        .gradients = network.gradients,
                        .step = steps_ + 1});
}

// The policy's encoder is the value's: both layouts begin with it.
void Ppo::CopyEncoder(int member) {
  const nn::Range part = nn::ShareOf(policy_.encoder_range, member, team_.size());
  std::copy_n(value_parameters_.data() + part.first, part.count, policy_parameters_.data() + part.first);
}

}  // namespace dadrl
