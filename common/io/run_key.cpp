#include "common/io/run_key.h"

#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <span>
#include <system_error>

#include "common/io/file_descriptor.h"
#include "common/io/io_error.h"

namespace dadrl {
namespace {

constexpr size_t kDigits = 32;

Result<std::string> RandomKey() {
  std::array<uint8_t, kDigits / 2> bits{};
  if (getrandom(bits.data(), bits.size(), 0) != static_cast<ssize_t>(bits.size())) {
    return Fail(ErrorCode::kInternal, "cannot draw the run's key: {}", std::strerror(errno));
  }
  return fmt::format("{:02x}", fmt::join(bits, ""));
}

}  // namespace

std::filesystem::path RunKeyFile(const std::filesystem::path& run_directory) { return run_directory / "key"; }

Result<std::string> ReadRunKey(const std::filesystem::path& file) {
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor opened, FileDescriptor::Open(file, O_RDONLY));
  std::string key(kDigits + 2, '\0');
  const ssize_t size = read(opened.get(), key.data(), key.size());
  key.resize(static_cast<size_t>(std::max<ssize_t>(size, 0)));
  if (key.ends_with('\n')) key.pop_back();
  const bool hex = std::all_of(key.begin(), key.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
  if (hex && key.size() == kDigits) return key;
  return Fail(ErrorCode::kCorrupt, "{} holds no key of a run ({} hexadecimal digits)", file.string(),
              kDigits);
}

Result<std::string> EnsureRunKey(const std::filesystem::path& run_directory) {
  auto kept = ReadRunKey(RunKeyFile(run_directory));
  if (kept || kept.error().code != ErrorCode::kNotFound) return kept;
  DADRL_ASSIGN_OR_RETURN(const std::string key, RandomKey());
  DADRL_RETURN_IF_ERROR(SaveRunKey(run_directory, key));
  return key;
}

Status SaveRunKey(const std::filesystem::path& run_directory, const std::string& key) {
  const std::filesystem::path file = RunKeyFile(run_directory);
  const std::filesystem::path beside = file.string() + ".new";
  std::error_code error;
  std::filesystem::remove(beside, error);  // of a launcher that was killed
  const FileDescriptor created(open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (!created.valid()) return tl::unexpected<Error>(IoError("create", beside, errno));
  const std::string line = key + "\n";
  DADRL_RETURN_IF_ERROR(WriteAll(created, std::as_bytes(std::span(line)), beside));
  DADRL_RETURN_IF_ERROR(SyncFile(created, beside));
  std::filesystem::rename(beside, file, error);
  if (error) return Fail(ErrorCode::kInternal, "cannot write {}: {}", file.string(), error.message());
  return {};
}

}  // namespace dadrl
