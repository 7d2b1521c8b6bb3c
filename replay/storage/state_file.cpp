#include "replay/storage/state_file.h"

#include <algorithm>
#include <utility>

#include "common/io/atomic_file.h"
#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/read_file.h"
#include "replay/storage/segment_format.h"

namespace dadrl {
namespace {

constexpr uint32_t kStateMagic = 0x53584441;  // "ADXS"
constexpr uint32_t kStateVersion = 2;
// Read in any case, should segments be missing: the state of some hundred million frames.
constexpr uint64_t kAlwaysRead = uint64_t{2} << 30;
// The sequence table at its largest, and everything of fixed length, rounded up.
constexpr uint64_t kBesideItems =
    SequenceTable::kMaxActors * SequenceTable::kMaxIncarnations * uint64_t{20} + 4096;

void PutOptions(const RateLimiter::Options& options, ByteWriter& writer) {
  writer.Put(options.min_size);
  writer.Put(options.max_samples_per_insert);
  writer.Put(options.min_samples_per_insert);
  writer.Put(options.band);
}

RateLimiter::Options GetOptions(ByteReader& reader) {
  RateLimiter::Options options;
  options.min_size = reader.Get<int64_t>();
  options.max_samples_per_insert = reader.Get<double>();
  options.min_samples_per_insert = reader.Get<double>();
  options.band = reader.Get<double>();
  return options;
}

// What stands between version and checksum; nothing when a number is impossible.
std::optional<ReplayState> GetState(ByteReader& reader) {
  ReplayState state;
  state.schema = reader.Get<uint64_t>();
  state.up_to.segment = reader.Get<uint64_t>();
  state.up_to.offset = reader.Get<uint64_t>();
  state.limiter.inserted = reader.Get<int64_t>();
  state.limiter.sampled = reader.Get<int64_t>();
  state.limiter.sample_credit = reader.Get<double>();
  state.limiter.insert_debt = reader.Get<double>();
  if (state.up_to.segment > kMaxSegmentId || !RateLimiter::IsPossible(state.limiter)) return std::nullopt;
  if (reader.Get<uint32_t>() != 0) {
    ReplayState::LimiterChange& change = state.limiter_change.emplace();
    change.configured = GetOptions(reader);
    change.current = GetOptions(reader);
    if (!RateLimiter::IsPossible(change.current)) return std::nullopt;
  }
  std::optional<SequenceTable> sequences = SequenceTable::Get(reader);
  if (!sequences) return std::nullopt;
  state.sequences = std::move(*sequences);
  std::optional<ItemStates> items = ItemStates::Get(reader);
  if (!items) return std::nullopt;
  state.items = std::move(*items);
  return state;
}

}  // namespace

uint64_t MaxStateBytes(uint64_t segment_bytes) {
  return std::max(kAlwaysRead, kBesideItems + std::min(segment_bytes, UINT64_MAX - kBesideItems));
}

std::vector<std::byte> EncodeReplayState(const ReplayState& state) {
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  writer.Put(kStateMagic);
  writer.Put(kStateVersion);
  writer.Put(state.schema);
  writer.Put(state.up_to.segment);
  writer.Put(state.up_to.offset);
  writer.Put(state.limiter.inserted);
  writer.Put(state.limiter.sampled);
  writer.Put(state.limiter.sample_credit);
  writer.Put(state.limiter.insert_debt);
  writer.Put<uint32_t>(state.limiter_change.has_value());
  if (state.limiter_change) {
    PutOptions(state.limiter_change->configured, writer);
    PutOptions(state.limiter_change->current, writer);
  }
  state.sequences.Put(writer);
  state.items.Put(writer);
  AppendChecksum(bytes);
  return bytes;
}

Result<ReplayState> DecodeReplayState(std::span<const std::byte> bytes, const std::string& name) {
  const auto content = CheckedContent(bytes);
  if (!content) return Fail(ErrorCode::kCorrupt, "{} fails its checksum", name);
  ByteReader reader(*content);
  if (reader.Get<uint32_t>() != kStateMagic || reader.Get<uint32_t>() != kStateVersion) {
    return Fail(ErrorCode::kCorrupt, "{} is not a replay state of format {}", name, kStateVersion);
  }
  std::optional<ReplayState> state = GetState(reader);
  if (!state || !reader.ok() || reader.remaining() != 0) {
    return Fail(ErrorCode::kCorrupt, "{} holds what no replay has written", name);
  }
  return std::move(*state);
}

Status WriteReplayState(const std::filesystem::path& file, const ReplayState& state) {
  return WriteFileAtomically(file, EncodeReplayState(state));
}

Result<ReplayState> ReadReplayState(const std::filesystem::path& file, uint64_t max_bytes) {
  Result<std::vector<std::byte>> bytes = ReadFile(file, max_bytes);
  if (!bytes && bytes.error().code == ErrorCode::kExhausted) bytes.error().code = ErrorCode::kCorrupt;
  if (!bytes) return tl::unexpected(std::move(bytes.error()));
  return DecodeReplayState(*bytes, file.string());
}

}  // namespace dadrl
