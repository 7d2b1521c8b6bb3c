// A shard's folder, or a snapshot of one: what a replay that starts in it makes of it. Input: files, each a
// kind, a number, a length and so many bytes.
#include <sys/stat.h>

#include <cmath>
#include <fstream>
#include <string>

#include "common/io/byte_io.h"
#include "replay/storage/segment_format.h"
#include "replay/table.h"
#include "tests/fuzz/harness.h"
#include "tests/replay/test_chunks.h"

namespace dadrl::fuzz {
namespace {

namespace fs = std::filesystem;

enum Kind : uint8_t { kSegment, kSegmentOfChunks, kState, kLink, kFifo, kFolder, kKinds };

void Write(const fs::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// Whole records, whose contents are chunks with checksums that fit.
Bytes SegmentOf(uint64_t id, std::span<std::byte> chunks) {
  Bytes file = EncodeSegmentHeader(id, SchemaHash(kTestSpec));
  while (chunks.size() >= 2) {
    const size_t length = std::min<size_t>(ByteReader(chunks).Get<uint16_t>(), chunks.size() - 2);
    const std::span<std::byte> chunk = chunks.subspan(2, length);
    MendChecksum(chunk);
    const auto header = EncodeRecordHeader(id, file.size(), chunk);
    file.insert(file.end(), header.begin(), header.end());
    file.insert(file.end(), chunk.begin(), chunk.end());
    file.resize(PaddedRecord(file.size()));
    chunks = chunks.subspan(2 + length);
  }
  return file;
}

void Put(const fs::path& folder, Kind kind, uint64_t number, std::span<std::byte> content) {
  const fs::path segment = folder / SegmentLog::NameOf(1 + number % 4);
  std::error_code taken;  // the first of a name counts
  if (fs::symlink_status(segment, taken).type() != fs::file_type::not_found && kind != kState) return;
  switch (kind) {
    case kSegment:
      return Write(segment, content);
    case kSegmentOfChunks:
      return Write(segment, SegmentOf(1 + number % 4, content));
    case kState:
      MendChecksum(content);
      return Write(folder / "state", content);
    case kLink:
      return fs::create_symlink(folder.parent_path() / "outside", segment, taken);
    case kFifo:
      Require(mkfifo(segment.c_str(), 0600) == 0);
      return;
    default:
      fs::create_directory(segment, taken);
  }
}

void Lay(const fs::path& folder, std::span<std::byte> input) {
  while (input.size() >= 4) {
    const auto kind = static_cast<Kind>(std::to_integer<uint8_t>(input[0]) % kKinds);
    const auto number = std::to_integer<uint64_t>(input[1]);
    const size_t length = std::min<size_t>(ByteReader(input.subspan(2)).Get<uint16_t>(), input.size() - 4);
    Put(folder, kind, number, input.subspan(4, length));
    input = input.subspan(4 + length);
  }
}

TableOptions Options(const fs::path& folder) {
  TableOptions options{.directory = folder, .spec = kTestSpec, .replay = {}, .n_step = 2};
  options.replay.min_size = 1;
  options.replay.samples_per_insert = 0.0;
  options.replay.sampler = SamplerKind::kPrioritized;
  return options;
}

// Goes on as a replay does: samples, takes a new chunk, saves.
void CheckTable(ReplayTable& table) {
  const auto sampled = table.Sample({16, 2}, 0);
  for (size_t i = 0; sampled && i < sampled->trajectories.size(); ++i) {
    for (const SampledStep& step : sampled->trajectories[i].steps) {
      Require(kTestBounds.AllowsReward(step.reward) && step.decision.size() == sizeof(Action));
    }
  }
  Require(table.Insert(Build({.identity = {99, 1, 1}, .end = kTerminated}), 1).has_value());
  Require(table.SaveState().has_value());
}

Bytes Entry(Kind kind, uint8_t number, std::span<const std::byte> content) {
  Bytes bytes{static_cast<std::byte>(kind), static_cast<std::byte>(number)};
  ByteWriter writer(bytes);
  writer.Put(static_cast<uint16_t>(content.size()));
  writer.PutBytes(content);
  return bytes;
}

Bytes Chunks(std::initializer_list<TestChunk> chunks) {
  Bytes bytes;
  ByteWriter writer(bytes);
  for (const TestChunk& chunk : chunks) {
    const Bytes built = Build(chunk);
    writer.Put(static_cast<uint16_t>(built.size()));
    writer.PutBytes(built);
  }
  return bytes;
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

const int kMutants = 4000;

bool Check(std::span<std::byte> input) {
  static const SystemClock clock;
  const MemoryFolder root;
  const fs::path folder = root.path() / "shard";
  fs::create_directory(folder);
  const std::string secret(100, 's');
  Write(root.path() / "outside", std::as_bytes(std::span(secret)));
  Lay(folder, input);
  uint64_t held = 0;
  if (const auto table = ReplayTable::Open(Options(folder), clock)) {
    held = (*table)->stats().frames_held;
    CheckTable(**table);
  }
  std::ifstream outside(root.path() / "outside");
  Require(std::string(std::istreambuf_iterator<char>(outside), {}) == secret);
  return held > 0;
}

Seeds MakeSeeds() {
  const Bytes episode =
      Chunks({{.frames = 3}, {.identity = {1, 1, 2}, .first_frame = 3, .end = kTerminated}});
  const Bytes huge = Chunks({{.end = kTerminated, .last_reward = 1e30f},
                             {.identity = {1, 1, 2}, .end = kTerminated, .last_reward = 3e38f}});
  ReplayState state{.schema = SchemaHash(kTestSpec), .up_to = {2, 100}, .limiter = {10, 20, 1.5, 2.5}};
  state.sequences.Accept({1, 1, 1});
  const Bytes link = Entry(kLink, 1, {});
  return {
      .accepted = {Entry(kSegmentOfChunks, 0, episode) + Entry(kState, 0, EncodeReplayState(state)),
                   Entry(kSegmentOfChunks, 0, episode) + link + Entry(kFifo, 2, {}) + Entry(kFolder, 3, {})},
      .refused = {Entry(kSegmentOfChunks, 0, huge), link, Entry(kFifo, 0, {}), Entry(kFolder, 0, {})}};
}

}  // namespace dadrl::fuzz
