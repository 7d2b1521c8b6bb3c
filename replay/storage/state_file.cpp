#include "replay/storage/state_file.h"

#include <vector>

#include "common/io/atomic_file.h"
#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/read_file.h"

namespace dadrl {
namespace {

constexpr uint32_t kStateMagic = 0x53584441;  // "ADXS"
constexpr uint32_t kStateVersion = 2;
constexpr uint64_t kMaxStateBytes = uint64_t{2} << 30;

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

}  // namespace

Status WriteReplayState(const std::filesystem::path& file, const ReplayState& state) {
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
  writer.Put(static_cast<uint32_t>(state.limiter_change.has_value()));
  if (state.limiter_change) {
    PutOptions(state.limiter_change->configured, writer);
    PutOptions(state.limiter_change->current, writer);
  }
  state.sequences.Put(writer);
  state.items.Put(writer);
  writer.Put(Xxh3(bytes));
  return WriteFileAtomically(file, bytes);
}

Result<ReplayState> ReadReplayState(const std::filesystem::path& file) {
  DADRL_ASSIGN_OR_RETURN(const std::vector<std::byte> bytes, ReadFile(file, kMaxStateBytes));
  const std::span<const std::byte> all(bytes);
  const size_t content = all.size() < 8 ? 0 : all.size() - 8;
  if (ByteReader(all.subspan(content)).Get<uint64_t>() != Xxh3(all.first(content))) {
    return Fail(ErrorCode::kCorrupt, "{} fails its checksum", file.string());
  }
  ByteReader reader(all.first(content));
  const auto magic = reader.Get<uint32_t>();
  const auto version = reader.Get<uint32_t>();
  const auto alien =
      Fail(ErrorCode::kCorrupt, "{} is not a replay state of format {}", file.string(), kStateVersion);
  if (magic != kStateMagic || version != kStateVersion) return alien;
  ReplayState state;
  state.schema = reader.Get<uint64_t>();
  state.up_to.segment = reader.Get<uint64_t>();
  state.up_to.offset = reader.Get<uint64_t>();
  state.limiter.inserted = reader.Get<int64_t>();
  state.limiter.sampled = reader.Get<int64_t>();
  state.limiter.sample_credit = reader.Get<double>();
  state.limiter.insert_debt = reader.Get<double>();
  if (reader.Get<uint32_t>() != 0) {
    ReplayState::LimiterChange& change = state.limiter_change.emplace();
    change.configured = GetOptions(reader);
    change.current = GetOptions(reader);
  }
  state.sequences = SequenceTable::Get(reader);
  state.items = ItemStates::Get(reader);
  if (!reader.ok() || reader.remaining() != 0) return alien;
  return state;
}

}  // namespace dadrl
