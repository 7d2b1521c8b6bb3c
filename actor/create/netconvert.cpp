#include "actor/create/netconvert.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "actor/create/root_element.h"
#include "actor/sim/memory_file.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostSaid = 600;
constexpr const char* kBridgeMetres = "6";

std::string OneLine(std::string text) {
  for (char& c : text) c = c == '\n' ? ' ' : c;
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return Shown(text, kMostSaid);
}

// As the scenarios that ship are built; `dadrl scenario new` on another's plain XML gives the same network.
std::vector<std::string> CommonOptions(const RoadSource& source, const fs::path& output) {
  std::vector<std::string> options{"--output-file",
                                   output.string(),
                                   "--no-turnarounds",
                                   "true",
                                   "--junctions.corner-detail",
                                   "5",
                                   "--junctions.limit-turn-speed",
                                   "5.5",
                                   "--rectangular-lane-cut",
                                   "false",
                                   "--xml-validation",
                                   "never",
                                   "--verbose",
                                   "false",
                                   "--no-warnings",
                                   "true"};
  if (source.left_hand) options.insert(options.end(), {"--lefthand", "true"});
  return options;
}

// What a map does not say and streets have: a roundabout's right of way, which signals are one junction, how
// high a bridge is.
std::vector<std::string> MapOptions(const fs::path& file) {
  return {"--osm-files",
          file.string(),
          "--geometry.remove",
          "true",
          "--roundabouts.guess",
          "true",
          "--junctions.join",
          "true",
          "--tls.guess-signals",
          "true",
          "--tls.discard-simple",
          "true",
          "--tls.join",
          "true",
          "--output.street-names",
          "true",
          "--osm.layer-elevation",
          kBridgeMetres};
}

// NAME of NAME.nod.xml, whichever of the plain files is given.
Result<std::string> PlainStem(const fs::path& file) {
  for (const char* kind : {".nod.xml", ".edg.xml", ".con.xml", ".tll.xml", ".typ.xml"}) {
    if (file.string().ends_with(kind)) return file.string().substr(0, file.string().size() - 8);
  }
  return Fail(ErrorCode::kInvalidArgument,
              "--net: {} is plain XML; call its files NAME.nod.xml, NAME.edg.xml, NAME.con.xml and give one",
              file.string());
}

Result<std::vector<std::string>> PlainOptions(const fs::path& file) {
  DADRL_ASSIGN_OR_RETURN(const std::string stem, PlainStem(file));
  struct Kind {
    const char* suffix;
    const char* option;
    bool needed;
  };
  std::vector<std::string> options;
  for (const Kind& kind :
       {Kind{".nod.xml", "--node-files", true}, Kind{".edg.xml", "--edge-files", true},
        Kind{".con.xml", "--connection-files", false}, Kind{".tll.xml", "--tllogic-files", false},
        Kind{".typ.xml", "--type-files", false}}) {
    std::error_code error;
    if (fs::exists(stem + kind.suffix, error)) {
      options.insert(options.end(), {kind.option, stem + kind.suffix});
    } else if (kind.needed) {
      return Fail(ErrorCode::kNotFound, "--net: {} needs {}{} beside it", file.string(), stem, kind.suffix);
    }
  }
  // Where its author drew it.
  options.insert(options.end(), {"--offset.disable-normalization", "true"});
  return options;
}

Status Convert(const RoadSource& source, std::vector<std::string> input, const fs::path& output) {
  std::vector<std::string> command{"netconvert"};
  command.insert(command.end(), input.begin(), input.end());
  for (std::string& option : CommonOptions(source, output)) command.push_back(std::move(option));
  DADRL_ASSIGN_OR_RETURN(const std::string said, RunProgram(command));
  std::error_code error;
  if (fs::exists(output, error)) return {};
  return Fail(ErrorCode::kInvalidArgument, "netconvert makes no network of {}: {}", source.file.string(),
              said);
}

Status CopyNetwork(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, error);
  if (!error) return {};
  return Fail(ErrorCode::kInternal, "cannot copy {} to {}: {}", from.string(), to.string(), error.message());
}

}  // namespace

Result<std::string> RunProgram(const std::vector<std::string>& command) {
  DADRL_ASSIGN_OR_RETURN(const MemoryFile log, MemoryFile::Create("program-log"));
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, log.path().c_str(), O_WRONLY | O_APPEND, 0);
  pid_t pid = -1;
  const int failed = posix_spawnp(&pid, words[0], &actions, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed == ENOENT) {
    return Fail(ErrorCode::kNotFound, "{} is not in PATH: apt-get install --no-install-recommends sumo",
                command.front());
  }
  if (failed != 0) {
    return Fail(ErrorCode::kInternal, "cannot start {}: {}", command.front(), std::strerror(failed));
  }
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
  std::string said = OneLine(log.Read());
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return said;
  return Fail(ErrorCode::kInvalidArgument, "{} ended with {} {}: {}", command.front(),
              WIFEXITED(status) ? "exit code" : "signal",
              WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status), said);
}

Status BuildNetwork(const RoadSource& source, const fs::path& output) {
  DADRL_ASSIGN_OR_RETURN(const std::string root, RootElement(source.file));
  if (source.osm) {
    if (root == "osm" || root == "?") return Convert(source, MapOptions(source.file), output);
    return Fail(ErrorCode::kInvalidArgument, "--osm: {} is not an OpenStreetMap extract: {}",
                source.file.string(),
                root.empty() ? "it is not XML (convert .pbf with osmium)"
                             : fmt::format("its root is <{}>, not <osm>{}", Shown(root),
                                           root == "net" ? "; give it as --net" : ""));
  }
  if (root == "net" || root == "?") {
    if (!source.left_hand) return CopyNetwork(source.file, output);
    return Fail(ErrorCode::kInvalidArgument,
                "--left-hand: {} is built already and says on which side one drives", source.file.string());
  }
  if (root.empty() || root == "osm") {
    return Fail(ErrorCode::kInvalidArgument, "--net: {} is not a road network{}", source.file.string(),
                root == "osm" ? ", but an OpenStreetMap extract; give it as --osm" : ": it is not XML");
  }
  DADRL_ASSIGN_OR_RETURN(std::vector<std::string> input, PlainOptions(source.file));
  return Convert(source, std::move(input), output);
}

}  // namespace dadrl
