#include "deploy/local/evaluation_job.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "common/config/config_schema.h"
#include "deploy/local/executables.h"
#include "deploy/local/log_tail.h"

namespace dadrl {
namespace {

constexpr int kMaxAttempts = 2;
constexpr int kSlicesPerProcess = 4;
constexpr size_t kTailLines = 8;

Result<FileDescriptor> MemoryFile(const char* name) {
  FileDescriptor file(memfd_create(name, MFD_CLOEXEC));
  if (!file.valid()) return Fail(ErrorCode::kExhausted, "memfd_create: {}", std::strerror(errno));
  return file;
}

std::filesystem::path PathOf(const FileDescriptor& file) {
  return fmt::format("/proc/self/fd/{}", file.get());
}

std::string Content(const FileDescriptor& file) {
  std::string text;
  char buffer[1 << 16];
  ssize_t count = 0;
  while ((count = pread(file.get(), buffer, sizeof buffer, static_cast<off_t>(text.size()))) > 0) {
    text.append(buffer, static_cast<size_t>(count));
  }
  return text;
}

int CompleteLines(const FileDescriptor& file) {
  const std::string text = Content(file);
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

// The message of a log line (common/util/log.h: stamp, level, role, colon).
std::string WithoutStamp(const std::string& line) {
  const size_t role = line.find(" E ");
  const size_t colon = role == std::string::npos ? std::string::npos : line.find(": ", role);
  return colon == std::string::npos ? line : line.substr(colon + 2);
}

// What is left of `slice` after its first `done` episodes.
EvaluationSlice Rest(const EvaluationSlice& slice, int done) {
  return {slice.group, slice.first_seed + static_cast<uint64_t>(done), slice.count - done};
}

}  // namespace

std::vector<EvaluationSlice> SliceEpisodes(const std::vector<PlannedEpisode>& episodes, int processes) {
  const int total = static_cast<int>(episodes.size());
  const int pieces = kSlicesPerProcess * std::max(1, processes);
  const int size = std::max(1, (total + pieces - 1) / pieces);
  std::vector<EvaluationSlice> slices;
  for (const PlannedEpisode& episode : episodes) {
    const bool fits = !slices.empty() && slices.back().group == episode.group && slices.back().count < size &&
                      slices.back().first_seed + static_cast<uint64_t>(slices.back().count) == episode.seed;
    if (!fits) slices.push_back({episode.group, episode.seed, 0});
    ++slices.back().count;
  }
  return slices;
}

Result<EvaluationJob> EvaluationJob::Create(EvaluationPlan plan) {
  DADRL_ASSIGN_OR_RETURN(const auto episodes, PlanEpisodes(plan.first_seed, plan.groups, plan.episodes));
  EvaluationJob job(std::move(plan));
  const std::vector<std::string> scenarios =
      job.plan_.scenario == kAllScenarios ? ScenarioNames() : std::vector{job.plan_.scenario};
  job.planned_ = static_cast<int>(episodes.size() * scenarios.size());
  for (const std::string& scenario : scenarios) {
    for (const EvaluationSlice& slice : SliceEpisodes(episodes, job.plan_.processes)) {
      job.waiting_.push_back({scenario, slice});
    }
  }
  std::reverse(job.waiting_.begin(), job.waiting_.end());
  return job;
}

void EvaluationJob::AppendWaitFds(std::vector<pollfd>& fds) const {
  for (const Worker& worker : running_) {
    fds.push_back({.fd = worker.child.pidfd(), .events = POLLIN, .revents = 0});
  }
}

std::vector<pid_t> EvaluationJob::RunningPids() const {
  std::vector<pid_t> pids;
  for (const Worker& worker : running_) pids.push_back(worker.child.pid());
  return pids;
}

Result<EvaluationJob::Worker> EvaluationJob::Launch(const Waiting& next) const {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor lines, MemoryFile("evaluation"));
  DADRL_ASSIGN_OR_RETURN(FileDescriptor log, MemoryFile("evaluation-log"));
  std::vector<std::string> command = {
      plan_.program, "evaluate",
      "--policy",    plan_.policy,
      "--scenario",  next.scenario,
      "--seeds",     fmt::format("{}:{}", next.slice.first_seed, next.slice.count)};
  if (!plan_.config.empty()) command.insert(command.end(), {"--config", plan_.config});
  command.insert(command.end(), plan_.policy_arguments.begin(), plan_.policy_arguments.end());
  DADRL_ASSIGN_OR_RETURN(
      ChildProcess child,
      ChildProcess::Spawn(
          {.command = std::move(command), .log = PathOf(log), .stdout_fd = lines.get(), .nice = plan_.nice}));
  return Worker{next.scenario,    next.slice,       next.attempts + 1,
                std::move(child), std::move(lines), std::move(log)};
}

void EvaluationJob::Step() {
  for (size_t i = 0; i < running_.size();) {
    const auto status = running_[i].child.TryWait();
    if (!status) {
      ++i;
      continue;
    }
    Worker ended = std::move(running_[i]);
    running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(i));
    Gather(ended, *status);
  }
  while (!error_ && !waiting_.empty() && static_cast<int>(running_.size()) < plan_.processes) {
    const Waiting next = waiting_.back();
    waiting_.pop_back();
    Result<Worker> worker = Launch(next);
    if (worker) {
      running_.push_back(std::move(*worker));
    } else {
      error_ = worker.error();
    }
  }
  if (error_) running_.clear();
}

void EvaluationJob::Gather(Worker& worker, const ExitStatus& status) {
  const std::string text = Content(worker.lines);
  int done = 0;
  for (size_t begin = 0, end = text.find('\n'); end != std::string::npos;
       begin = end + 1, end = text.find('\n', begin)) {
    Result<EvaluatedEpisode> episode = ParseEpisodeLine(std::string_view(text).substr(begin, end - begin));
    const uint64_t expected = worker.slice.first_seed + static_cast<uint64_t>(done);
    if (!episode || episode->summary.seed != expected || done == worker.slice.count) {
      error_ = Error{
          ErrorCode::kInternal,
          fmt::format("{} printed what is not the result of seed {}: {}", plan_.program.string(), expected,
                      episode ? fmt::format("seed {}", episode->summary.seed) : episode.error().message)};
      return;
    }
    episode->group = worker.slice.group;
    episode->summary.scenario = worker.scenario;
    episodes_.push_back(std::move(*episode));
    ++done;
  }
  if (done == worker.slice.count) return;
  HandleDeath(worker, status, done);
}

void EvaluationJob::HandleDeath(const Worker& worker, const ExitStatus& status, int done) {
  const EvaluationSlice rest = Rest(worker.slice, done);
  const bool refused = !status.signaled && status.value == 2;
  // One retry for each episode: progress starts the count anew.
  const int attempts = done > 0 ? 1 : worker.attempts;
  if (!refused && attempts < kMaxAttempts) {
    waiting_.push_back({worker.scenario, rest, attempts});
    return;
  }
  const std::vector<std::string> log = LogTail(PathOf(worker.log), kTailLines);
  if (status.signaled) {
    // The simulator aborts on this traffic: the episode is lost, the evaluation is not.
    EvaluatedEpisode lost;
    lost.group = rest.group;
    lost.summary.scenario = worker.scenario;
    lost.summary.seed = rest.first_seed;
    lost.error = fmt::format("its process ended twice, last with {}: {}", status.Describe(),
                             log.empty() ? "" : WithoutStamp(log.back()));
    episodes_.push_back(std::move(lost));
    if (rest.count > 1) waiting_.push_back({worker.scenario, Rest(rest, 1), 0});
    return;
  }
  if (refused && !log.empty()) {
    error_ = Error{ErrorCode::kInvalidArgument, WithoutStamp(log.back())};
    return;
  }
  std::string message = fmt::format("evaluation failed at seed {} ({})", rest.first_seed, status.Describe());
  for (const std::string& line : log) message += "\n  | " + line;
  error_ = Error{ErrorCode::kInternal, std::move(message)};
}

int EvaluationJob::finished_episodes() const {
  int count = static_cast<int>(episodes_.size());
  for (const Worker& worker : running_) count += CompleteLines(worker.lines);
  return count;
}

Result<EvaluationReport> EvaluationJob::TakeReport() {
  if (error_) return tl::unexpected<Error>(*error_);
  EvaluationReport report = MakeReport(plan_.scenario, plan_.policy_label, std::move(episodes_));
  if (report.all.episodes == 0) {
    return Fail(ErrorCode::kInternal, "the simulator lost all {} episodes; the first: {}", report.lost,
                report.episodes.empty() ? "" : report.episodes.front().error);
  }
  return report;
}

}  // namespace dadrl
