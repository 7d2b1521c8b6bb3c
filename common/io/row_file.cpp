#include "common/io/row_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <system_error>
#include <utility>

#include "common/io/io_error.h"

namespace dadrl {
namespace {

constexpr off_t kBlock = 4096;
constexpr off_t kLongestRow = 1 << 20;

// The bytes from `begin` to `end`, fewer where they cannot be read.
std::string ReadRange(const FileDescriptor& file, off_t begin, off_t end) {
  std::string text(static_cast<size_t>(end - begin), '\0');
  const ssize_t bytes = pread(file.get(), text.data(), text.size(), begin);
  text.resize(bytes > 0 ? static_cast<size_t>(bytes) : 0);
  return text;
}

// Behind the last line break before `end`; 0 without one.
off_t LineStart(const FileDescriptor& file, off_t end) {
  while (end > 0) {
    const off_t begin = std::max<off_t>(0, end - kBlock);
    const size_t found = ReadRange(file, begin, end).rfind('\n');
    if (found != std::string::npos) return begin + static_cast<off_t>(found) + 1;
    end = begin;
  }
  return 0;
}

off_t SizeOf(const FileDescriptor& file) {
  struct stat info {};
  return fstat(file.get(), &info) == 0 ? info.st_size : 0;
}

Result<FileDescriptor> OpenTable(const std::filesystem::path& path) {
  return FileDescriptor::Open(path, O_RDWR | O_CREAT | O_APPEND);
}

// Makes room for a table with this header where another one is.
Status MoveAway(const std::filesystem::path& path) {
  std::filesystem::path old = path;
  old += ".old";
  std::error_code failed;
  std::filesystem::rename(path, old, failed);
  if (!failed) return {};
  return Fail(ErrorCode::kInternal, "cannot rename {} to {}: {}; move it away", path.string(), old.string(),
              failed.message());
}

}  // namespace

Result<RowFile> RowFile::Open(const std::filesystem::path& path, std::string_view header) {
  std::error_code failed;
  std::filesystem::create_directories(path.parent_path(), failed);
  if (failed) {
    return Fail(ErrorCode::kInternal, "cannot create {}: {}; choose another run directory",
                path.parent_path().string(), failed.message());
  }
  const std::string first_line = fmt::format("{}\n", header);
  const auto header_end = static_cast<off_t>(first_line.size());
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, OpenTable(path));
  if (LineStart(file, SizeOf(file)) > 0 && ReadRange(file, 0, header_end) != first_line) {
    DADRL_RETURN_IF_ERROR(MoveAway(path));
    DADRL_ASSIGN_OR_RETURN(file, OpenTable(path));
  }
  const off_t whole = LineStart(file, SizeOf(file));
  if (whole != SizeOf(file) && ftruncate(file.get(), whole) != 0) {
    return tl::unexpected<Error>(IoError("cut", path, errno));
  }
  RowFile table(path, std::move(file), "");
  if (whole == 0) {
    DADRL_RETURN_IF_ERROR(table.Append(first_line));
  } else if (whole > header_end) {
    const off_t last = std::max(LineStart(table.file_, whole - 1), whole - kLongestRow);
    table.last_row_ = ReadRange(table.file_, last, whole - 1);
  }
  return table;
}

Status RowFile::Append(std::string_view rows) {
  return AppendWhole(file_, std::as_bytes(std::span(rows)), path_);
}

}  // namespace dadrl
