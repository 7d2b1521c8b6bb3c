#include "common/io/io_error.h"

#include <cerrno>
#include <system_error>

namespace dadrl {
namespace {

struct Remedy {
  ErrorCode code;
  std::string_view text;
};

Remedy RemedyFor(int error_number) {
  switch (error_number) {
    case ENOSPC:
      return {ErrorCode::kExhausted, "free some disk space; what was there before is intact"};
    case EDQUOT:
      return {ErrorCode::kExhausted,
              "the disk quota is used up: free space; what was there before is intact"};
    case EFBIG:
      return {ErrorCode::kExhausted, "raise the file size limit (ulimit -f) or use another file system"};
    case EMFILE:
    case ENFILE:
      return {ErrorCode::kExhausted, "raise the limit on open files (ulimit -n)"};
    case ENOMEM:
      return {ErrorCode::kExhausted,
              "raise the limit on memory (ulimit -v) or on mappings (vm.max_map_count)"};
    case ENOENT:
      return {ErrorCode::kNotFound, "check the path"};
    case ENOTDIR:
      return {ErrorCode::kNotFound, "a part of the path is a file, not a folder"};
    case EACCES:
    case EPERM:
      return {ErrorCode::kInternal, "check owner and permissions"};
    case EROFS:
      return {ErrorCode::kInternal, "the file system is read-only: choose another folder"};
    case EISDIR:
      return {ErrorCode::kInternal, "it is a folder, a file is needed"};
    case EIO:
      return {ErrorCode::kCorrupt, "the device reports an error: check the disk (dmesg)"};
    default:
      return {ErrorCode::kInternal, "see the system's message"};
  }
}

}  // namespace

Error IoError(std::string_view operation, const std::filesystem::path& path, int error_number) {
  const Remedy remedy = RemedyFor(error_number);
  return Error{remedy.code, fmt::format("cannot {} {}: {}; {}", operation, path.string(),
                                        std::generic_category().message(error_number), remedy.text)};
}

}  // namespace dadrl
