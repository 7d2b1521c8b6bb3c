#include "replay/tools/replay_question.h"

#include <unistd.h>

#include <memory>
#include <tuple>
#include <utility>

#include "common/util/shown.h"

namespace dadrl {
namespace {

// For a shard that listens: its disk may be slow, and where there are no hard links a snapshot is copied.
constexpr Duration kPatience = std::chrono::seconds(60);
// Until it is said whom all wait for.
constexpr Duration kSilence = std::chrono::seconds(3);
constexpr Duration kRepeat = std::chrono::seconds(1);
constexpr Duration kTick = std::chrono::milliseconds(50);
constexpr int kMostAnswers = 64;  // taken at once

// For a shard that does not listen: one that hangs is killed after half of it, and back.
Duration PatienceWithAbsent(const ClusterConfig& cluster) {
  return FromSeconds(10.0 * cluster.liveliness_s + cluster.lease_s);
}

class Question {
 public:
  Question(const Config& config, dadrl_idl_ReplayCommand command, const Clock& clock)
      : config_(config), command_(command), clock_(clock), began_(clock.Now()), all_listened_(began_) {
    command_.command = static_cast<uint64_t>(WallTimeNs()) ^ static_cast<uint64_t>(getpid()) << 40;
  }
  Status Open(const Transport& transport) {
    DADRL_ASSIGN_OR_RETURN(answers_, Reader<dadrl_idl_ReplayAnswer>::Create(transport, kReplayAnswerTopic));
    DADRL_ASSIGN_OR_RETURN(commands_,
                           Writer<dadrl_idl_ReplayCommand>::Create(transport, kReplayCommandTopic));
    return {};
  }
  Status Ask(const std::function<void(const std::string&)>& say) {
    bool said = false;
    while (!Silent().empty()) {
      const Duration waited = clock_.Now() - began_;
      if (commands_->matched() >= config_.replay.shards) all_listened_ = clock_.Now();
      if (waited > kPatience || clock_.Now() - all_listened_ > PatienceWithAbsent(config_.cluster)) {
        return Fail(ErrorCode::kUnavailable,
                    "gave up after {:.0f} s on {}; it may still do what was asked: its log tells",
                    ToSeconds(waited), AwaitedShards());
      }
      if (waited > kSilence && !std::exchange(said, true)) say("waiting for " + AwaitedShards());
      Send();
      Hear();
    }
    return {};
  }
  std::map<uint32_t, ReplayAnswer> TakeAnswers() { return std::move(heard_); }

 private:
  std::string Silent() const {
    std::string silent;
    for (uint32_t shard = 0; shard < shards(); ++shard) {
      if (!heard_.contains(shard)) silent += fmt::format("{}{}", silent.empty() ? "" : ", ", shard);
    }
    return silent;
  }
  // Who is silent, and why that may be.
  std::string AwaitedShards() const {
    const int listening = commands_->matched();
    if (listening >= config_.replay.shards) {
      return fmt::format(
          "replay shard {}, which listens and has not answered: its disk is slow, or it is stopped",
          Silent());
    }
    return fmt::format(
        "replay shard {}: {} of {} shards listen at {}:{}; is the training running, or stopped (dadrl "
        "monitor)?",
        Silent(), listening, config_.replay.shards, config_.cluster.host, config_.cluster.port);
  }
  void Send() {
    if (commands_->matched() == 0 || clock_.Now() < next_) return;
    for (uint32_t shard = 0; shard < shards(); ++shard) {
      command_.shard = shard;
      if (!heard_.contains(shard)) std::ignore = commands_->Write(command_);  // is repeated
    }
    next_ = clock_.Now() + kRepeat;
  }
  void Hear() {
    answers_->Wait(kTick);
    answers_->Take(kMostAnswers, [&](const dadrl_idl_ReplayAnswer& answer) {
      if (answer.command != command_.command || answer.shard >= shards()) return;
      heard_[answer.shard] = {answer.done, Shown(answer.text, sizeof(answer.text))};
    });
  }
  uint32_t shards() const { return static_cast<uint32_t>(config_.replay.shards); }

  const Config& config_;
  dadrl_idl_ReplayCommand command_;
  const Clock& clock_;
  const TimePoint began_;
  TimePoint all_listened_;  // last
  TimePoint next_{};
  std::unique_ptr<Reader<dadrl_idl_ReplayAnswer>> answers_;
  std::unique_ptr<Writer<dadrl_idl_ReplayCommand>> commands_;
  std::map<uint32_t, ReplayAnswer> heard_;
};

}  // namespace

Result<std::map<uint32_t, ReplayAnswer>> AskShards(const Transport& transport, const Config& config,
                                                   dadrl_idl_ReplayCommand command, const Clock& clock,
                                                   const std::function<void(const std::string&)>& say) {
  Question question(config, command, clock);
  DADRL_RETURN_IF_ERROR(question.Open(transport));
  DADRL_RETURN_IF_ERROR(question.Ask(say));
  return question.TakeAnswers();
}

}  // namespace dadrl
