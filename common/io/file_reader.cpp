#include "common/io/file_reader.h"

#include <algorithm>

namespace dadrl {

Result<FileReader> FileReader::Open(const std::filesystem::path& path, uint64_t max_bytes, Links links) {
  DADRL_ASSIGN_OR_RETURN(BoundedFile file, OpenBounded(path, max_bytes, links));
  return FileReader(std::move(file), path);
}

Result<uint32_t> FileReader::GetHead(const FileKind& kind) {
  const std::vector<char> magic = GetVector<char>(kind.magic.size());
  const auto format = Get<uint32_t>();
  if (!ok() || !std::ranges::equal(magic, kind.magic)) {
    return Fail(ErrorCode::kCorrupt, "{} is not {}: {}", path_.string(), kind.name, kind.remedy);
  }
  if (format >= kind.oldest && format <= kind.format) return format;
  const std::string read = kind.oldest == kind.format
                               ? fmt::format("format {}", kind.format)
                               : fmt::format("formats {} to {}", kind.oldest, kind.format);
  return Fail(ErrorCode::kInvalidArgument,
              "{} is {} of format {}, this program reads {}: use the program that wrote it", path_.string(),
              kind.name, format, read);
}

size_t FileReader::Fitting(uint64_t count, size_t size) {
  if (count > left_ / size) ok_ = false;
  return ok_ ? count : 0;
}

void FileReader::Read(std::span<std::byte> bytes) {
  if (bytes.size() > left_) ok_ = false;
  if (ok_) {
    left_ -= bytes.size();
    const Result<size_t> read = ReadUpTo(file_.descriptor, bytes, path_);
    if (!read) disk_ = tl::unexpected<Error>(read.error());
    ok_ = read == bytes.size();  // it may have shrunk meanwhile
  }
  if (!ok_) std::ranges::fill(bytes, std::byte{0});
  hash_.Add(bytes);
}

Status FileReader::CheckEnd(std::string_view remedy) {
  const bool fits = ok_ && left_ == sizeof(uint64_t);
  const uint64_t computed = hash_.Digest();
  const auto stored = Get<uint64_t>();
  DADRL_RETURN_IF_ERROR(disk_);
  if (fits && ok_ && stored == computed) return {};
  return Fail(ErrorCode::kCorrupt, "{} is damaged ({}): {}", path_.string(), fits ? "checksum" : "lengths",
              remedy);
}

}  // namespace dadrl
