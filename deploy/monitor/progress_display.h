// How a training's progress gets onto a terminal, or into a log.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "common/util/clock.h"
#include "deploy/monitor/panel.h"

namespace dadrl {

// The terminal behind `stream` as it is now; 24 rows of 80 columns where it does not say, none where there is
// no terminal.
TerminalSize SizeOf(std::FILE* stream);

// Writes progress to a stream: on a terminal a panel that fits it and is redrawn in place twice a second,
// elsewhere a plain line every ten seconds. Not thread safe; nothing else should write to the same terminal
// meanwhile, messages go through Message.
class ProgressDisplay {
 public:
  // Borrows both.
  ProgressDisplay(std::FILE* stream, const Clock& clock);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  // Whether enough time has passed to show something new.
  bool Due() const;
  void Show(const Progress& progress);
  // A line that stays: above the panel, or between the plain lines.
  void Message(const std::string& text);
  // Leaves the last panel where it is; further output goes below it.
  void Finish();

 private:
  void Put(const std::string& text);
  // Up to the first line of the panel that is shown.
  void GoToTop();

  std::FILE* stream_;
  const Clock& clock_;
  bool terminal_;
  std::vector<size_t> shown_;  // columns of each line of the panel on the terminal
  TimePoint next_{};
};

}  // namespace dadrl
