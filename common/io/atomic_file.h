// Files that are whole or not there: written beside, forced to the device, renamed into place. A process that
// is killed at any point leaves the earlier file, or the new one, never a mixture.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// One file under way. Not thread safe; every call may block on the disk. Destroyed before Commit: the
// temporary file is removed and `path` is as it was.
class AtomicFile {
 public:
  // Starts a temporary file of a new name in the folder of `path`, which must exist. kInvalidArgument when
  // `path` is there and no regular file: a link, a device or a folder is never replaced.
  static Result<AtomicFile> Create(const std::filesystem::path& path);
  ~AtomicFile();
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;

  Status Append(std::span<const std::byte> bytes);
  // Makes the file durable and visible under its name, replacing an earlier one. The last call.
  Status Commit();

 private:
  AtomicFile(std::filesystem::path path, std::filesystem::path temporary, FileDescriptor file);

  std::filesystem::path path_;
  std::filesystem::path temporary_;  // empty once there is nothing to clean up
  FileDescriptor file_;
};

// The usual case in one call.
Status WriteFileAtomically(const std::filesystem::path& path, std::span<const std::byte> content);
Status WriteFileAtomically(const std::filesystem::path& path, std::string_view text);

// Makes `link` a symbolic link to `target` (relative to the link's folder), replacing an earlier link at
// once. Fails where the file system has none: LinkAtomically (link_file.h) knows what to do then.
Status SymlinkAtomically(const std::filesystem::path& link, const std::filesystem::path& target);

// Removes the temporary files that killed writers left in `directory`. Only for the one process that writes
// there: it would take the file from under another writer. Returns how many.
int RemoveLeftoverTemporaries(const std::filesystem::path& directory);

}  // namespace dadrl
