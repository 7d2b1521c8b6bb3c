#include "deploy/monitor/progress_display.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

namespace dadrl {
namespace {

constexpr double kPanelInterval_s = 0.5;
constexpr double kLineInterval_s = 10.0;
constexpr size_t kLineColumns = 119;

// A character that is wider than we think is cut off by the terminal instead of starting another line, which
// the next redraw would not know of.
constexpr const char* kWrapOff = "\x1b[?7l";
constexpr const char* kWrapOn = "\x1b[?7h";
constexpr const char* kClearLine = "\x1b[2K";
constexpr const char* kClearBelow = "\x1b[J";

}  // namespace

TerminalSize SizeOf(std::FILE* stream) {
  if (isatty(fileno(stream)) != 1) return {};
  winsize size{};
  if (ioctl(fileno(stream), TIOCGWINSZ, &size) != 0 || size.ws_row == 0 || size.ws_col == 0) return {24, 80};
  return {size.ws_row, size.ws_col};
}

ProgressDisplay::ProgressDisplay(std::FILE* stream, const Clock& clock)
    : stream_(stream), clock_(clock), terminal_(isatty(fileno(stream)) == 1), next_(clock.Now()) {}

ProgressDisplay::~ProgressDisplay() { Finish(); }

bool ProgressDisplay::Due() const { return clock_.Now() >= next_; }

// A terminal or pipe that is gone must not end the training: errors are ignored (fmt::print would throw).
void ProgressDisplay::Put(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stream_); }

void ProgressDisplay::GoToTop() {
  if (shown_.empty()) return;
  // A terminal that became narrower has broken long lines into several.
  const TerminalSize size = SizeOf(stream_);
  size_t up = 0;
  for (const size_t columns : shown_) up += std::max<size_t>(1, (columns + size.columns - 1) / size.columns);
  Put(fmt::format("\x1b[{}F", std::min(up, std::max<size_t>(size.rows, 2) - 1)));
  shown_.clear();
}

void ProgressDisplay::Show(const Progress& progress) {
  next_ = clock_.Now() + FromSeconds(terminal_ ? kPanelInterval_s : kLineInterval_s);
  if (!terminal_) {
    Put(RenderLine(progress, kLineColumns) + "\n");
    std::fflush(stream_);
    return;
  }
  // Line by line over the old panel: where it fills the screen, clearing it would move it into the history of
  // some terminals, twice a second.
  GoToTop();
  TerminalSize size = SizeOf(stream_);
  size.rows = std::max<size_t>(size.rows, 2) - 1;  // the last one is the cursor's
  Put(kWrapOff);
  for (const std::string& line : RenderPanel(progress, size)) {
    Put(kClearLine + line + "\n");
    shown_.push_back(CountColumns(line));
  }
  Put(std::string(kClearBelow) + kWrapOn);
  std::fflush(stream_);
}

void ProgressDisplay::Message(const std::string& text) {
  if (!shown_.empty()) {
    GoToTop();
    Put(kClearBelow);
  }
  Put(text + "\n");
  std::fflush(stream_);
  if (terminal_) next_ = clock_.Now();  // brings the panel back at once
}

void ProgressDisplay::Finish() { shown_.clear(); }

}  // namespace dadrl
