// refuse_calls PROGRAM ARGUMENTS...: becomes PROGRAM in a sandbox that refuses memfd_create, pidfd_open and
// signalfd, as an old kernel or a container's seccomp profile does. Exit code 77: the host has no seccomp.
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const auto refuse_if = [](long call, uint8_t to_refusal) -> sock_filter {
    return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<uint32_t>(call), to_refusal, 0);
  };
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      refuse_if(SYS_memfd_create, 4),
      refuse_if(SYS_pidfd_open, 3),
      refuse_if(SYS_signalfd4, 2),
      refuse_if(SYS_signalfd, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM),
  };
  sock_fprog program{.len = sizeof filter / sizeof filter[0], .filter = filter};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
      prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0) {
    return 77;
  }
  execv(argv[1], argv + 1);
  return 127;
}
