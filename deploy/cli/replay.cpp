#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "deploy/cli/command.h"
#include "deploy/local/executables.h"

namespace dadrl {
namespace {

// Becomes dadrl-replay, which alone knows how experience is stored.
Result<int> RunTool(std::vector<std::string> words) {
  DADRL_ASSIGN_OR_RETURN(const auto program, FindExecutable("dadrl-replay"));
  words.insert(words.begin(), {program.string(), "tool"});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  return Fail(ErrorCode::kInternal, "start {}: {}", program.string(), std::strerror(errno));
}

}  // namespace

Command MakeReplayCommand(CLI::App& dadrl) {
  CLI::App* app = dadrl.add_subcommand(
      "replay",
      "Inspect, verify, export, import, snapshot or restore stored experience; limit a running replay");
  app->prefix_command();
  app->set_help_flag();  // the tools have their own
  return {app, [app] { return RunTool(app->remaining()); }};
}

}  // namespace dadrl
