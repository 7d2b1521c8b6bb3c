#include "learner/algorithms/sac.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "learner/algorithms/sac_losses.h"

namespace dadrl {

using nn::kLanes;

namespace {

// In the order in which Finish fills them.
constexpr std::array kScalars = {
    ScalarSpec{"critic_loss", "loss/critic", ScalarKind::kSquaredError},
    ScalarSpec{"actor_loss", "loss/actor"},
    ScalarSpec{"temperature_loss", "loss/temperature"},
    ScalarSpec{"temperature", "policy/temperature", ScalarKind::kTemperature},
    ScalarSpec{"entropy", "policy/entropy"},  // estimate, -mean log pi
    ScalarSpec{"mean_q", "value/mean_q", ScalarKind::kValue},
    ScalarSpec{"mean_target", "value/mean_target", ScalarKind::kValue},
};

int Blocks(int samples) { return (samples + kLanes - 1) / kLanes; }

std::vector<SacWorkspace> MakeWorkspaces(nn::Arena& arena, const PolicyNetwork& policy,
                                         const CriticNetwork& critic, const DrivingShape& spec, int blocks,
                                         int views, int threads) {
  const int share = (blocks + threads - 1) / threads;
  nn::Arena measure;
  const SacWorkspace measured(measure, policy, critic, spec, share, views);
  arena = nn::Arena(measure.used() * static_cast<size_t>(threads));
  std::vector<SacWorkspace> workspaces;
  workspaces.reserve(static_cast<size_t>(threads));
  for (int i = 0; i < threads; ++i) workspaces.emplace_back(arena, policy, critic, spec, share, views);
  return workspaces;
}

}  // namespace

Sac::Sac(const Config& config, std::unique_ptr<NoiseSource> noise)
    : config_(config),
      declared_(SpecOf(config)),
      spec_(DrivingShape::From(config.observation)),
      policy_(spec_, config.model),
      critic_(spec_, config.model),
      kernels_(nn::LaneKernelsFor(ActiveIsa())),
      limits_{config.model.log_std_min, config.model.log_std_max},
      policy_parameters_(policy_.layout.size()),
      average_parameters_(policy_.layout.size()),
      critic_parameters_(critic_.layout.size()),
      target_parameters_(critic_.layout.size()),
      policy_moments_(policy_.layout.size()),
      critic_moments_(critic_.layout.size()),
      log_alpha_{.value = std::log(config.algorithm.initial_temperature)},
      returns_(config.algorithm.gamma, config.algorithm.batch_size),
      noise_source_(noise ? std::move(noise) : std::make_unique<GaussianNoise>(DeriveSeed(config.seed, 3))),
      workspaces_(MakeWorkspaces(arena_, policy_, critic_, spec_, Blocks(config.algorithm.batch_size),
                                 views(), config.learner.threads)),
      team_(config.learner.threads) {
  policy_.layout.Initialize(DeriveSeed(config.seed, 1), policy_parameters_.span());
  critic_.layout.Initialize(DeriveSeed(config.seed, 2), critic_parameters_.span());
  if (shared()) {
    std::copy_n(critic_parameters_.data(), policy_.encoder_range.count, policy_parameters_.data());
  }
  std::ranges::copy(policy_parameters_.span(), average_parameters_.data());
  std::ranges::copy(critic_parameters_.span(), target_parameters_.data());
  const auto batch_size = static_cast<size_t>(config.algorithm.batch_size);
  const size_t draws = batch_size * kActionSize;
  next_noise_.resize(static_cast<size_t>(views()) * draws);
  now_noise_.resize(draws);
  if (views() > 1) now_shifts_.resize(static_cast<size_t>(views()) * draws);
  next_shifts_.resize(now_shifts_.size());
  td_error_.resize(batch_size);
  const size_t context = nn::RoundUp(batch_size, kLanes) * DrivingShape::kContextBytes;
  padded_now_.resize(context);
  padded_next_.resize(context);
  for (SacWorkspace& workspace : workspaces_) {
    policy_gradients_.push_back(workspace.policy_gradient);
    critic_gradients_.insert(critic_gradients_.end(), workspace.critic_gradients.begin(),
                             workspace.critic_gradients.end());
  }
}

void Sac::EncoderChanged() {
  if (shared()) std::ranges::copy(encoder_parameters(), policy_parameters_.data());
}

AlgorithmSpec Sac::SpecOf(const Config& config) {
  return {.batch = {.count = config.algorithm.batch_size, .steps = config.algorithm.n_step},
          .scalars = kScalars,
          .gives_priorities = true,
          .acts_from_start = false};
}

std::vector<NamedNetwork> Sac::networks() const {
  const bool averaged = config_.learner.publish == PublishedPolicy::kAveraged;
  const nn::FloatBuffer& published = averaged ? average_parameters_ : policy_parameters_;
  return {{kPolicyNetwork, policy_.layout.hash(), published.span()},
          {kCriticNetwork, critic_.layout.hash(), critic_parameters_.span()}};
}

std::vector<StateBlock> Sac::state() {
  return {{"policy", policy_parameters_.bytes()},
          {"policy_average", average_parameters_.bytes()},
          {"critic", critic_parameters_.bytes()},
          {"target", target_parameters_.bytes()},
          {"policy.adam_first", policy_moments_.first.bytes()},
          {"policy.adam_second", policy_moments_.second.bytes()},
          {"critic.adam_first", critic_moments_.first.bytes()},
          {"critic.adam_second", critic_moments_.second.bytes()},
          {"temperature", std::as_writable_bytes(std::span(&log_alpha_, 1))},
          {"updates", std::as_writable_bytes(std::span(&updates_, 1))},
          {"random", noise_source_->state()}};
}

Status Sac::CheckBatch(const Transitions& batch) const {
  if (batch.size() < 1 || batch.size() > config_.algorithm.batch_size) {
    return Fail(ErrorCode::kInvalidArgument, "batch of {} transitions: algorithm.batch_size allows 1 to {}",
                batch.size(), config_.algorithm.batch_size);
  }
  const auto rows = static_cast<size_t>(batch.size());
  for (const ColumnRows& columns : {batch.observation, batch.next_observation}) {
    if (columns.floats(spec_.vehicles_column).size() != rows * static_cast<size_t>(spec_.vehicle_floats()) ||
        columns.floats(spec_.ego_column).size() != rows * static_cast<size_t>(spec_.ego_floats()) ||
        columns.bits(spec_.context_column).size() != rows * size_t{DrivingShape::kContextBytes}) {
      return Fail(ErrorCode::kInvalidArgument,
                  "batch's observations do not fit observation.vehicles {} and observation.history {}",
                  spec_.vehicles, spec_.history);
    }
  }
  const std::pair<const char*, std::span<const float>> tensors[] = {
      {"observation.vehicles", batch.observation.floats(spec_.vehicles_column)},
      {"observation.ego", batch.observation.floats(spec_.ego_column)},
      {"next_observation.vehicles", batch.next_observation.floats(spec_.vehicles_column)},
      {"next_observation.ego", batch.next_observation.floats(spec_.ego_column)},
      {"action", batch.action},
      {"reward", batch.reward},
      {"discount", batch.discount},
      {"weight", batch.weight}};
  for (const auto& [name, values] : tensors) {
    if (!nn::AllFinite(values)) {
      return Fail(ErrorCode::kInternal, "batch tensor {} has a value that is not finite", name);
    }
  }
  return {};
}

const uint8_t* Sac::WholeBlocks(ColumnRows observations, std::vector<uint8_t>& padded) const {
  const std::span<const uint8_t> context = observations.bits(spec_.context_column);
  if (observations.rows() % kLanes == 0) return context.data();
  std::ranges::fill(std::ranges::copy(context, padded.begin()).out, padded.end(), uint8_t{0});
  return padded.data();
}

Status Sac::Update(const TrajectoryBatch& batch) { return Update(returns_.Of(batch)); }

Status Sac::Update(const Transitions& batch) {
  td_error_count_ = 0;
  DADRL_RETURN_IF_ERROR(CheckBatch(batch));
  const int size = batch.size();
  const size_t draws = static_cast<size_t>(size) * kActionSize;
  const size_t draws_of_views = static_cast<size_t>(views()) * draws;
  noise_source_->Fill(std::span(next_noise_).first(draws_of_views));
  noise_source_->Fill(std::span(now_noise_).first(draws));
  if (views() > 1) {
    noise_source_->Fill(std::span(now_shifts_).first(draws_of_views));
    noise_source_->Fill(std::span(next_shifts_).first(draws_of_views));
  }
  now_context_ = WholeBlocks(batch.observation, padded_now_);
  next_context_ = WholeBlocks(batch.next_observation, padded_next_);
  alpha_ = std::exp(log_alpha_.value);
  auto work = [&](int member) { UpdateShare(batch, member); };
  team_.Run(work);
  td_error_count_ = static_cast<size_t>(size);
  return Finish(size);
}

SacSums Sac::TotalSums() const {
  SacSums total;
  for (const SacWorkspace& workspace : workspaces_) {
    total.weighted_squares1 += workspace.sums.weighted_squares1;
    total.weighted_squares2 += workspace.sums.weighted_squares2;
    total.q += workspace.sums.q;
    total.target += workspace.sums.target;
    total.actor += workspace.sums.actor;
    total.log_probability += workspace.sums.log_probability;
  }
  return total;
}

bool Sac::AllStepsFinite() const {
  return std::ranges::all_of(workspaces_, [](const SacWorkspace& workspace) { return workspace.finite; });
}

Status Sac::Finish(int batch_size) {
  const double scale = 1.0 / batch_size;
  const SacSums sums = TotalSums();
  const double critic_loss = scale * (sums.weighted_squares1 + sums.weighted_squares2);
  const double actor_loss = scale * sums.actor;
  const double entropy = -scale * sums.log_probability;
  if (!std::isfinite(critic_loss)) {
    return Fail(ErrorCode::kInternal, "critic loss is not finite ({}) in update {}", critic_loss,
                updates_ + 1);
  }
  if (!std::isfinite(actor_loss)) {
    return Fail(ErrorCode::kInternal, "actor loss is not finite ({}) in update {}", actor_loss, updates_ + 1);
  }
  if (!AllStepsFinite()) {
    const std::string_view policy = policy_.layout.FirstNonFinite(policy_parameters_.span());
    const std::string_view critic = critic_.layout.FirstNonFinite(critic_parameters_.span());
    return Fail(ErrorCode::kInternal, "parameter {} {} is not finite after update {}",
                policy.empty() ? "critic" : "policy", policy.empty() ? critic : policy, updates_ + 1);
  }
  const double gap = config_.algorithm.target_entropy - entropy;  // mean of log pi + target entropy
  const double temperature_loss = -log_alpha_.value * gap;
  ++updates_;
  nn::ApplyAdam({.learning_rate = config_.algorithm.temperature_learning_rate,
                 .epsilon = config_.algorithm.adam_epsilon},
                -gap, updates_, log_alpha_);
  const double temperature = std::exp(log_alpha_.value);
  if (!std::isfinite(temperature)) {
    return Fail(ErrorCode::kInternal, "temperature is not finite after update {}", updates_);
  }
  scalars_ = {critic_loss, actor_loss,     temperature_loss,   temperature,
              entropy,     scale * sums.q, scale * sums.target};
  static_assert(kScalars.size() == std::tuple_size_v<decltype(scalars_)>);
  return {};
}

}  // namespace dadrl
