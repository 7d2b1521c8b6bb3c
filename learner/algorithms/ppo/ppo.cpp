#include "learner/algorithms/ppo/ppo.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/util/random.h"

namespace dadrl {

using nn::kLanes;

namespace {

// In the order in which Report fills them.
constexpr std::array kScalars = {
    ScalarSpec{"policy_loss", "loss/policy"},
    ScalarSpec{"value_loss", "loss/value", ScalarKind::kSquaredError},
    ScalarSpec{"entropy", "policy/entropy"},        // estimate, -mean log pi
    ScalarSpec{"divergence", "policy/divergence"},  // Kullback-Leibler, from the policies that acted, nats
    ScalarSpec{"clip_fraction", "policy/clip_fraction"},
    ScalarSpec{"mean_value", "value/mean_value", ScalarKind::kValue},
    ScalarSpec{"mean_return", "value/mean_return", ScalarKind::kValue},  // of the value targets
    ScalarSpec{"explained_variance", "value/explained_variance"},        // of them, by the values
};
constexpr std::array<std::string_view, 1> kDecisions = {"log_probability"};

int Blocks(int samples) { return (samples + kLanes - 1) / kLanes; }

// Trajectories of a rollout.
int Count(const Config& config) {
  return std::max(1, config.algorithm.rollout / std::max(1, config.replay.sequence_length));
}

// Of a run that records it (CheckNeeds).
size_t LogProbabilityColumn(const Config& config) {
  return FindColumn(DrivingStepSpec(config).decision, kDecisions[0], ElementType::kFloat32, 0).value_or(0);
}

}  // namespace

void Ppo::Sums::Add(const Sums& other) {
  policy_loss += other.policy_loss;
  value_loss += other.value_loss;
  log_probability += other.log_probability;
  divergence += other.divergence;
  clipped += other.clipped;
}

Ppo::Share::Share(nn::Arena& arena, const PolicyNetwork& policy_network, const ValueNetwork& value_network,
                  int blocks)
    : observations(arena, policy_network.encoder.spec, blocks),
      policy(arena, policy_network.encoder, policy_network.head, policy_network.layout.size(), blocks),
      value(arena, value_network.encoder, value_network.head, value_network.layout.size(), blocks) {}

std::vector<Ppo::Share> Ppo::MakeShares(nn::Arena& arena, const PolicyNetwork& policy,
                                        const ValueNetwork& value, int batch, int threads) {
  const int blocks = (Blocks(batch) + threads - 1) / threads;
  nn::Arena measure;
  const Share measured(measure, policy, value, blocks);
  arena = nn::Arena(measure.used() * static_cast<size_t>(threads));
  std::vector<Share> shares;
  for (int i = 0; i < threads; ++i) shares.emplace_back(arena, policy, value, blocks);
  return shares;
}

AlgorithmSpec Ppo::SpecOf(const Config& config) {
  return {.batch = {.count = Count(config),
                    .steps = std::max(1, config.replay.sequence_length),
                    .all_observations = true},
          .scalars = kScalars,
          .acts_from_start = true,
          .on_policy = true,
          .decisions = kDecisions};
}

Ppo::Ppo(const Config& config, std::unique_ptr<NoiseSource> noise)
    : config_(config),
      declared_(SpecOf(config)),
      policy_(DrivingShape::From(config.observation), config.model),
      value_(DrivingShape::From(config.observation), config.model),
      log_probability_column_(LogProbabilityColumn(config)),
      kernels_(nn::LaneKernelsFor(ActiveIsa())),
      limits_{config.model.log_std_min, config.model.log_std_max},
      policy_parameters_(policy_.layout.size()),
      value_parameters_(value_.layout.size()),
      policy_moments_(policy_.layout.size()),
      value_moments_(value_.layout.size()),
      noise_source_(noise ? std::move(noise) : std::make_unique<GaussianNoise>(DeriveSeed(config.seed, 3))),
      minibatch_(DrivingStepSpec(config), Blocks(config.algorithm.batch_size) * kLanes),
      shares_(MakeShares(arena_, policy_, value_, config.algorithm.batch_size, config.learner.threads)),
      team_(config.learner.threads) {
  policy_.layout.Initialize(DeriveSeed(config.seed, 1), policy_parameters_.span());
  value_.layout.Initialize(DeriveSeed(config.seed, 2), value_parameters_.span());
  if (shared()) {
    std::copy_n(value_parameters_.data(), policy_.encoder_range.count, policy_parameters_.data());
  }
  for (Share& share : shares_) {
    policy_gradients_.push_back(share.policy.gradient);
    value_gradients_.push_back(share.value.gradient);
  }
  const auto count = static_cast<size_t>(declared_.batch.count);
  const size_t steps = count * static_cast<size_t>(declared_.batch.steps);
  rows_.reserve(steps);
  seen_rows_.reserve(steps + count);
  order_.reserve(steps);
  order_noise_.resize(steps);
  action_noise_.resize(steps * kActionSize);
  values_.resize(steps + count);
  ratios_.resize(steps);
  advantages_.advantage.reserve(steps);
  advantages_.value_target.reserve(steps);
}

std::vector<NamedNetwork> Ppo::networks() const {
  return {{kPolicyNetwork, policy_.layout.hash(), policy_parameters_.span()}};
}

std::vector<StateBlock> Ppo::state() {
  return {{"policy", policy_parameters_.bytes()},
          {"value", value_parameters_.bytes()},
          {"policy.adam_first", policy_moments_.first.bytes()},
          {"policy.adam_second", policy_moments_.second.bytes()},
          {"value.adam_first", value_moments_.first.bytes()},
          {"value.adam_second", value_moments_.second.bytes()},
          {"steps", std::as_writable_bytes(std::span(&steps_, 1))},
          {"random", noise_source_->state()}};
}

Status Ppo::CheckBatch(const TrajectoryBatch& batch) const {
  if (batch.shape != declared_.batch || batch.decisions.size() <= log_probability_column_) {
    return Fail(ErrorCode::kInvalidArgument,
                "batch of {} trajectories of {} decisions; {} of {} with all observations and {} are needed",
                batch.shape.count, batch.shape.steps, declared_.batch.count, declared_.batch.steps,
                kDecisions[0]);
  }
  const std::pair<const char*, std::span<const float>> tensors[] = {
      {"observation.vehicles", batch.observations.floats(policy_.encoder.spec.vehicles_column)},
      {"observation.ego", batch.observations.floats(policy_.encoder.spec.ego_column)},
      {"action", batch.decisions[0]},
      {"log_probability", batch.decisions[log_probability_column_]},
      {"reward", batch.rewards}};
  for (const auto& [name, values] : tensors) {
    if (nn::AllFinite(values)) continue;
    return Fail(ErrorCode::kInternal, "batch tensor {} has a value that is not finite", name);
  }
  return {};
}

void Ppo::FindRows(const TrajectoryBatch& batch) {
  rows_.clear();
  seen_rows_.clear();
  const auto count = static_cast<uint32_t>(batch.shape.count);
  for (uint32_t t = 0; std::cmp_less_equal(t, batch.shape.steps); ++t) {
    for (uint32_t b = 0; b < count; ++b) {
      if (std::cmp_less(t, batch.steps[b])) rows_.push_back(t * count + b);
      if (std::cmp_less_equal(t, batch.steps[b])) seen_rows_.push_back(t * count + b);
    }
  }
}

Status Ppo::Update(const TrajectoryBatch& batch) {
  DADRL_RETURN_IF_ERROR(CheckBatch(batch));
  FindRows(batch);
  Evaluate(batch);
  EstimateAdvantages(batch, values_, ratios_, config_.algorithm.gamma, config_.algorithm.gae_lambda,
                     advantages_);
  NormaliseAdvantages();
  sums_ = {};
  trained_ = 0.0;
  for (int epoch = 0; epoch < config_.algorithm.epochs; ++epoch) {
    DADRL_RETURN_IF_ERROR(TrainEpoch(batch));
  }
  Report();
  return {};
}

void Ppo::Evaluate(const TrajectoryBatch& batch) {
  const auto most = static_cast<size_t>(config_.algorithm.batch_size);
  for (size_t first = 0; first < seen_rows_.size(); first += most) {
    const auto rows =
        std::span<const uint32_t>(seen_rows_).subspan(first).first(std::min(most, seen_rows_.size() - first));
    auto work = [&](int member) {
      Forward(batch, rows, member);
      Record(batch, rows, shares_[static_cast<size_t>(member)]);
    };
    team_.Run(work);
  }
}

// To mean 0 and standard deviation 1 over the rollout's steps.
void Ppo::NormaliseAdvantages() {
  constexpr double kLeastDeviation = 1e-8;
  const auto count = static_cast<double>(rows_.size());
  double sum = 0.0;
  for (const uint32_t row : rows_) sum += static_cast<double>(advantages_.advantage[row]);
  const double mean = sum / count;
  double squares = 0.0;
  for (const uint32_t row : rows_) {
    const double distance = static_cast<double>(advantages_.advantage[row]) - mean;
    squares += distance * distance;
  }
  const double scale = 1.0 / (std::sqrt(squares / count) + kLeastDeviation);
  for (const uint32_t row : rows_) {
    advantages_.advantage[row] =
        static_cast<float>((static_cast<double>(advantages_.advantage[row]) - mean) * scale);
  }
}

// Minibatches are as equal as they can be: none is a small rest.
Status Ppo::TrainEpoch(const TrajectoryBatch& batch) {
  const size_t count = rows_.size();
  const auto order_noise = std::span(order_noise_).first(count);
  noise_source_->Fill(order_noise);
  noise_source_->Fill(std::span(action_noise_).first(count * kActionSize));
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  std::ranges::sort(order_, {}, [&](uint32_t place) { return std::pair(order_noise[place], place); });
  for (uint32_t& place : order_) place = rows_[place];
  const auto most = static_cast<size_t>(config_.algorithm.batch_size);
  const size_t minibatches = (count + most - 1) / most;
  for (size_t i = 0; i < minibatches; ++i) {
    const size_t first = count * i / minibatches;
    const size_t size = count * (i + 1) / minibatches - first;
    const auto rows = std::span<const uint32_t>(order_).subspan(first, size);
    const auto noise = std::span<const float>(action_noise_).subspan(first * kActionSize, size * kActionSize);
    auto work = [&](int member) { TrainShare(batch, rows, noise, member); };
    team_.Run(work);
    DADRL_RETURN_IF_ERROR(CheckFinite());
    ++steps_;
    sums_.Add(TotalSums());
    trained_ += static_cast<double>(size);
  }
  return {};
}

Status Ppo::CheckFinite() const {
  const Sums sums = TotalSums();
  for (const auto& [name, loss] :
       {std::pair("policy loss", sums.policy_loss), std::pair("value loss", sums.value_loss)}) {
    if (!std::isfinite(loss)) {
      return Fail(ErrorCode::kInternal, "{} is not finite ({}) in step {}", name, loss, steps_ + 1);
    }
  }
  if (std::ranges::all_of(shares_, &Share::finite)) return {};
  const std::string_view policy = policy_.layout.FirstNonFinite(policy_parameters_.span());
  const std::string_view value = value_.layout.FirstNonFinite(value_parameters_.span());
  return Fail(ErrorCode::kInternal, "parameter {} {} is not finite after step {}",
              policy.empty() ? "value" : "policy", policy.empty() ? value : policy, steps_ + 1);
}

void Ppo::Report() {
  const auto count = static_cast<double>(rows_.size());
  double values = 0.0, targets = 0.0, target_squares = 0.0, errors = 0.0, error_squares = 0.0;
  for (const uint32_t row : rows_) {
    const auto value = static_cast<double>(values_[row]);
    const auto target = static_cast<double>(advantages_.value_target[row]);
    values += value;
    targets += target;
    target_squares += target * target;
    errors += target - value;
    error_squares += (target - value) * (target - value);
  }
  const double variance = target_squares / count - targets / count * (targets / count);
  const double unexplained = error_squares / count - errors / count * (errors / count);
  scalars_ = {sums_.policy_loss / trained_,
              sums_.value_loss / trained_,
              -sums_.log_probability / trained_,
              sums_.divergence / trained_,
              sums_.clipped / trained_,
              values / count,
              targets / count,
              variance > 0.0 ? 1.0 - unexplained / variance : std::nan("")};
  static_assert(kScalars.size() == std::tuple_size_v<decltype(scalars_)>);
}

Ppo::Sums Ppo::TotalSums() const {
  Sums total;
  for (const Share& share : shares_) total.Add(share.sums);
  return total;
}

}  // namespace dadrl
