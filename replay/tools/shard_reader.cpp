#include "replay/tools/shard_reader.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "common/io/link_file.h"
#include "replay/storage/columns_file.h"
#include "replay/storage/segment_format.h"
#include "replay/storage/segment_log.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> SubFoldersOfShards(const fs::path& directory) {
  std::vector<fs::path> shards;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("shard-") && entry.is_directory(error)) shards.push_back(entry.path());
  }
  std::sort(shards.begin(), shards.end());
  return shards;
}

}  // namespace

Result<ShardReader> ShardReader::Open(const fs::path& named) {
  const fs::path directory = FollowLinks(named);
  std::error_code error;
  if (!fs::is_directory(directory, error)) {
    return Fail(ErrorCode::kNotFound, "{} is no folder", directory.string());
  }
  ShardReader reader;
  reader.shards_ = SubFoldersOfShards(directory);
  if (reader.shards_.empty()) reader.shards_ = SubFoldersOfShards(directory / "replay");
  if (reader.shards_.empty()) reader.shards_ = {directory};
  for (const fs::path& shard : reader.shards_) DADRL_RETURN_IF_ERROR(reader.AddShard(shard));
  if (reader.segments_.empty()) {
    return Fail(
        ErrorCode::kNotFound,
        "{} holds no stored experience; name a run directory, its replay folder, a shard-K or a snapshot",
        directory.string());
  }
  DADRL_RETURN_IF_ERROR(reader.FindSchema());
  return reader;
}

Status ShardReader::AddShard(const fs::path& directory) {
  const size_t before = segments_.size();
  std::error_code error;
  for (fs::directory_iterator it(directory, error), end; !error && it != end; it.increment(error)) {
    const auto id = SegmentLog::IdOf(it->path());
    if (!id) continue;
    auto file = MappedFile::Open(it->path());
    if (!file && file.error().code == ErrorCode::kNotFound) continue;  // dropped by a running replay
    if (!file && file.error().code == ErrorCode::kInvalidArgument) {
      refused_.push_back({.file = it->path(), .what = file.error().message});
      continue;
    }
    if (!file) return tl::unexpected<Error>(std::move(file.error()));
    if (file->bytes().size() > kMaxSegmentBytes) {
      refused_.push_back({it->path(), 0, file->bytes().size(), "is longer than any segment"});
      continue;
    }
    segments_.push_back({it->path(), *id, std::move(*file), false});
  }
  if (error) return Fail(ErrorCode::kNotFound, "list {}: {}", directory.string(), error.message());
  std::sort(segments_.begin() + static_cast<ptrdiff_t>(before), segments_.end(),
            [](const SegmentFile& a, const SegmentFile& b) { return a.id < b.id; });
  if (segments_.size() > before) segments_.back().newest = true;
  return {};
}

Status ShardReader::FindSchema() {
  const SegmentFile* first = nullptr;
  for (const SegmentFile& segment : segments_) {
    const SegmentHeader header = ParseSegmentHeader(segment.file.bytes());
    if (!header.whole) continue;
    if (header.version != kSegmentVersion) {
      return Fail(ErrorCode::kCorrupt, "{} has format {}, this build reads {}", segment.path.string(),
                  header.version, kSegmentVersion);
    }
    if (first != nullptr && header.schema != schema_) {
      return Fail(ErrorCode::kCorrupt, "{} and {} hold different steps", first->path.string(),
                  segment.path.string());
    }
    first = &segment;
    schema_ = header.schema;
  }
  if (first == nullptr) {
    return Fail(ErrorCode::kCorrupt, "{}: no segment says what its steps hold",
                segments_.front().path.parent_path().string());
  }
  DADRL_ASSIGN_OR_RETURN(spec_, ReadColumns(first->path.parent_path(), schema_));
  return {};
}

void ShardReader::ForEachChunk(
    const std::function<bool(const fs::path& file, uint64_t offset, const ChunkView& chunk)>& visit,
    const std::function<void(const Damage&)>& on_damage) const {
  for (const Damage& refused : refused_) on_damage(refused);
  bool more = true;
  for (const SegmentFile& segment : segments_) {
    if (!more) return;
    const auto damage = [&](uint64_t offset, uint64_t bytes, std::string what) {
      on_damage({segment.path, offset, bytes, std::move(what)});
    };
    if (segment.file.bytes().size() >= kSegmentHeader && !ParseSegmentHeader(segment.file.bytes()).whole) {
      damage(0, kSegmentHeader, "the file's header fails its checksum (its records prove themselves)");
    }
    ScanRecords(segment.file.bytes(), segment.id,
                {.on_record =
                     [&](uint64_t offset, std::span<const std::byte> content) {
                       if (!more) return;
                       const Result<ChunkView> chunk = ChunkView::Parse(content);
                       if (!chunk) return damage(offset, content.size(), chunk.error().message);
                       if (chunk->header().schema != schema_) {
                         return damage(offset, content.size(), "a chunk of another schema");
                       }
                       more = visit(segment.path, offset, *chunk);
                     },
                 .on_damage =
                     [&](uint64_t offset, uint64_t bytes) {
                       // A running replay was writing it when the file was opened.
                       std::error_code error;
                       const uint64_t size = segment.file.bytes().size();
                       const bool grows = segment.newest && offset + bytes == size &&
                                          fs::file_size(segment.path, error) > size;
                       if (!grows) damage(offset, bytes, "belongs to no whole record");
                     }});
  }
}

uint64_t ShardReader::BytesOf(const fs::path& shard) const {
  uint64_t sum = 0;
  for (const SegmentFile& segment : segments_) {
    if (segment.path.parent_path() == shard) sum += segment.file.bytes().size();
  }
  return sum;
}

uint64_t ShardReader::bytes() const {
  uint64_t sum = 0;
  for (const SegmentFile& segment : segments_) sum += segment.file.bytes().size();
  return sum;
}

}  // namespace dadrl
