#include "tests/replay/service/replay_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "common/config/config_yaml.h"
#include "common/io/run_key.h"
#include "tests/common/io/test_run_key.h"
#include "tests/paths.h"

namespace dadrl {

ReplayProcess::ReplayProcess(std::filesystem::path run_directory, const Config& config, int shard)
    : run_directory_(std::move(run_directory)), shard_(shard) {
  std::filesystem::create_directories(run_directory_);
  std::ofstream(run_directory_ / "config.yaml") << ToYaml(config, false);
  static_cast<void>(SaveRunKey(run_directory_, kTestRunKey));  // else it says so in its log
}

ReplayProcess::~ReplayProcess() { Kill(); }

void ReplayProcess::Start(std::optional<uint64_t> file_limit) {
  const std::string program = std::string(DADRL_BINARY_DIR) + "/bin/dadrl-replay";
  const std::string config = (run_directory_ / "config.yaml").string();
  const std::string log = LogFile().string();
  const std::string shard = std::to_string(shard_);
  pid_ = fork();
  if (pid_ != 0) return;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  dup2(file, STDERR_FILENO);
  if (file_limit) {
    const rlimit limit{*file_limit, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  execl(program.c_str(), program.c_str(), "--config", config.c_str(), "--run-dir", run_directory_.c_str(),
        "--shard", shard.c_str(), static_cast<char*>(nullptr));
  _exit(127);
}

void ReplayProcess::SetFileLimit(uint64_t bytes) {
  const rlimit limit{bytes, RLIM_INFINITY};
  prlimit(pid_, RLIMIT_FSIZE, &limit, nullptr);
}

bool ReplayProcess::SetDescriptorLimit(uint64_t count) {
  rlimit limit{};
  if (prlimit(pid_, RLIMIT_NOFILE, nullptr, &limit) != 0) return false;
  limit.rlim_cur = count;  // the hard limit stays: not everybody may raise it again
  return prlimit(pid_, RLIMIT_NOFILE, &limit, nullptr) == 0;
}

uint64_t ReplayProcess::Descriptors() const {
  const std::filesystem::directory_iterator open("/proc/" + std::to_string(pid_) + "/fd");
  return static_cast<uint64_t>(std::distance(open, {}));
}

void ReplayProcess::Kill() {
  if (pid_ == 0) return;
  kill(pid_, SIGKILL);
  WaitForExit();
}

void ReplayProcess::Stop() { kill(pid_, SIGSTOP); }
void ReplayProcess::Continue() { kill(pid_, SIGCONT); }

int ReplayProcess::Terminate() {
  kill(pid_, SIGTERM);
  return WaitForExit();
}

int ReplayProcess::WaitForExit() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = 0;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::filesystem::path ReplayProcess::LogFile() const {
  return run_directory_ / (shard_ == 0 ? "log" : "log-" + std::to_string(shard_));
}

std::string ReplayProcess::Log() const {
  std::ifstream file(LogFile());
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace dadrl
