// The real executable as a child of the test, in a run directory of its own.
#pragma once

#include <sys/resource.h>

#include <filesystem>
#include <optional>
#include <string>

#include "common/config/config.h"

namespace dadrl {

// Not thread safe. Killed when it goes out of scope.
class ReplayProcess {
 public:
  // Writes `config` and kTestRunKey to the run directory; nothing runs yet.
  ReplayProcess(std::filesystem::path run_directory, const Config& config, int shard = 0);
  ~ReplayProcess();
  ReplayProcess(const ReplayProcess&) = delete;
  ReplayProcess& operator=(const ReplayProcess&) = delete;

  // `file_limit`: largest file it may write, bytes; beyond it every write fails as on a full disk.
  void Start(std::optional<uint64_t> file_limit = std::nullopt);
  void SetFileLimit(uint64_t bytes);
  // Bounds the numbers of descriptors that it opens from now on; false: the system does not let us.
  bool SetDescriptorLimit(uint64_t count);
  uint64_t Descriptors() const;
  void Kill();              // -9, and waits
  void Stop();              // SIGSTOP
  void Continue();          // SIGCONT
  int Terminate();          // SIGTERM; its exit code
  int WaitForExit();        // its exit code; 128 + signal
  std::string Log() const;  // all it has said on standard error

 private:
  std::filesystem::path LogFile() const;

  std::filesystem::path run_directory_;
  const int shard_;
  int pid_ = 0;
};

}  // namespace dadrl
