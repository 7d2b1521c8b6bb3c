// Helpers for tests that run real children and look at them from outside.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/common/io/temporary_folder.h"
#include "tests/common/util/eventually.h"

namespace dadrl {

inline std::string FileText(const std::filesystem::path& path) {
  std::ifstream stream(path);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

// As in /proc: 'S' sleeps, 'T' is stopped, 'Z' is a zombie; 'X' is gone.
inline char StateOf(pid_t pid) {
  const std::string stat = FileText("/proc/" + std::to_string(pid) + "/stat");
  const size_t state = stat.rfind(") ");
  return state == std::string::npos ? 'X' : stat[state + 2];
}

// Gone, or a zombie that its parent has not reaped.
inline bool IsDead(pid_t pid) {
  const char state = StateOf(pid);
  return state == 'Z' || state == 'X';
}

// By a signal.
inline bool IsStopped(pid_t pid) { return StateOf(pid) == 'T'; }

// The first child of a process; 0 while it has none.
inline pid_t ChildOf(pid_t pid) {
  const std::string task = "/proc/" + std::to_string(pid) + "/task/" + std::to_string(pid);
  std::ifstream children(task + "/children");
  pid_t child = 0;
  children >> child;
  return child;
}

// The number in a file that a child writes; 0 while there is none.
inline pid_t PidIn(const std::filesystem::path& path) {
  std::ifstream stream(path);
  pid_t pid = 0;
  stream >> pid;
  return pid;
}

}  // namespace dadrl
