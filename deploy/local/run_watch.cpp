#include "deploy/local/run_watch.h"

#include <fmt/format.h>

#include <tuple>
#include <utility>

namespace dadrl {
namespace {

constexpr Duration kCheckInterval = std::chrono::seconds(2);

}  // namespace

RunPresence::Verdict RunPresence::Update(bool there, bool ending, TimePoint now) {
  const bool present = there && !ending;
  if (present != there_) {
    there_ = present;
    changed_ = now;
    next_notice_ = now + kFirstNotice;
    if (present && std::exchange(reported_, false)) notice_ = fmt::format("the run at {} is back", run_);
  }
  if (present) return Verdict::kThere;
  const Duration away = now - changed_;
  if (ending && away >= kReturn) return Verdict::kEnded;
  if (away >= kPatience) return Verdict::kGivenUp;
  if (now >= next_notice_) {
    next_notice_ = now + kNoticeInterval;
    reported_ = true;
    notice_ = fmt::format(
        "the run at {} has not answered for {:.0f} s, and did not say that it ends: the actors wait for it, "
        "at "
        "most {} minutes",
        run_, ToSeconds(away), std::chrono::duration_cast<std::chrono::minutes>(kPatience).count());
  }
  return Verdict::kAway;
}

std::optional<std::string> RunPresence::TakeNotice() { return std::exchange(notice_, std::nullopt); }

Result<std::unique_ptr<RunWatch>> RunWatch::Create(const Config& config, const std::string& key,
                                                   const Clock& clock) {
  std::unique_ptr<RunWatch> watch(new RunWatch(config, key, clock));
  DADRL_RETURN_IF_ERROR(watch->Open());
  return watch;
}

RunWatch::RunWatch(const Config& config, std::string key, const Clock& clock)
    : config_(config),
      key_(std::move(key)),
      clock_(clock),
      presence_(fmt::format("{}:{}", config.cluster.host, config.cluster.port), clock.Now()) {}

Status RunWatch::Open() {
  states_.reset();
  DADRL_ASSIGN_OR_RETURN(
      node_, dds::Node::Create(config_.cluster, config_.replay.shards, dds::Role::kMonitor, 0, key_));
  DADRL_ASSIGN_OR_RETURN(states_, StateReader::Create(*node_, kRunStateTopic));
  return {};
}

RunPresence::Verdict RunWatch::Look() {
  const TimePoint now = clock_.Now();
  if (now >= next_check_) {
    next_check_ = now + kCheckInterval;
    // Without a way to the run there is nothing to open: it counts as away, and is tried again.
    if (!states_ || !node_->CheckAddress()) std::ignore = Open();
  }
  if (!states_) return presence_.Update(false, ending_, now);
  states_->Take(16, [this](const dadrl_idl_RunState& state) {
    if (state.incarnation < incarnation_) return;
    ending_ = state.ending || (ending_ && state.incarnation == incarnation_);
    incarnation_ = state.incarnation;
  });
  return presence_.Update(states_->matched() > 0, ending_, now);
}

}  // namespace dadrl
