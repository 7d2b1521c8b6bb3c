// Batches out: requests from the learner wait here until they may be served; priorities come back.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/mutex.h"
#include "common/util/result.h"
#include "common/util/time_ledger.h"
#include "proto/topics.h"
#include "replay/service/request_queue.h"
#include "replay/table.h"

namespace dadrl {

// One thread runs Run, which starts the others, all of them WorkingThreads, or each calls Step; statistics,
// ledger and Wake are for any. The threads take turns: one leads, that is, waits for requests and samples the
// next batch; then another leads while it reads, serialises and sends that batch. Batches are sampled in the
// order of their requests, and may overtake each other on their way out. What waits, and whose it is:
// request_queue.h.
class BatchServer {
 public:
  // One sends while the other prepares: DDS takes as long for a batch as the table.
  static constexpr int kThreads = 2;
  static constexpr size_t kFewPending = 8;  // then it looks for more

  struct Statistics {
    uint64_t batches = 0;
    uint64_t bytes = 0;
    uint64_t refused_requests = 0;  // that could never be served
  };

  // Borrows `table` and `clock`. `on_sample` is called after a batch was sampled: inserts may have been held
  // back for it.
  static Result<std::unique_ptr<BatchServer>> Create(const Transport& transport, uint32_t shard,
                                                     ReplayTable& table, Clock& clock,
                                                     std::function<void()> on_sample);

  // What one thread has on its way out.
  struct Outgoing {
    std::optional<RequestQueue::Request> request;  // nothing: no batch
    std::vector<std::byte> bytes;                  // kept for the next batch's memory
  };
  // Leads when it is the caller's turn, which samples and serialises the next batch if there may be one, or
  // waits a little for that; tries to send what it has.
  void Step(Outgoing& outgoing) DADRL_EXCLUDES(lead_);
  void Run(const std::atomic<bool>& stop);
  // There may be more to sample. Cheap when no request waits for that.
  void Wake();

  Statistics statistics() const { return {batches_.load(), bytes_.load(), refused_.load()}; }
  // Work, and waits for inserts and for requests.
  const TimeLedger& ledger() const { return ledger_; }

 private:
  struct Endpoints {
    std::unique_ptr<Reader<dadrl_idl_BatchRequest>> requests;
    std::unique_ptr<Reader<dadrl_idl_PriorityUpdate>> priorities;
    std::unique_ptr<Writer<dadrl_idl_BatchReply>> replies;
  };
  using RequestId = RequestQueue::Id;
  using Request = RequestQueue::Request;
  // A request whose batch is sampled, and which is in `serving_`.
  struct SampledRequest {
    Request request;
    SampledItems items;
  };

  BatchServer(Endpoints endpoints, uint32_t shard, ReplayTable& table, Clock& clock,
              std::function<void()> on_sample);
  void Work(const std::atomic<bool>& stop);

  // Leads when it is this thread's turn.
  std::optional<SampledRequest> AwaitLead() DADRL_EXCLUDES(lead_);
  // Waits a little for requests; the next one's batch when it may be served.
  std::optional<SampledRequest> Lead() DADRL_REQUIRES(lead_);
  void TakeRequests() DADRL_REQUIRES(lead_);
  void OnRequest(const dadrl_idl_BatchRequest& message) DADRL_REQUIRES(lead_);
  // Whether the request can ever be served; its message is for the learner.
  Status Check(const dadrl_idl_BatchRequest& message, const TrajectoryShape& shape) const;
  void Refuse(const Request& request, const std::string& reason);
  void TakePriorities() DADRL_REQUIRES(lead_);
  Result<SampledItems> SampleItems(const Request& request) DADRL_REQUIRES(lead_);
  void ReplyWithheld() DADRL_REQUIRES(lead_);

  // Serialises a batch into `memory`; empty when it cannot be sent.
  std::vector<std::byte> Read(SampledRequest sampled, std::vector<std::byte> memory);
  // True when there is nothing more to do: it is sent, refused for good, or its learner replaced.
  bool Send(const Request& request, std::vector<std::byte>& bytes) DADRL_EXCLUDES(lead_);
  bool Serves(const RequestId& id) const DADRL_EXCLUDES(serving_mutex_);
  Status Reply(const Request& request, std::vector<std::byte>& bytes, const std::string& refusal = {});
  bool Replaced(uint64_t learner) DADRL_EXCLUDES(lead_);

  const Endpoints endpoints_;
  const uint32_t shard_;
  ReplayTable& table_;
  Clock& clock_;
  const std::function<void()> on_sample_;
  TimeLedger ledger_;

  // Held by the one that leads, also while it waits for requests.
  Mutex lead_;
  RequestQueue queue_ DADRL_GUARDED_BY(lead_);
  bool waited_ DADRL_GUARDED_BY(lead_) = false;
  mutable Mutex serving_mutex_;
  std::vector<RequestId> serving_ DADRL_GUARDED_BY(serving_mutex_);  // sampled, not sent yet
  std::atomic<bool> waiting_{false};
  std::atomic<uint64_t> batches_{0};
  std::atomic<uint64_t> bytes_{0};
  std::atomic<uint64_t> refused_{0};
};

}  // namespace dadrl
