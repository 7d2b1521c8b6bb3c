#include "replay/service/batch_server.h"

#include <algorithm>
#include <span>
#include <string>
#include <thread>
#include <tuple>
#include <utility>

#include "common/config/validate.h"
#include "common/liveness/working_thread.h"
#include "common/util/fault.h"
#include "common/util/log.h"
#include "proto/borrowed_sequence.h"
#include "proto/trajectory_codec.h"

namespace dadrl {
namespace {

// Between two looks at the priorities, which have no wait of their own, and at a reader that is not there.
constexpr Duration kWait = std::chrono::milliseconds(10);
constexpr auto kMaxReplyBytes = static_cast<size_t>(kMaxBatchBytes);

// Before the memory for it is taken.
Status CheckSendable(const TrajectoryShape& shape, size_t bytes) {
  if (bytes <= kMaxReplyBytes) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "a batch of {} takes {} bytes, at most {} can be sent; lower algorithm.batch_size or "
              "replay.sequence_length",
              shape.count, bytes, kMaxReplyBytes);
}

// Of a number from outside: CheckShape refuses what is too large.
int Bounded(uint32_t value) { return static_cast<int>(std::min<uint32_t>(value, INT32_MAX)); }

}  // namespace

Result<std::unique_ptr<BatchServer>> BatchServer::Create(const Transport& transport, uint32_t shard,
                                                         ReplayTable& table, Clock& clock,
                                                         std::function<void()> on_sample) {
  Endpoints endpoints;
  DADRL_ASSIGN_OR_RETURN(endpoints.replies,
                         Writer<dadrl_idl_BatchReply>::Create(transport, kBatchReplyTopic));
  DADRL_ASSIGN_OR_RETURN(endpoints.priorities,
                         Reader<dadrl_idl_PriorityUpdate>::Create(transport, kPriorityTopic));
  DADRL_ASSIGN_OR_RETURN(endpoints.requests,
                         Reader<dadrl_idl_BatchRequest>::Create(transport, kBatchRequestTopic));
  return std::unique_ptr<BatchServer>(
      new BatchServer(std::move(endpoints), shard, table, clock, std::move(on_sample)));
}

BatchServer::BatchServer(Endpoints endpoints, uint32_t shard, ReplayTable& table, Clock& clock,
                         std::function<void()> on_sample)
    : endpoints_(std::move(endpoints)),
      shard_(shard),
      table_(table),
      clock_(clock),
      on_sample_(std::move(on_sample)),
      ledger_(clock) {}

void BatchServer::Wake() {
  if (waiting_.load()) endpoints_.requests->Wake();
}

void BatchServer::Run(const std::atomic<bool>& stop) {
  std::vector<std::thread> others;
  for (int i = 1; i < kThreads; ++i) others.emplace_back([&] { Work(stop); });
  Work(stop);
  for (std::thread& other : others) other.join();
}

void BatchServer::Work(const std::atomic<bool>& stop) {
  const WorkingThread working("serve");
  Outgoing outgoing;
  while (!stop.load()) {
    Beat();
    Step(outgoing);
  }
}

void BatchServer::Step(Outgoing& outgoing) {
  if (!outgoing.request) {
    std::optional<SampledRequest> sampled = AwaitLead();
    if (!sampled) return;
    outgoing.request = sampled->request;
    outgoing.bytes = Read(std::move(*sampled), std::move(outgoing.bytes));
  }
  if (!Send(*outgoing.request, outgoing.bytes)) return;
  MutexLock serving(serving_mutex_);
  std::erase(serving_, outgoing.request->id);
  outgoing.request.reset();
}

std::optional<BatchServer::SampledRequest> BatchServer::AwaitLead() {
  std::optional<Resting> resting(std::in_place);  // the one that leads beats
  MutexLock leading(lead_);
  resting.reset();
  return Lead();
}

std::optional<BatchServer::SampledRequest> BatchServer::Lead() {
  // While there is enough to do, what came since can wait: several at once cost little more than one.
  if (queue_.size() < kFewPending || waited_) {
    TakeRequests();
    TakePriorities();
  }
  waited_ = false;
  // Before the last look, so that an insert after it wakes us.
  waiting_.store(!queue_.empty());
  bool held = false;
  // A batch that nobody receives is lost, and its samples are spent.
  if (!queue_.empty() && endpoints_.replies->matched() > 0) {
    if (Result<SampledItems> items = SampleItems(queue_.front())) {
      ledger_.Enter(Activity::kWork);  // ends the wait; looking whether it is over does not
      SampledRequest sampled{queue_.front(), std::move(*items)};
      queue_.Pop();
      MutexLock serving(serving_mutex_);
      serving_.push_back(sampled.request.id);
      return sampled;
    }
    ReplyWithheld();
    held = true;
  }
  ledger_.Enter(held ? Activity::kWaitForInserts : Activity::kWaitForCredits);
  endpoints_.requests->Wait(kWait);
  waited_ = true;
  waiting_.store(false);
  return std::nullopt;
}

void BatchServer::TakeRequests() {
  // The analysis does not see that Take visits before it returns, under our lock.
  endpoints_.requests->Take(static_cast<int>(RequestQueue::kMaxPending),
                            [this](const dadrl_idl_BatchRequest& message)
                                DADRL_NO_THREAD_SAFETY_ANALYSIS { OnRequest(message); });
}

void BatchServer::OnRequest(const dadrl_idl_BatchRequest& message) {
  if (message.shard != shard_) return;
  const RequestId id{message.learner, message.request};
  const RequestQueue::Verdict verdict = queue_.OnArrival(id, message.oldest_open);
  if (verdict == RequestQueue::Verdict::kSuperseded) {
    return Refuse({.id = id}, fmt::format("learner {} of this run has taken over from learner {}, which ends",
                                          queue_.learner(), id.learner));
  }
  if (verdict != RequestQueue::Verdict::kNew || Serves(id)) return;
  const Request request{.id = id,
                        .shape = {.count = Bounded(message.trajectories),
                                  .steps = Bounded(message.steps),
                                  .all_observations = message.all_observations},
                        .policy_version = message.policy_version};
  if (const Status possible = Check(message, request.shape); !possible)
    return Refuse(request, possible.error().message);
  queue_.Push(request);
}

Status BatchServer::Check(const dadrl_idl_BatchRequest& message, const TrajectoryShape& shape) const {
  if (message.protocol != kProtocolVersion) {
    return Fail(ErrorCode::kInvalidArgument,
                "the learner speaks version {} of the protocol, this replay {}: one of them was built anew "
                "since the run began; start the run again",
                message.protocol, kProtocolVersion);
  }
  if (message.schema != table_.schema()) {
    return Fail(ErrorCode::kInvalidArgument,
                "the learner's steps have schema {:#x}, this replay holds {:#x}; start both with the "
                "configuration of the run",
                message.schema, table_.schema());
  }
  return table_.CheckShape(shape);
}

// Should the word of it be lost, the learner asks again.
void BatchServer::Refuse(const Request& request, const std::string& reason) {
  if (refused_.fetch_add(1) == 0) spdlog::error("refused a batch request (more are counted): {}", reason);
  std::vector<std::byte> nothing;
  if (endpoints_.replies->matched() > 0) std::ignore = Reply(request, nothing, reason);
}

void BatchServer::TakePriorities() {
  // Of a learner that was replaced: about another network.
  const uint64_t newest = queue_.learner();
  endpoints_.priorities->Take(64, [this, newest](const dadrl_idl_PriorityUpdate& message) {
    if (message.shard != shard_ || message.learner != newest) return;
    table_.UpdatePriorities({message.keys._buffer, message.keys._length},
                            {message.priorities._buffer, message.priorities._length});
  });
}

Result<SampledItems> BatchServer::SampleItems(const Request& request) {
  if (table_.MaySample(request.shape) != RateLimiter::Hold::kNone) {
    return Fail(ErrorCode::kUnavailable, "not now");
  }
  Result<SampledItems> items = table_.SampleItems(request.shape, request.policy_version);
  if (items) on_sample_();
  return items;
}

void BatchServer::ReplyWithheld() {
  std::vector<std::byte> nothing;
  for (Request& request : queue_.pending()) {
    if (request.notified) continue;
    // The rest would block in vain, too, each for the time-out of the topic, and nobody else could lead.
    if (!Reply(request, nothing)) return;
    request.notified = true;
  }
}

std::vector<std::byte> BatchServer::Read(SampledRequest sampled, std::vector<std::byte> memory) {
  const TrajectoryShape& shape = sampled.request.shape;
  const auto encode = [&]() -> Result<std::vector<std::byte>> {
    DADRL_ASSIGN_OR_RETURN(const SampledBatch batch, ReadTrajectories(std::move(sampled.items), shape));
    DADRL_RETURN_IF_ERROR(CheckSendable(shape, TrajectoriesBytes(batch.trajectories)));
    auto encoded = EncodeTrajectories(batch.trajectories, shape, table_.schema(), std::move(memory));
    DADRL_RETURN_IF_ERROR(CheckReadable(batch.segments));
    return encoded;
  };
  Result<std::vector<std::byte>> bytes = encode();
  if (bytes) return std::move(*bytes);
  if (bytes.error().code == ErrorCode::kInvalidArgument) {
    Refuse(sampled.request, bytes.error().message);
    return {};
  }
  // The learner asks again; what cannot be read is not sampled then.
  const Status readable = table_.DropDamaged();
  ProcessFaults().Report(FaultKind::kDamage, readable);
  if (readable) spdlog::error("{}", bytes.error().message);
  return {};
}

bool BatchServer::Serves(const RequestId& id) const {
  MutexLock serving(serving_mutex_);
  return std::find(serving_.begin(), serving_.end(), id) != serving_.end();
}

bool BatchServer::Send(const Request& request, std::vector<std::byte>& bytes) {
  if (bytes.empty()) return true;
  if (endpoints_.replies->matched() == 0) {
    clock_.SleepFor(kWait);
  } else if (const Status sent = Reply(request, bytes); sent) {
    batches_.fetch_add(1);
    bytes_.fetch_add(bytes.size());
    return true;
  } else if (sent.error().code != ErrorCode::kUnavailable) {
    spdlog::error("a batch of {} bytes is lost: {}", bytes.size(), sent.error().message);
    return true;
  }
  return Replaced(request.id.learner);
}

bool BatchServer::Replaced(uint64_t learner) {
  std::optional<Resting> resting(std::in_place);
  MutexLock leading(lead_);
  resting.reset();
  TakeRequests();
  return queue_.learner() != learner;
}

Status BatchServer::Reply(const Request& request, std::vector<std::byte>& bytes, const std::string& refusal) {
  const ReplayTable::Stats stats = table_.stats();
  dadrl_idl_BatchReply message{};
  message.shard = shard_;
  message.learner = request.id.learner;
  message.request = request.id.number;
  message.frames_held = stats.items;
  message.frames_inserted = stats.inserted_frames;
  std::copy_n(refusal.data(), std::min(refusal.size(), sizeof(message.refusal) - 1), message.refusal);
  Borrow(bytes, message.bytes);
  return endpoints_.replies->Write(message);
}

}  // namespace dadrl
