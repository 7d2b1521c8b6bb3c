#include "common/io/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>

#include "common/io/io_error.h"

namespace dadrl {
namespace {

constexpr std::string_view kTemporarySuffix = ".dadrl-tmp";

std::filesystem::path FolderOf(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

// Unique among the threads of this process and among processes.
std::filesystem::path TemporaryFor(const std::filesystem::path& path) {
  static std::atomic<uint64_t> counter{0};
  return FolderOf(path) /
         fmt::format(".{}.{}-{}{}", path.filename().string(), ::getpid(), counter++, kTemporarySuffix);
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
  std::filesystem::path temporary = TemporaryFor(path);
  auto file = FileDescriptor::Open(temporary, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file) return tl::unexpected<Error>(std::move(file.error()));
  return AtomicFile(path, std::move(temporary), std::move(*file));
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

Status LinkAtomically(const std::filesystem::path& link, const std::filesystem::path& target) {
  const std::filesystem::path temporary = TemporaryFor(link);
  if (::symlink(target.c_str(), temporary.c_str()) != 0) {
    return tl::unexpected<Error>(IoError("link", link, errno));
  }
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
