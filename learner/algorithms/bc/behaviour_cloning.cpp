#include "learner/algorithms/bc/behaviour_cloning.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/util/random.h"

namespace dadrl {

using nn::kLanes;

namespace {

constexpr std::array kScalars = {ScalarSpec{"action_error", "loss/action_error"}};

int Blocks(int samples) { return (samples + kLanes - 1) / kLanes; }

}  // namespace

BehaviourCloning::Share::Share(nn::Arena& arena, const PolicyNetwork& network, int blocks)
    : observations(arena, network.encoder.spec, blocks),
      pass(arena, network.encoder, network.head, network.layout.size(), blocks) {}

std::vector<BehaviourCloning::Share> BehaviourCloning::MakeShares(nn::Arena& arena,
                                                                  const PolicyNetwork& network, int batch,
                                                                  int threads) {
  const int blocks = (Blocks(batch) + threads - 1) / threads;
  nn::Arena measure;
  const Share measured(measure, network, blocks);
  arena = nn::Arena(measure.used() * static_cast<size_t>(threads));
  std::vector<Share> shares;
  for (int i = 0; i < threads; ++i) shares.emplace_back(arena, network, blocks);
  return shares;
}

AlgorithmSpec BehaviourCloning::SpecOf(const Config& config) {
  return {.batch = {.count = config.algorithm.batch_size}, .scalars = kScalars};
}

BehaviourCloning::BehaviourCloning(const Config& config)
    : config_(config),
      declared_(SpecOf(config)),
      network_(DrivingShape::From(config.observation), config.model),
      kernels_(nn::LaneKernelsFor(ActiveIsa())),
      parameters_(network_.layout.size()),
      moments_(network_.layout.size()),
      padded_(nn::RoundUp(static_cast<size_t>(config.algorithm.batch_size), kLanes) *
              DrivingShape::kContextBytes),
      shares_(MakeShares(arena_, network_, config.algorithm.batch_size, config.learner.threads)),
      team_(config.learner.threads) {
  network_.layout.Initialize(DeriveSeed(config.seed, 1), parameters_.span());
  for (Share& share : shares_) gradients_.push_back(share.pass.gradient);
}

std::vector<NamedNetwork> BehaviourCloning::networks() const {
  return {{kPolicyNetwork, network_.layout.hash(), parameters_.span()}};
}

std::vector<StateBlock> BehaviourCloning::state() {
  return {{"policy", parameters_.bytes()},
          {"policy.adam_first", moments_.first.bytes()},
          {"policy.adam_second", moments_.second.bytes()},
          {"updates", std::as_writable_bytes(std::span(&updates_, 1))}};
}

Status BehaviourCloning::Update(const TrajectoryBatch& batch) {
  const std::span<const uint8_t> planes = batch.ObservationsAt(0).bits(network_.encoder.spec.context_column);
  const uint8_t* context = planes.data();
  if (batch.shape.count % kLanes != 0) {
    std::ranges::fill(std::ranges::copy(planes, padded_.begin()).out, padded_.end(), uint8_t{0});
    context = padded_.data();
  }
  auto work = [&](int member) { UpdateShare(batch, context, member); };
  team_.Run(work);
  scalars_[0] = TotalLoss() / batch.shape.count;
  const bool finite = std::ranges::all_of(shares_, &Share::finite);
  if (!std::isfinite(scalars_[0]) || !finite) {
    return Fail(
        ErrorCode::kInternal, "{} is not finite in update {}",
        finite ? std::string_view("the action error") : network_.layout.FirstNonFinite(parameters_.span()),
        updates_ + 1);
  }
  ++updates_;
  return {};
}

void BehaviourCloning::UpdateShare(const TrajectoryBatch& batch, const uint8_t* context, int member) {
  Share& share = shares_[static_cast<size_t>(member)];
  const int blocks = Blocks(batch.shape.count);
  const int first = blocks * member / team_.size();
  const int count = blocks * (member + 1) / team_.size() - first;
  share.first = first * kLanes;
  share.samples = std::clamp(batch.shape.count - share.first, 0, count * kLanes);
  share.loss = 0.0;
  share.finite = true;
  if (share.samples > 0) {
    share.observations.blocks = count;
    share.observations.Pack(kernels_, batch.ObservationsAt(0),
                            context + ptrdiff_t{share.first} * DrivingShape::kContextBytes, first);
    Backpropagate(share, batch.DecisionsAt(0, 0), batch.shape.count);
  }
  team_.Barrier();
  // Every thread sees the same sum and so takes the same way out; nothing has been stepped yet.
  if (!std::isfinite(TotalLoss())) return;
  const nn::Range range = nn::ShareOf({0, network_.layout.size()}, member, team_.size());
  share.finite = nn::ApplyAdam(
      kernels_,
      {.learning_rate = config_.algorithm.actor_learning_rate, .epsilon = config_.algorithm.adam_epsilon},
      {.range = range,
       .parameters = parameters_.data() + range.first,
       .moments = &moments_,
       .gradients = gradients_,
       .step = updates_ + 1});
}

void BehaviourCloning::Backpropagate(Share& share, std::span<const float> actions, int batch_size) {
  const float* parameters = parameters_.data();
  const int blocks = share.observations.blocks;
  const NetworkPass& pass = share.pass;
  ForwardPass(kernels_, network_.encoder, network_.head, parameters, share.observations, pass);
  for (int b = 0; b < blocks; ++b) {
    std::memset(pass.output_gradient.block(b), 0, sizeof(float) * 2 * kActionSize * kLanes);
  }
  for (int i = 0; i < share.samples; ++i) {
    for (int d = 0; d < kActionSize; ++d) {
      const int at = d * kLanes + i % kLanes;
      const float action = std::tanh(pass.output.block(i / kLanes)[at]);
      const float error = action - actions[static_cast<size_t>((share.first + i) * kActionSize + d)];
      share.loss += double{error} * double{error};
      pass.output_gradient.block(i / kLanes)[at] = 2.0f * error * (1.0f - action * action) / batch_size;
    }
  }
  BackwardPass(kernels_, network_.encoder, network_.head, parameters, share.observations, pass);
}

double BehaviourCloning::TotalLoss() const {
  double sum = 0.0;
  for (const Share& share : shares_) sum += share.loss;
  return sum;
}

}  // namespace dadrl
