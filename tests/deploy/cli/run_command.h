// Runs a program to its end and keeps what it said.
#pragma once

#include <gtest/gtest.h>
#include <poll.h>

#include <string>
#include <vector>

#include "deploy/local/child_process.h"
#include "tests/deploy/local/test_processes.h"
#include "tests/paths.h"

namespace dadrl {

struct CommandOutput {
  int exit_code = -1;  // -1: it died, or did not end in time
  std::string out;
  std::string err;
};

inline CommandOutput RunCommand(std::vector<std::string> command, int timeout_s = 60) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto err = folder.path() / "err";
  std::FILE* stream = std::fopen(out.c_str(), "we");
  auto child = ChildProcess::Spawn({.command = std::move(command), .log = err, .stdout_fd = fileno(stream)});
  std::fclose(stream);
  if (!child) return {.exit_code = -1, .out = "", .err = child.error().message};
  pollfd fd{.fd = child->pidfd(), .events = POLLIN, .revents = 0};
  CommandOutput result;
  if (poll(&fd, 1, 1000 * timeout_s) == 1) {
    const auto status = child->TryWait();
    if (status && !status->signaled) result.exit_code = status->value;
  }
  result.out = FileText(out);
  result.err = FileText(err);
  return result;
}

inline std::string DadrlProgram() { return DADRL_BINARY_DIR "/bin/dadrl"; }

// `dadrl` with these arguments.
inline CommandOutput Dadrl(std::vector<std::string> arguments, int timeout_s = 60) {
  arguments.insert(arguments.begin(), DadrlProgram());
  return RunCommand(std::move(arguments), timeout_s);
}

}  // namespace dadrl
