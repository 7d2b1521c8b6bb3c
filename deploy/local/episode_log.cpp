#include "deploy/local/episode_log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>

#include "proto/evaluation/episode_summary.h"

namespace dadrl {
namespace {

constexpr std::string_view kHeader =
    "time_s,actor,episode,seed,outcome,steps,return,progress,mean_speed_mps,humanness_error,overall_score,"
    "policy_version,scenario\n";

// Bytes up to and including the last line break.
off_t WholeRows(const FileDescriptor& file) {
  struct stat info {};
  if (fstat(file.get(), &info) != 0) return 0;
  char c = 0;
  off_t end = info.st_size;
  while (end > 0 && pread(file.get(), &c, 1, end - 1) == 1 && c != '\n') --end;
  return end;
}

}  // namespace

Result<EpisodeLog> EpisodeLog::Open(const std::filesystem::path& path) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, FileDescriptor::Open(path, O_RDWR | O_CREAT | O_APPEND));
  const off_t whole = WholeRows(file);
  if (ftruncate(file.get(), whole) != 0) {
    return Fail(ErrorCode::kInternal, "cannot write {}: {}", path.string(), std::strerror(errno));
  }
  if (whole == 0) DADRL_RETURN_IF_ERROR(AppendWhole(file, std::as_bytes(std::span(kHeader)), path));
  return EpisodeLog(path, std::move(file));
}

Status EpisodeLog::Append(const EpisodeReport& report) {
  const std::string row =
      fmt::format("{:.3f},{},{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{}\n",
                  static_cast<double>(report.sent_ns) / 1e9, report.actor, report.episode, report.seed,
                  OutcomeName(static_cast<Outcome>(report.outcome)), report.steps, report.episode_return,
                  report.progress, report.mean_speed_mps, report.humanness_error, report.overall_score,
                  report.policy_version, report.scenario);
  return AppendWhole(file_, std::as_bytes(std::span(row)), path_);
}

}  // namespace dadrl
