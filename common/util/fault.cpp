#include "common/util/fault.h"

#include <utility>

#include "common/util/log.h"

namespace dadrl {
namespace {

struct Description {
  std::string_view name;
  std::string_view meaning;
  std::string_view over;
  bool holds_up_training = false;
};

constexpr EnumArray<FaultKind, Description> kDescriptions = {
    Description{"experience", "actors keep their experience until it can be stored, sampling goes on",
                "experience can be stored again", true},
    Description{"sync", "a power cut would lose what was stored since", "stored experience is forced again"},
    Description{"state", "a restart would begin with older counters and priorities",
                "counters and priorities are saved again"},
    Description{"damage", "what cannot be read is not sampled any more", "nothing is damaged"},
    Description{"snapshot", "no automatic snapshot is taken", "snapshots are taken again"},
    Description{"snapshot_space", "the disk may become full", "snapshots fit again"},
    Description{"checkpoint", "training goes on; a restart would go back to the last checkpoint",
                "checkpoints are saved again"},
    Description{"weights", "actors go on with the policy they have", "policies are sent again", true},
    Description{"training_log", "training goes on without its curves", "the training log is written again"},
    Description{"episode_log", "episodes are counted but not written down",
                "episodes are written down again"},
    Description{"incarnation", "the clock alone tells this process from the one before it",
                "starts are written down again"},
    Description{"results", "training goes on, its results are not saved", "results are saved again"},
    Description{"processes", "a monitor that starts now does not see who hangs",
                "the list of processes is written again"},
};
static_assert(!kDescriptions.back().name.empty());

}  // namespace

std::string_view FaultName(FaultKind kind) { return kDescriptions[kind].name; }
std::string_view FaultMeaning(FaultKind kind) { return kDescriptions[kind].meaning; }
std::string_view FaultOver(FaultKind kind) { return kDescriptions[kind].over; }
bool HoldsUpTraining(FaultKind kind) { return kDescriptions[kind].holds_up_training; }

void FaultBoard::Report(FaultKind kind, const Status& outcome) {
  MutexLock lock(mutex_);
  std::optional<Lasting>& lasting = lasting_[kind];
  if (outcome.has_value() != lasting.has_value()) return;  // no news
  const bool says = logging_ == Logging::kOn;
  if (outcome) {
    if (says) spdlog::info("{}, after {:.0f} s", FaultOver(kind), ToSeconds(clock_.Now() - lasting->since));
    lasting.reset();
  } else {
    if (says) spdlog::error("{}; {}", outcome.error().message, FaultMeaning(kind));
    lasting = Lasting{outcome.error().message, clock_.Now()};
  }
  if (follower_ && HoldsUpTraining(kind)) follower_(HeldUpBy());
}

std::string FaultBoard::HeldUpBy() const {
  for (size_t i = 0; i < lasting_.size(); ++i) {
    if (lasting_[i] && HoldsUpTraining(lasting_.At(i))) return lasting_[i]->text;
  }
  return {};
}

void FaultBoard::Follow(std::function<void(std::string_view)> follower) {
  MutexLock lock(mutex_);
  follower_ = std::move(follower);
}

std::vector<Fault> FaultBoard::Current() const {
  MutexLock lock(mutex_);
  std::vector<Fault> current;
  for (size_t i = 0; i < lasting_.size(); ++i) {
    if (!lasting_[i]) continue;
    current.push_back({lasting_.At(i), lasting_[i]->text, ToSeconds(clock_.Now() - lasting_[i]->since)});
  }
  return current;
}

bool FaultBoard::Lasts(FaultKind kind) const {
  MutexLock lock(mutex_);
  return lasting_[kind].has_value();
}

FaultBoard& ProcessFaults() {
  static const SystemClock clock;
  static FaultBoard board(clock);
  return board;
}

}  // namespace dadrl
