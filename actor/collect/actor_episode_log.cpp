#include "actor/collect/actor_episode_log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

namespace dadrl {
namespace {

constexpr std::string_view kHeader =
    "time_s,incarnation,episode,seed,outcome,steps,return,progress,mean_speed_mps,humanness_error,obstacle_"
    "cost,"
    "jerk_cost,lane_offset_cost,rule_violation,distance_to_destination,time_cost,overall_score,policy_"
    "version,scenario\n";

Error Failure(const std::filesystem::path& path, int error) {
  return {ErrorCode::kInternal, fmt::format("cannot write {}: {}", path.string(), std::strerror(error))};
}

// Bytes up to and including the last line break.
off_t WholeRows(const FileDescriptor& file) {
  struct stat info {};
  if (fstat(file.get(), &info) != 0) return 0;
  off_t end = info.st_size;
  for (char c = 0; end > 0 && pread(file.get(), &c, 1, end - 1) == 1 && c != '\n';) --end;
  return end;
}

}  // namespace

Result<ActorEpisodeLog> ActorEpisodeLog::Open(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  if (error) return tl::unexpected<Error>(Failure(path, error.value()));
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, FileDescriptor::Open(path, O_RDWR | O_CREAT | O_APPEND));
  const off_t whole = WholeRows(file);
  if (ftruncate(file.get(), whole) != 0) return tl::unexpected<Error>(Failure(path, errno));
  if (whole == 0) DADRL_RETURN_IF_ERROR(AppendWhole(file, std::as_bytes(std::span(kHeader)), path));
  return ActorEpisodeLog(path, std::move(file));
}

Status ActorEpisodeLog::Append(uint64_t incarnation, int64_t wall_time_ns, const CollectedEpisode& episode) {
  const EpisodeSummary& s = episode.summary;
  const std::string row = fmt::format(
      "{:.3f},{},{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},"
      "{}"
      "\n",
      static_cast<double>(wall_time_ns) / 1e9, incarnation, episode.episode, s.seed, OutcomeName(s.outcome),
      s.steps, s.episode_return, s.progress, s.mean_speed_mps, s.humanness_error, s.obstacle_cost,
      s.jerk_cost, s.lane_offset_cost, s.rule_violation, s.distance_to_destination, s.time_cost,
      s.overall_score, episode.policy_version, s.scenario);
  return AppendWhole(file_, std::as_bytes(std::span(row)), path_);
}

}  // namespace dadrl
