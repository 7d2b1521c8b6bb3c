#include "deploy/local/captured_process.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "common/io/io_error.h"
#include "common/io/unnamed_file.h"
#include "deploy/local/log_tail.h"

namespace dadrl {
namespace {

Result<FileDescriptor> OpenCapture(const char* name) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, OpenUnnamedFile(name));
  // Whoever writes, and however many: each at the end.
  if (fcntl(file.get(), F_SETFL, O_APPEND) != 0)
    return tl::unexpected<Error>(IoError("append to", name, errno));
  return file;
}

uint64_t SizeOf(const FileDescriptor& file) {
  struct stat info {};
  return fstat(file.get(), &info) == 0 ? static_cast<uint64_t>(info.st_size) : 0;
}

// The message of a log line: stamp, level, role, colon, message.
std::string WithoutStamp(const std::string& line) {
  const size_t role = line.find(" E ");
  const size_t colon = role == std::string::npos ? std::string::npos : line.find(": ", role);
  return colon == std::string::npos ? line : line.substr(colon + 2);
}

}  // namespace

CapturedProcess::CapturedProcess(ChildProcess child, LivenessWatch watch, FileDescriptor output,
                                 FileDescriptor log)
    : child_(std::move(child)), watch_(std::move(watch)), output_(std::move(output)), log_(std::move(log)) {}

Result<CapturedProcess> CapturedProcess::Spawn(std::vector<std::string> command, int nice,
                                               const HangLimits& limits) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor output, OpenCapture("output"));
  DADRL_ASSIGN_OR_RETURN(FileDescriptor log, OpenCapture("log"));
  LivenessWatch watch(limits, SystemClock().Now());
  DADRL_ASSIGN_OR_RETURN(ChildProcess child, ChildProcess::Spawn({.command = std::move(command),
                                                                  .log = {},
                                                                  .stdout_fd = output.get(),
                                                                  .log_fd = log.get(),
                                                                  .nice = nice,
                                                                  .beats_fd = watch.page_fd()}));
  return CapturedProcess(std::move(child), std::move(watch), std::move(output), std::move(log));
}

std::optional<std::string> CapturedProcess::Hangs() { return watch_.Look(child_.pid(), SystemClock().Now()); }

bool CapturedProcess::Overflows() const {
  return SizeOf(output_) > kMaxCapturedBytes || SizeOf(log_) > kMaxCapturedBytes;
}

std::string CapturedProcess::Output() const {
  std::string text;
  char buffer[1 << 16];
  ssize_t count = 0;
  while ((count = pread(output_.get(), buffer, sizeof buffer, static_cast<off_t>(text.size()))) > 0) {
    text.append(buffer, static_cast<size_t>(count));
  }
  return text;
}

std::vector<std::string> CapturedProcess::OutputLines() const {
  const std::string text = Output();
  std::vector<std::string> lines;
  for (size_t begin = 0, end = text.find('\n'); end != std::string::npos;
       begin = end + 1, end = text.find('\n', begin)) {
    lines.push_back(text.substr(begin, end - begin));
  }
  return lines;
}

int CapturedProcess::OutputLineCount() const {
  const std::string text = Output();
  return std::count(text.begin(), text.end(), '\n');
}

std::vector<std::string> CapturedProcess::LogEnd(size_t lines) const { return LogTail(log_, lines); }

std::string CapturedProcess::LastMessage() const {
  const std::vector<std::string> last = LogEnd(1);
  return last.empty() ? "" : WithoutStamp(last.back());
}

}  // namespace dadrl
