#include "common/io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>

#include "common/io/io_error.h"

namespace dadrl {
namespace {

constexpr std::string_view kTemporarySuffix = ".dadrl-tmp";
constexpr unsigned kNewFileMode = 0644;

std::filesystem::path FolderOf(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

// Unique among the threads of this process and among processes.
std::filesystem::path TemporaryFor(const std::filesystem::path& path) {
  static std::atomic<uint64_t> counter{0};
  return FolderOf(path) /
         fmt::format(".{}.{}-{}{}", path.filename().string(), ::getpid(), counter++, kTemporarySuffix);
}

// Calls `create(temporary)` with new names until one is not taken: a killed process of the same number may
// have left one, and what is there is never written to. `create` returns -1 with errno.
template <typename Create>
Result<std::filesystem::path> CreateBeside(const std::filesystem::path& path, Create create) {
  constexpr int kAttempts = 100;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::filesystem::path temporary = TemporaryFor(path);
    if (create(temporary) >= 0) return temporary;
    if (errno != EEXIST && errno != EINTR) return tl::unexpected<Error>(IoError("create", temporary, errno));
  }
  return tl::unexpected<Error>(IoError("create", TemporaryFor(path), EEXIST));
}

// What stands under a name that is about to be taken.
Status RequireReplaceable(const std::filesystem::path& path) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0 || S_ISREG(info.st_mode)) return {};
  return Fail(ErrorCode::kInvalidArgument, "{} is there and is {}: it is not replaced; name another file",
              path.string(),
              S_ISLNK(info.st_mode)   ? "a link"
              : S_ISDIR(info.st_mode) ? "a folder"
                                      : "a device, a FIFO or a socket");
}

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path, std::filesystem::path temporary, FileDescriptor file)
    : path_(std::move(path)), temporary_(std::move(temporary)), file_(std::move(file)) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      file_(std::move(other.file_)) {}

AtomicFile::~AtomicFile() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Result<AtomicFile> AtomicFile::Create(const std::filesystem::path& path) {
  DADRL_RETURN_IF_ERROR(RequireReplaceable(path));
  int fd = -1;
  DADRL_ASSIGN_OR_RETURN(std::filesystem::path temporary, CreateBeside(path, [&](const auto& name) {
                           return fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC,
                                              kNewFileMode);
                         }));
  return AtomicFile(path, std::move(temporary), FileDescriptor(fd));
}

Status AtomicFile::Append(std::span<const std::byte> bytes) { return WriteAll(file_, bytes, path_); }

Status AtomicFile::Commit() {
  DADRL_RETURN_IF_ERROR(SyncFile(file_, path_));
  file_.Close();
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) {
    return tl::unexpected<Error>(IoError("replace", path_, errno));
  }
  temporary_.clear();
  return SyncDirectory(FolderOf(path_));
}

Status WriteFileAtomically(const std::filesystem::path& path, std::span<const std::byte> content) {
  auto file = AtomicFile::Create(path);
  if (!file) return tl::unexpected<Error>(std::move(file.error()));
  DADRL_RETURN_IF_ERROR(file->Append(content));
  return file->Commit();
}

Status WriteFileAtomically(const std::filesystem::path& path, std::string_view text) {
  return WriteFileAtomically(path, std::as_bytes(std::span(text)));
}

Status SymlinkAtomically(const std::filesystem::path& link, const std::filesystem::path& target) {
  DADRL_ASSIGN_OR_RETURN(const std::filesystem::path temporary, CreateBeside(link, [&](const auto& name) {
                           return ::symlink(target.c_str(), name.c_str());
                         }));
  if (::rename(temporary.c_str(), link.c_str()) != 0) {
    const int error = errno;
    ::unlink(temporary.c_str());
    return tl::unexpected<Error>(IoError("replace", link, error));
  }
  return SyncDirectory(FolderOf(link));
}

int RemoveLeftoverTemporaries(const std::filesystem::path& directory) {
  int removed = 0;
  std::error_code ignored;  // a folder that cannot be listed has nothing to remove
  for (const auto& entry : std::filesystem::directory_iterator(directory, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.') && name.ends_with(kTemporarySuffix))
      removed += ::unlink(entry.path().c_str()) == 0;
  }
  return removed;
}

}  // namespace dadrl
