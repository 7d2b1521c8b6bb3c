#include "learner/batch_fetcher.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <utility>

#include "common/step/step_spec_of.h"
#include "common/util/log.h"
#include "common/util/shown.h"
#include "proto/experience_bounds.h"

namespace dadrl {
namespace {

// How long the thread sleeps at most, so that it notices a replay that appears or leaves.
constexpr Duration kLongestWait = std::chrono::milliseconds(50);
// One line for a burst of garbage, not one each.
constexpr Duration kLogInterval = std::chrono::seconds(5);

// Batches that may be under way or ready (RequestBook), and the one in training.
size_t SlotCount(const Config& config) {
  return static_cast<size_t>(config.learner.credits) * static_cast<size_t>(config.replay.shards) + 1;
}

// Whether replays of this configuration serve batches of `shape` as they should.
Status CheckServed(const Config& config, const TrajectoryShape& shape) {
  const ReplayConfig& replay = config.replay;
  if (shape.all_observations && shape.steps > replay.sequence_length) {
    return Fail(ErrorCode::kInvalidArgument,
                "replay.sequence_length: {} is shorter than the {} decisions that this learner trains on; "
                "raise it, to at most {}",
                replay.sequence_length, shape.steps, kMaxTrajectorySteps);
  }
  if (!shape.all_observations && replay.sequence_period != 1) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.sequence_period: {} lets only every {}th frame be sampled, and this learner trains on "
        "transitions; set it to 1",
        replay.sequence_period, replay.sequence_period);
  }
  return {};
}

void Count(std::atomic<uint64_t>& counter, uint64_t by = 1) {
  counter.fetch_add(by, std::memory_order_relaxed);
}

}  // namespace

Result<std::unique_ptr<BatchFetcher>> BatchFetcher::Create(const Transport& transport, const Config& config,
                                                           const TrajectoryShape& shape, uint64_t incarnation,
                                                           std::function<uint32_t()> newest_version,
                                                           const Clock& clock, const FetchOptions& options) {
  DADRL_RETURN_IF_ERROR(CheckServed(config, shape));
  Endpoints endpoints;
  DADRL_ASSIGN_OR_RETURN(endpoints.requests,
                         Writer<dadrl_idl_BatchRequest>::Create(transport, kBatchRequestTopic));
  DADRL_ASSIGN_OR_RETURN(endpoints.replies,
                         Reader<dadrl_idl_BatchReply>::Create(transport, kBatchReplyTopic));
  DADRL_ASSIGN_OR_RETURN(
      endpoints.priorities,
      PrioritySender::Create(transport, incarnation, ExperienceBounds::From(config).priority));
  return std::unique_ptr<BatchFetcher>(new BatchFetcher(std::move(endpoints), config, shape, incarnation,
                                                        std::move(newest_version), clock, options));
}

BatchFetcher::BatchFetcher(Endpoints endpoints, const Config& config, const TrajectoryShape& shape,
                           uint64_t incarnation, std::function<uint32_t()> newest_version, const Clock& clock,
                           const FetchOptions& options)
    : endpoints_(std::move(endpoints)),
      config_(config),
      shape_(shape),
      schema_(SchemaHash(StepSpecOf(config))),
      incarnation_(incarnation),
      newest_version_(std::move(newest_version)),
      options_(options),
      clock_(clock),
      ready_(SlotCount(config)),
      free_(SlotCount(config)),
      inserted_(static_cast<size_t>(config.replay.shards)),
      book_(config.replay.shards, config.learner.credits, options.request_timeout),
      decoder_(StepSpecOf(config), ExperienceBounds::From(config)) {
  for (size_t i = 0; i < SlotCount(config); ++i) {
    slots_.push_back(std::make_unique<Slot>(Slot{TrajectoryBatch(StepSpecOf(config), shape), 0}));
    free_.PushOrDrop(slots_.back().get());  // has room for all
  }
}

void BatchFetcher::Start() {
  endpoints_.priorities->Start();
  thread_ = std::thread([this] {
    while (!stopping_.load()) Fetch();
  });
}

BatchFetcher::~BatchFetcher() {
  stopping_.store(true);
  if (!thread_.joinable()) return;
  endpoints_.replies->Wake();
  thread_.join();
}

TrajectoryBatch* BatchFetcher::Take(Duration timeout) {
  const std::optional<Slot*> slot = ready_.Pop(timeout);
  if (!slot) return nullptr;
  endpoints_.replies->Wake();  // a credit is free
  return &(*slot)->batch;
}

void BatchFetcher::Release(TrajectoryBatch* batch) {
  free_.PushOrDrop(&SlotOf(*batch));  // has room for all
}

void BatchFetcher::UpdatePriorities(const TrajectoryBatch& batch, std::span<const float> td_error) {
  endpoints_.priorities->Send(SlotOf(batch).shard, batch.keys, td_error);
}

BatchFetcher::Slot& BatchFetcher::SlotOf(const TrajectoryBatch& batch) {
  const auto slot = std::find_if(slots_.begin(), slots_.end(),
                                 [&](const auto& candidate) { return &candidate->batch == &batch; });
  assert(slot != slots_.end());
  return **slot;
}

FetchStats BatchFetcher::stats() const {
  return {.batches = batches_.load(),
          .bytes = bytes_.load(),
          .corrupt = corrupt_.load(),
          .stale = stale_.load(),
          .foreign = foreign_.load(),
          .repeated = repeated_.load(),
          .given_up = given_up_.load(),
          .dropped_priorities = endpoints_.priorities->dropped(),
          .frames_held = frames_held_.load(),
          .frames_inserted = frames_inserted_.load()};
}

void BatchFetcher::Step() {
  endpoints_.priorities->Step();
  if (!stopping_.load()) Fetch();
}

void BatchFetcher::Fetch() {
  RepeatAfterRematch();
  SendDue();
  UpdateReasonToWait();
  endpoints_.replies->Wait(WaitTime());
  endpoints_.replies->Take(std::ssize(slots_), [this](const dadrl_idl_BatchReply& reply) { OnReply(reply); });
}

Duration BatchFetcher::WaitTime() const {
  if (!can_ask()) return kLongestWait;
  const TimePoint now = clock_.Now();
  return std::clamp<Duration>(book_.next_due(now) - now, Duration::zero(), kLongestWait);
}

// A request that nobody reads, or that cannot be answered, is lost: hold it.
bool BatchFetcher::can_ask() const { return endpoints_.requests->matched() > 0 && matched_repliers_ > 0; }

// A shard came back: what it was asked before is forgotten there. Either side may be the last to be matched.
void BatchFetcher::RepeatAfterRematch() {
  const uint64_t generation = endpoints_.requests->match_generation();
  const int repliers = endpoints_.replies->matched();
  if (generation != match_generation_ || repliers > matched_repliers_) book_.RepeatAll();
  match_generation_ = generation;
  matched_repliers_ = repliers;
}

void BatchFetcher::SendDue() {
  if (!can_ask()) return;
  for (const RequestBook::Request& request : book_.Due(clock_.Now(), std::ssize(ready_))) {
    dadrl_idl_BatchRequest sample{};
    sample.shard = request.shard;
    sample.learner = incarnation_;
    sample.request = request.number;
    sample.oldest_open = book_.oldest_open(request.shard);
    sample.protocol = kProtocolVersion;
    sample.trajectories = static_cast<uint32_t>(shape_.count);
    sample.steps = static_cast<uint32_t>(shape_.steps);
    sample.all_observations = shape_.all_observations;
    sample.schema = schema_;
    sample.policy_version = newest_version_();
    // What could not be sent is repeated when its time-out passes.
    const Status sent = endpoints_.requests->Write(sample);
    if (!sent) spdlog::warn("batch request to replay {}: {}", request.shard, sent.error().message);
  }
  repeated_.store(book_.repeated(), std::memory_order_relaxed);
  given_up_.store(book_.given_up(), std::memory_order_relaxed);
}

void BatchFetcher::OnReply(const dadrl_idl_BatchReply& reply) {
  if (reply.learner != incarnation_ || std::cmp_greater_equal(reply.shard, config_.replay.shards)) {
    Count(foreign_);
    return;
  }
  Count(bytes_, reply.bytes._length);
  const RequestBook::Request request{reply.shard, reply.request};
  const bool expected = reply.bytes._length == 0 ? book_.OnWithheld(request, reply.frames_held, clock_.Now())
                                                 : book_.OnReply(request, reply.frames_held);
  if (!expected) {
    Count(stale_);
    return;
  }
  frames_held_.store(book_.frames_held(), std::memory_order_relaxed);
  inserted_[reply.shard] = reply.frames_inserted;
  frames_inserted_.store(std::accumulate(inserted_.begin(), inserted_.end(), uint64_t{0}),
                         std::memory_order_relaxed);
  if (reply.refusal[0] != '\0') return OnRefusal(reply);
  if (reply.bytes._length > 0) Decode(reply);
}

// Asking again would not help: this is the end of it.
void BatchFetcher::OnRefusal(const dadrl_idl_BatchReply& reply) {
  MutexLock lock(mutex_);
  status_ = Fail(ErrorCode::kInvalidArgument, "replay {} refuses to serve this learner: {}", reply.shard,
                 Shown(reply.refusal, sizeof(reply.refusal)));
  stopping_.store(true);
}

Status BatchFetcher::status() const {
  MutexLock lock(mutex_);
  return status_;
}

void BatchFetcher::Decode(const dadrl_idl_BatchReply& reply) {
  // Credits bound what is under way, so one is free.
  const std::optional<Slot*> free = free_.Pop(Duration::zero());
  if (!free) return Count(stale_);
  Slot* slot = *free;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(reply.bytes._buffer, reply.bytes._length));
  const Status decoded = decoder_.Decode(bytes, slot->batch);
  if (!decoded) {
    free_.PushOrDrop(slot);
    DropCorrupt(reply, decoded.error());
    return;
  }
  slot->shard = reply.shard;
  Count(batches_);
  ready_.PushOrDrop(slot);  // has room for all
}

void BatchFetcher::DropCorrupt(const dadrl_idl_BatchReply& reply, const Error& error) {
  Count(corrupt_);
  const TimePoint now = clock_.Now();
  book_.HoldOff(now + options_.corrupt_pause);
  if (corrupt_logged_at_ != TimePoint{} && now - corrupt_logged_at_ < kLogInterval) return;
  corrupt_logged_at_ = now;
  spdlog::warn("dropped a batch of replay {} ({} so far): {}", reply.shard, corrupt_.load(), error.message);
}

void BatchFetcher::UpdateReasonToWait() {
  Activity reason = Activity::kWaitForBatch;
  if (!can_ask()) {
    reason = Activity::kWaitForReplay;
  } else if (book_.all_withheld()) {
    reason = Activity::kWaitForInserts;
  }
  waiting_for_.store(reason, std::memory_order_relaxed);
}

}  // namespace dadrl
