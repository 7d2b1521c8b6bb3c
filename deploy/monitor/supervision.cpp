#include "deploy/monitor/supervision.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "common/io/file_descriptor.h"
#include "common/io/io_error.h"
#include "common/io/json_text.h"
#include "common/io/read_file.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t kMaxBytes = uint64_t{4} << 20;
constexpr int kMaxPid = INT32_MAX;
constexpr int kMaxCount = 1'000'000;
constexpr size_t kMaxText = 1000;

Json ProcessJson(const SupervisedProcess& process) {
  return {{"name", process.name},       {"pid", process.pid},           {"state", process.state},
          {"trouble", process.trouble}, {"fault", process.fault},       {"restarts", process.restarts},
          {"hangs", process.hangs},     {"last_end", process.last_end}, {"since_ns", process.since_ns}};
}

// Another's run may hold anything, and this goes to a terminal.
std::string ShownText(JsonFields& fields, const char* key) {
  return Shown(fields.Text(key, kMaxText), kMaxText);
}

SupervisedProcess ProcessFrom(JsonFields& fields) {
  return {.name = ShownText(fields, "name"),
          .pid = fields.Whole("pid", kMaxPid),
          .state = ShownText(fields, "state"),
          .trouble = ShownText(fields, "trouble"),
          .fault = ShownText(fields, "fault"),
          .restarts = fields.Whole("restarts", kMaxCount),
          .hangs = fields.Whole("hangs", kMaxCount),
          .last_end = ShownText(fields, "last_end"),
          .since_ns = fields.Whole("since_ns", INT64_MAX)};
}

// "PID (name) T ...": stopped by a signal, and not by a debugger (t).
bool IsStopped(pid_t pid, const std::filesystem::path& proc) {
  std::ifstream stat(proc / fmt::format("{}", pid) / "stat");
  std::string line;
  std::getline(stat, line);
  const size_t name_end = line.rfind(") ");
  return name_end != std::string::npos && line.compare(name_end, 3, ") T") == 0;
}

}  // namespace

std::vector<std::string> Supervision::Troubles() const {
  std::vector<std::string> troubles;
  for (const SupervisedProcess& process : processes) {
    if (!process.trouble.empty()) troubles.push_back(fmt::format("{}: {}", process.name, process.trouble));
  }
  return troubles;
}

const SupervisedProcess* Supervision::Find(const std::string& name) const {
  const auto found = std::find_if(processes.begin(), processes.end(),
                                  [&](const SupervisedProcess& process) { return process.name == name; });
  return found == processes.end() ? nullptr : &*found;
}

std::string SupervisionJson(const Supervision& supervision) {
  Json processes = Json::array();
  for (const SupervisedProcess& process : supervision.processes) processes.push_back(ProcessJson(process));
  const Json json = {{"launcher", supervision.launcher}, {"processes", std::move(processes)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

Result<Supervision> ParseSupervision(const std::string& text) {
  DADRL_ASSIGN_OR_RETURN(const Json json, ParseJson(text, "list of processes"));
  JsonFields fields(json);
  Supervision supervision{.launcher = fields.Whole("launcher", kMaxPid), .processes = {}};
  const Json* const processes = fields.Find("processes");
  if (processes == nullptr || !processes->is_array()) fields.Refuse("processes");
  if (!fields.ok()) return Fail(ErrorCode::kCorrupt, "list of processes: bad '{}'", fields.bad());
  for (const Json& process : *processes) {
    JsonFields of_process(process);
    supervision.processes.push_back(ProcessFrom(of_process));
    if (!of_process.ok()) {
      return Fail(ErrorCode::kCorrupt, "list of processes: bad '{}' of a process", of_process.bad());
    }
  }
  return supervision;
}

namespace {

Status Replace(const std::filesystem::path& path, const Supervision& supervision) {
  const std::filesystem::path beside = path.string() + ".new";
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor file, FileDescriptor::Open(beside, O_WRONLY | O_CREAT));
  if (ftruncate(file.get(), 0) != 0) return tl::unexpected(IoError("empty", beside, errno));
  const std::string text = SupervisionJson(supervision) + "\n";
  DADRL_RETURN_IF_ERROR(WriteAll(file, std::as_bytes(std::span(text)), beside));
  std::error_code error;
  std::filesystem::rename(beside, path, error);
  if (error) return tl::unexpected(IoError("replace", path, error.value()));
  return {};
}

}  // namespace

Status SaveSupervision(const std::filesystem::path& path, const Supervision& supervision) {
  Status saved = Replace(path, supervision);
  std::error_code ignored;
  if (!saved) std::filesystem::remove(path, ignored);
  return saved;
}

Result<Supervision> LoadSupervision(const std::filesystem::path& file) {
  DADRL_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(file, kMaxBytes));
  return ParseSupervision(text);
}

void AddStopped(Supervision& supervision, const std::filesystem::path& proc) {
  for (SupervisedProcess& process : supervision.processes) {
    if (process.pid <= 0 || !process.trouble.empty() || !IsStopped(process.pid, proc)) continue;
    process.trouble = "stopped by a signal";
  }
  if (supervision.launcher <= 0 || !IsStopped(supervision.launcher, proc)) return;
  supervision.processes.push_back(
      {.name = "launcher",
       .pid = supervision.launcher,
       .state = "stopped",
       .trouble = fmt::format("stopped by a signal: nothing is supervised until kill -CONT {} (or fg)",
                              supervision.launcher),
       .fault = {},
       .last_end = {}});
}

}  // namespace dadrl
