#include "tests/bench/service_peers.h"

#include <unistd.h>

#include <algorithm>
#include <deque>
#include <thread>
#include <utility>

#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/log.h"
#include "proto/topics.h"
#include "tests/bench/chunk_stream.h"
#include "tests/common/io/test_run_key.h"

namespace dadrl::bench {
namespace {

constexpr Duration kWait = std::chrono::milliseconds(50);
constexpr Duration kResendAfter = std::chrono::seconds(2);
const DrivingShape kSpec;

TimePoint Now() { return SystemClock().Now(); }

// Here a failure to start is the end of the benchmark.
template <typename T>
T Need(Result<T> result) {
  if (!result) {
    spdlog::error("{}", result.error().message);
    _exit(1);
  }
  return std::move(*result);
}

std::unique_ptr<dds::Node> Join(const Config& config, dds::Role role, int index) {
  return Need(dds::Node::Create(config.cluster, config.replay.shards, role, index, kTestRunKey));
}

class Feeder {
 public:
  Feeder(const Config& config, bool granting)
      : node_(Join(config, dds::Role::kActor, 1)),
        acknowledgements_(Need(Reader<dadrl_idl_Acknowledgement>::Create(*node_, AcknowledgementTopic(1)))),
        chunks_(Need(Writer<dadrl_idl_ChunkMessage>::Create(*node_, ChunkTopic(0)))),
        granted_(granting ? 1 : UINT64_MAX) {
    while (chunks_->matched() == 0 || acknowledgements_->matched() == 0) {
      SystemClock().SleepFor(std::chrono::milliseconds(10));
    }
    heard_ = Now();
  }
  // Seconds from sending a chunk to its acknowledgement.
  std::vector<double> latencies() const { return latencies_; }
  void Run(uint64_t chunks) {
    while (stored_ < chunks) {
      Hear();
      if (next_ > stored_ + 1 && Now() - heard_ > kResendAfter) {
        heard_ = Now();
        next_ = stored_ + 1;
      }
      if (next_ <= std::min(chunks, granted_)) {
        Send();
      } else {
        acknowledgements_->Wait(kWait);
      }
    }
  }

 private:
  void Hear() {
    acknowledgements_->Take(1000, [this](const dadrl_idl_Acknowledgement& ack) {
      if (ack.actor != 1) return;
      heard_ = Now();
      while (!sent_.empty() && sent_.front().first <= ack.stored_sequence) {
        latencies_.push_back(ToSeconds(heard_ - sent_.front().second));
        sent_.pop_front();
      }
      stored_ = ack.stored_sequence;
      next_ = std::max(next_, stored_ + 1);
      granted_ = ack.granted_sequence;
    });
  }
  void Send() {
    const std::span<std::byte> bytes = stream_.At(next_);
    dadrl_idl_ChunkMessage message{};
    message.actor = 1;
    message.oldest_kept = stored_ + 1;
    message.bytes._buffer = reinterpret_cast<uint8_t*>(bytes.data());
    message.bytes._length = message.bytes._maximum = static_cast<uint32_t>(bytes.size());
    sent_.emplace_back(next_, Now());
    if (chunks_->Write(message)) {
      ++next_;
    } else {
      sent_.pop_back();
    }
  }

  const std::unique_ptr<dds::Node> node_;
  const std::unique_ptr<Reader<dadrl_idl_Acknowledgement>> acknowledgements_;
  const std::unique_ptr<Writer<dadrl_idl_ChunkMessage>> chunks_;
  ChunkStream stream_;
  TimePoint heard_{};
  uint64_t stored_ = 0;
  uint64_t granted_;
  uint64_t next_ = 1;
  std::deque<std::pair<uint64_t, TimePoint>> sent_;  // sequence, and when
  std::vector<double> latencies_;
};

Numbers NumbersOf(double seconds, double bytes, std::vector<double> waits) {
  Numbers numbers{.seconds = seconds, .bytes = bytes};
  if (waits.empty()) return numbers;
  std::sort(waits.begin(), waits.end());
  numbers.p50_s = waits[waits.size() / 2];
  numbers.p99_s = waits[waits.size() * 99 / 100];
  numbers.largest_s = waits.back();
  return numbers;
}

void TakeChunks(const dds::Node& node, uint64_t chunks) {
  const auto acknowledgements =
      Need(Writer<dadrl_idl_Acknowledgement>::Create(node, AcknowledgementTopic(1)));
  const auto reader = Need(Reader<dadrl_idl_ChunkMessage>::Create(node, ChunkTopic(0)));
  uint64_t taken = 0;
  while (true) {
    const int now = reader->Take(32, [](const dadrl_idl_ChunkMessage&) {});
    if (now == 0) reader->Wait(kWait);
    const uint64_t before = taken;
    taken += static_cast<uint64_t>(now);
    if (before >= chunks || taken < chunks) continue;
    dadrl_idl_Acknowledgement done{};
    done.actor = 1;
    done.stored_sequence = done.granted_sequence = chunks;
    if (!acknowledgements->Write(done)) spdlog::error("the last word was not sent");
  }
}

}  // namespace

Numbers Feed(const Config& config, uint64_t chunks, bool granting) {
  Feeder feeder(config, granting);
  const TimePoint begin = Now();
  feeder.Run(chunks);
  return NumbersOf(ToSeconds(Now() - begin), 0.0, feeder.latencies());
}

void FeedForEver(const Config& config, bool granting) {
  Feeder feeder(config, granting);
  while (true) feeder.Run(UINT64_MAX);
}

Numbers Fetch(const Config& config, const Fetching& fetching) {
  const auto node = Join(config, dds::Role::kLearner, 0);
  const auto replies = Need(Reader<dadrl_idl_BatchReply>::Create(*node, kBatchReplyTopic));
  const auto requests = Need(Writer<dadrl_idl_BatchRequest>::Create(*node, kBatchRequestTopic));
  while (replies->matched() == 0 || requests->matched() == 0) {
    SystemClock().SleepFor(std::chrono::milliseconds(10));
  }
  std::vector<TimePoint> asked;  // by request number
  const auto send = [&](uint64_t number) {
    dadrl_idl_BatchRequest request{};
    request.learner = static_cast<uint64_t>(getpid());
    request.request = number;
    request.protocol = kProtocolVersion;
    request.trajectories = fetching.batch_size;
    request.steps = static_cast<uint32_t>(config.algorithm.n_step);
    request.schema = SchemaHash(kSpec);
    if (!requests->Write(request)) spdlog::error("a request was not sent");
  };
  const auto ask = [&] {
    asked.push_back(Now());
    send(asked.size() - 1);
  };
  double bytes = 0.0;
  std::vector<double> latencies;
  const TimePoint begin = Now();
  TimePoint heard = begin;
  for (int i = 0; i < fetching.outstanding; ++i) ask();
  while (latencies.size() < static_cast<size_t>(fetching.batches)) {
    const int taken = replies->Take(16, [&](const dadrl_idl_BatchReply& reply) {
      if (reply.bytes._length == 0) return;  // has to wait: too little is stored yet
      heard = Now();
      bytes += reply.bytes._length;
      latencies.push_back(ToSeconds(Now() - asked[reply.request]));
      if (latencies.size() % static_cast<size_t>(fetching.replies_of) == 0) ask();
    });
    if (taken == 0) replies->Wait(kWait);
    // What was asked before the peer knew our writer never arrived.
    if (latencies.empty() && Now() - heard > kResendAfter) {
      heard = Now();
      for (uint64_t number = 0; number < asked.size(); ++number) send(number);
    }
  }
  const double seconds = ToSeconds(Now() - begin);
  const auto count = static_cast<double>(latencies.size());
  return NumbersOf(seconds * fetching.batches / count, bytes / count, std::move(latencies));
}

void Mirror(const Config& config, uint64_t chunks, int replies_of, size_t reply_bytes) {
  const auto node = Join(config, dds::Role::kReplay, 0);
  std::thread sink([&] { TakeChunks(*node, chunks); });
  const auto replies = Need(Writer<dadrl_idl_BatchReply>::Create(*node, kBatchReplyTopic));
  const auto requests = Need(Reader<dadrl_idl_BatchRequest>::Create(*node, kBatchRequestTopic));
  std::vector<uint8_t> bytes(reply_bytes, 0x5a);
  while (true) {
    requests->Take(1, [&](const dadrl_idl_BatchRequest& request) {
      // What is written before the asking side's reader is known here is lost, and nobody asks again.
      while (replies->matched() == 0) SystemClock().SleepFor(std::chrono::milliseconds(1));
      dadrl_idl_BatchReply reply{};
      reply.learner = request.learner;
      reply.request = request.request;
      reply.bytes._buffer = bytes.data();
      reply.bytes._length = reply.bytes._maximum = static_cast<uint32_t>(bytes.size());
      for (int sent = 0; sent < replies_of;) sent += replies->Write(reply) ? 1 : 0;
    });
    requests->Wait(kWait);
  }
}

}  // namespace dadrl::bench
