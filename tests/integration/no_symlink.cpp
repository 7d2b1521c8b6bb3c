// Preloaded into a program: a file system without symbolic links (exFAT, some network shares).
#include <cerrno>

extern "C" int symlink(const char*, const char*) {
  errno = EPERM;
  return -1;
}
extern "C" int symlinkat(const char*, int, const char*) {
  errno = EPERM;
  return -1;
}
