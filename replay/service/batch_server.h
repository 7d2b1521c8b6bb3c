// Batches out: requests from the learner wait here until they may be served; priorities come back.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "common/dds/endpoint.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "common/util/time_ledger.h"
#include "proto/topics.h"
#include "replay/table.h"

namespace dadrl {

// One thread runs Run; statistics, ledger and Wake are for any. Requests are served in order; those of an
// earlier learner are dropped as soon as a later one speaks. Bounded: kMaxPending requests.
class BatchServer {
 public:
  static constexpr size_t kMaxPending = 64;
  static constexpr uint32_t kMaxBatch = 65536;

  struct Statistics {
    uint64_t batches = 0;
    uint64_t bytes = 0;
    uint64_t refused_requests = 0;  // that could never be served
  };

  // Borrows `table` and `clock`. `on_sample` is called after a batch was drawn: inserts may have been held
  // back for it.
  static Result<std::unique_ptr<BatchServer>> Create(const dds::Node& node, uint32_t shard,
                                                     ReplayTable& table, const Clock& clock,
                                                     std::function<void()> on_sample);

  void Run(const std::atomic<bool>& stop);
  // There may be more to sample. Cheap when no request waits for that.
  void Wake();

  Statistics statistics() const { return {batches_.load(), bytes_.load(), refused_.load()}; }
  // Work, and waits for inserts and for requests.
  const TimeLedger& ledger() const { return ledger_; }

 private:
  struct Endpoints {
    std::unique_ptr<dds::Reader<dadrl_idl_BatchRequest>> requests;
    std::unique_ptr<dds::Reader<dadrl_idl_PriorityUpdate>> priorities;
    std::unique_ptr<dds::Writer<dadrl_idl_BatchReply>> replies;
  };
  struct Request {
    uint64_t learner = 0;
    uint64_t number = 0;
    uint32_t batch_size = 0;
    int n_step = 0;
    int sequence_length = 0;  // 0: slices of n_step
    uint32_t policy_version = 0;
    bool told = false;                // that it is withheld
    std::vector<std::byte> prepared;  // its batch, drawn but not yet sent
  };

  BatchServer(Endpoints endpoints, uint32_t shard, ReplayTable& table, const Clock& clock,
              std::function<void()> on_sample);
  void TakeRequests();
  void OnRequest(const dadrl_idl_BatchRequest& message);
  // Whether the request can ever be served; its message is for the learner.
  Status Check(const dadrl_idl_BatchRequest& message) const;
  void Refuse(const Request& request, const std::string& reason);
  void TakePriorities();
  // Serves what may be served; true when a request has to wait for inserts.
  bool ServePending();
  Result<std::vector<std::byte>> Sample(const Request& request);
  // Draws the batch of a request that may be served. False: not now.
  bool Prepare(Request& request);
  Status Reply(const Request& request, std::vector<std::byte>& bytes, const std::string& refusal = {});

  const Endpoints endpoints_;
  const uint32_t shard_;
  ReplayTable& table_;
  const std::function<void()> on_sample_;
  TimeLedger ledger_;

  uint64_t learner_ = 0;
  std::deque<Request> pending_;
  std::atomic<bool> waiting_{false};
  std::atomic<uint64_t> batches_{0};
  std::atomic<uint64_t> bytes_{0};
  std::atomic<uint64_t> refused_{0};
};

}  // namespace dadrl
