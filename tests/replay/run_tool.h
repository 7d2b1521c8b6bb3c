// Runs `dadrl-replay tool ...` to its end and keeps what it said.
#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/paths.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {

struct ToolOutput {
  int exit_code = -1;
  std::string out;
  std::string err;
};

inline ToolOutput RunShell(const std::string& command) {
  const MemoryFolder folder;
  const std::string err = (folder.path() / "err").string();
  ToolOutput result;
  std::FILE* pipe = popen((command + " 2>" + err).c_str(), "r");
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) result.out += static_cast<char>(c);
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  std::ifstream file(err);
  result.err.assign(std::istreambuf_iterator<char>(file), {});
  return result;
}

// Words without spaces or quotes.
inline ToolOutput RunTool(const std::vector<std::string>& words) {
  std::string command = DADRL_BINARY_DIR "/bin/dadrl-replay tool";
  for (const std::string& word : words) command += " " + word;
  return RunShell(command);
}

}  // namespace dadrl
