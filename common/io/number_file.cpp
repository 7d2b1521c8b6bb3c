#include "common/io/number_file.h"

#include <fcntl.h>

#include <charconv>
#include <span>
#include <string>
#include <string_view>

#include "common/io/atomic_file.h"
#include "common/io/file_descriptor.h"
#include "common/io/read_file.h"

namespace dadrl {
namespace {

constexpr uint64_t kMaxBytes = 64;

}  // namespace

Result<uint64_t> ReadNumber(const std::filesystem::path& path) {
  DADRL_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(path, kMaxBytes));
  uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || std::string_view(stop, end) != "\n") {
    return Fail(ErrorCode::kCorrupt, "{} does not hold a number", path.string());
  }
  return number;
}

Status WriteNumber(const std::filesystem::path& path, uint64_t number) {
  const std::string text = fmt::format("{:020}\n", number);
  Status written = WriteFileAtomically(path, std::string_view(text));
  if (written || written.error().code != ErrorCode::kExhausted) return written;
  const auto file = FileDescriptor::Open(path, O_WRONLY);
  if (!file || !WriteAll(*file, std::as_bytes(std::span(text)), path)) return written;
  return SyncFile(*file, path);
}

}  // namespace dadrl
