#include "deploy/local/folder_check.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <vector>

#include "common/io/file_descriptor.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kName = "file system";

bool CanLock(const fs::path& file) {
  const auto opened = FileDescriptor::Open(file, O_RDWR);
  struct flock exclusive {};
  exclusive.l_type = F_WRLCK;
  exclusive.l_whence = SEEK_SET;
  return opened &&
         (fcntl(opened->get(), F_OFD_SETLK, &exclusive) == 0 || flock(opened->get(), LOCK_EX | LOCK_NB) == 0);
}

MachineCheck Probe(const fs::path& folder) {
  const fs::path file = folder / "file";
  if (const auto made = FileDescriptor::Open(file, O_RDWR | O_CREAT | O_EXCL); !made) {
    return {kName, CheckState::kWarning, made.error().message, "choose a --run-dir elsewhere"};
  }
  std::vector<std::string> missing;
  if (symlink("file", (folder / "symbolic").c_str()) != 0) {
    missing.emplace_back("symbolic links (small files name the newest policy and run instead)");
  }
  if (link(file.c_str(), (folder / "hard").c_str()) != 0) {
    missing.emplace_back("hard links (snapshots are copies)");
  }
  const bool locks = CanLock(file);
  if (!locks) missing.emplace_back("locks (a run is refused there)");
  if (missing.empty()) return {kName, CheckState::kGood, "links and locks work in the current folder", ""};
  return {kName, CheckState::kWarning,
          fmt::format("the current folder has no {}", fmt::join(missing, ", no ")),
          locks ? "nothing to do, or choose a --run-dir elsewhere" : "choose a --run-dir elsewhere"};
}

}  // namespace

MachineCheck CheckFolder(const fs::path& folder) {
  std::string probe = (folder / ".dadrl-doctor-XXXXXX").string();
  if (mkdtemp(probe.data()) == nullptr) {
    return {kName, CheckState::kWarning,
            fmt::format("nothing can be written in {}: {}", folder.string(), std::strerror(errno)),
            "choose a --run-dir elsewhere"};
  }
  MachineCheck check = Probe(probe);
  std::error_code ignored;
  fs::remove_all(probe, ignored);
  return check;
}

}  // namespace dadrl
