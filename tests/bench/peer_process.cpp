#include "tests/bench/peer_process.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>
#include <type_traits>

namespace dadrl::bench {

static_assert(std::is_trivially_copyable_v<Numbers>);  // they cross a pipe

PeerProcess::PeerProcess(const std::function<Numbers()>& work) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe for a peer");
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("no process for a peer");
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const Numbers numbers = work();
    _exit(write(ends[1], &numbers, sizeof(numbers)) == sizeof(numbers) ? 0 : 1);
  }
  close(ends[1]);
  results_ = ends[0];
}

PeerProcess::~PeerProcess() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  close(results_);
}

Numbers PeerProcess::Wait() {
  Numbers numbers;
  const ssize_t bytes = read(results_, &numbers, sizeof(numbers));
  waitpid(pid_, nullptr, 0);
  pid_ = 0;
  if (bytes != sizeof(numbers)) throw std::runtime_error("a peer failed");
  return numbers;
}

}  // namespace dadrl::bench
