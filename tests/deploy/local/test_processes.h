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

// Gone, or a zombie that its parent has not reaped.
inline bool IsDead(pid_t pid) {
  const std::string stat = FileText("/proc/" + std::to_string(pid) + "/stat");
  const size_t state = stat.rfind(") ");
  return state == std::string::npos || stat[state + 2] == 'Z' || stat[state + 2] == 'X';
}

// The number in a file that a child writes; 0 while there is none.
inline pid_t PidIn(const std::filesystem::path& path) {
  std::ifstream stream(path);
  pid_t pid = 0;
  stream >> pid;
  return pid;
}

}  // namespace dadrl
