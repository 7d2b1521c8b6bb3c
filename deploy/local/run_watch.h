// Whether the run that actors have joined is still there: what `dadrl actor` goes by.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/config/config.h"
#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "proto/topics.h"

namespace dadrl {

// What follows from what is seen of the run: pure bookkeeping. A replay that goes without a word was killed,
// and is waited for; so are a launcher that was killed and a network that is cut, which look the same from
// here. Not thread safe.
class RunPresence {
 public:
  enum class Verdict {
    kThere,
    kAway,    // wait for it
    kEnded,   // it was asked to end, and did not come back
    kGivenUp  // away for kPatience
  };
  // A replay that is asked to end while the run goes on is started again within it.
  static constexpr Duration kReturn = std::chrono::seconds(6);
  static constexpr Duration kFirstNotice = std::chrono::seconds(15);
  static constexpr Duration kNoticeInterval = std::chrono::minutes(1);
  static constexpr Duration kPatience = std::chrono::hours(1);

  // `run`: "HOST:PORT", for messages.
  RunPresence(std::string run, TimePoint now) : run_(std::move(run)), changed_(now) {}

  // `there`: its replay answers; `ending`: the replay has said that it ends.
  Verdict Update(bool there, bool ending, TimePoint now);
  // A line for the user, once it is due.
  std::optional<std::string> TakeNotice();

 private:
  const std::string run_;
  bool there_ = true;
  TimePoint changed_;
  TimePoint next_notice_{};
  bool reported_ = false;  // that it is away
  std::optional<std::string> notice_;
};

// The same over DDS. Not thread safe; never blocks after Create.
class RunWatch {
 public:
  // `config`, `key`: of the run. Borrows `clock`.
  static Result<std::unique_ptr<RunWatch>> Create(const Config& config, const std::string& key,
                                                  const Clock& clock);
  RunPresence::Verdict Look();
  std::optional<std::string> TakeNotice() { return presence_.TakeNotice(); }

 private:
  using StateReader = Reader<dadrl_idl_RunState>;
  RunWatch(const Config& config, std::string key, const Clock& clock);
  // Also when this machine's address has changed: a node keeps the one it began with.
  Status Open();

  const Config config_;
  const std::string key_;
  const Clock& clock_;
  std::unique_ptr<dds::Node> node_;  // outlives the reader
  std::unique_ptr<StateReader> states_;
  TimePoint next_check_{};  // of the address
  RunPresence presence_;
  uint64_t incarnation_ = 0;  // of the replay that spoke last
  bool ending_ = false;       // that one
};

}  // namespace dadrl
