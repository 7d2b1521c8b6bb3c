#include "proto/sample_batch.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/util/prefetch.h"

namespace dadrl {
namespace {

constexpr uint32_t kBatchMagic = 0x42584441;  // "ADXB"
constexpr uint32_t kBatchVersion = 1;
constexpr size_t kHeaderBytes = 24;
constexpr size_t kEntryBytes = 40;
constexpr size_t kChecksumBytes = 8;
constexpr size_t kAhead = 16;  // items whose payloads are asked for before they are copied

struct Entry {
  uint64_t key = 0;
  float importance_weight = 0.0f;
  uint32_t policy_version = 0;
  Action action{};
  int steps = 0;
  bool terminated = false;
  uint32_t first_bytes = 0;
  uint32_t next_bytes = 0;
};

// As it is on the wire: there are no gaps.
struct WireEntry {
  uint64_t key;
  float probability;
  float importance_weight;
  uint32_t policy_version;
  Action action;
  uint16_t steps;
  uint16_t terminated;
  uint32_t first_bytes;
  uint32_t next_bytes;
};
static_assert(sizeof(WireEntry) == kEntryBytes);

WireEntry EntryOf(const SampledItem& item) {
  return {.key = item.key,
          .probability = item.probability,
          .importance_weight = item.importance_weight,
          .policy_version = item.policy_version,
          .action = item.action,
          .steps = static_cast<uint16_t>(item.rewards.size()),
          .terminated = static_cast<uint16_t>(item.terminated),
          .first_bytes = static_cast<uint32_t>(item.first.size()),
          .next_bytes = static_cast<uint32_t>(item.next.size())};
}

// As SetImportance and the selectors of the replay make them.
bool IsShare(float value) { return value >= 0.0f && value <= 1.0f; }

Result<Entry> GetEntry(ByteReader& reader) {
  Entry entry;
  entry.key = reader.Get<uint64_t>();
  const auto probability = reader.Get<float>();
  entry.importance_weight = reader.Get<float>();
  entry.policy_version = reader.Get<uint32_t>();
  for (float& a : entry.action) a = reader.Get<float>();
  entry.steps = reader.Get<uint16_t>();
  const auto terminated = reader.Get<uint16_t>();
  entry.terminated = terminated == 1;
  entry.first_bytes = reader.Get<uint32_t>();
  entry.next_bytes = reader.Get<uint32_t>();
  const bool numbers =
      IsShare(probability) && IsShare(entry.importance_weight) && IsPossibleAction(entry.action);
  if (!reader.ok() || !numbers || entry.steps < 1 || entry.steps > kMaxSliceSteps || terminated > 1 ||
      entry.terminated != (entry.next_bytes == 0)) {
    return Fail(ErrorCode::kCorrupt, "sample batch: item {:#x} of {} steps is malformed", entry.key,
                entry.steps);
  }
  return entry;
}

// Decodes one observation into row `index` of `batch`; an empty payload is all zero.
Status DecodeRow(std::span<const std::byte> payload, FrameCodec& codec, size_t index,
                 ObservationBatch& batch) {
  const auto row = [&](auto& values) {
    const size_t length = values.size() / static_cast<size_t>(batch.size);
    return std::span(values).subspan(index * length, length);
  };
  const auto vehicles = row(batch.vehicles);
  const auto ego = row(batch.ego);
  const auto context = row(batch.context);
  if (!payload.empty()) return DecodeWithinBounds(codec, payload, vehicles, ego, context);
  std::fill(vehicles.begin(), vehicles.end(), 0.0f);
  std::fill(ego.begin(), ego.end(), 0.0f);
  std::fill(context.begin(), context.end(), uint8_t{0});
  return {};
}

// The checked body of the message: entries, rewards and payloads.
Result<std::span<const std::byte>> CheckEnvelope(std::span<const std::byte> bytes, uint64_t schema,
                                                 int size) {
  if (bytes.size() < kHeaderBytes + kChecksumBytes) {
    return Fail(ErrorCode::kCorrupt, "sample batch of {} bytes is too short", bytes.size());
  }
  const auto content = bytes.first(bytes.size() - kChecksumBytes);
  ByteReader reader(bytes);
  if (reader.Get<uint32_t>() != kBatchMagic || reader.Get<uint32_t>() != kBatchVersion) {
    return Fail(ErrorCode::kCorrupt, "sample batch has no magic number of version {}", kBatchVersion);
  }
  const auto batch_schema = reader.Get<uint64_t>();
  const auto count = reader.Get<uint32_t>();
  const auto total = reader.Get<uint32_t>();
  if (total != bytes.size()) {
    return Fail(ErrorCode::kCorrupt, "sample batch of {} bytes, its header says {}", bytes.size(), total);
  }
  if (ByteReader(bytes.last(kChecksumBytes)).Get<uint64_t>() != Xxh3(content)) {
    return Fail(ErrorCode::kCorrupt, "sample batch fails its checksum");
  }
  if (batch_schema != schema) {
    return Fail(ErrorCode::kCorrupt, "sample batch has schema {:#x}, this process has {:#x}", batch_schema,
                schema);
  }
  if (count != static_cast<uint32_t>(size)) {
    return Fail(ErrorCode::kCorrupt, "sample batch of {} items, asked for {}", count, size);
  }
  return content.subspan(kHeaderBytes);
}

}  // namespace

size_t SampleBatchBytes(std::span<const SampledItem> items) {
  size_t total = kHeaderBytes + items.size() * kEntryBytes + kChecksumBytes;
  for (const SampledItem& item : items) {
    assert(!item.rewards.empty() && item.rewards.size() <= kMaxSliceSteps);
    total += item.rewards.size_bytes() + item.first.size() + item.next.size();
  }
  return total;
}

std::vector<std::byte> EncodeSampleBatch(std::span<const SampledItem> items, uint64_t schema,
                                         std::vector<std::byte> memory) {
  const size_t total = SampleBatchBytes(items);
  std::vector<std::byte> bytes = std::move(memory);
  bytes.resize(total);
  // Not a ByteWriter: the length is known, and these are the replay's most copied bytes.
  std::byte* at = bytes.data();
  const auto put = [&at](std::span<const std::byte> from) { at = std::copy(from.begin(), from.end(), at); };
  const auto put_value = [&put](const auto& value) { put(std::as_bytes(std::span(&value, 1))); };
  put_value(kBatchMagic);
  put_value(kBatchVersion);
  put_value(schema);
  put_value(static_cast<uint32_t>(items.size()));
  put_value(static_cast<uint32_t>(total));
  for (const SampledItem& item : items) put_value(EntryOf(item));
  for (const SampledItem& item : items) put(std::as_bytes(item.rewards));
  // The payloads lie anywhere: while one is copied, those behind it are on their way.
  const auto fetch = [](const SampledItem& item) {
    Prefetch(item.first.data(), item.first.size());
    Prefetch(item.next.data(), item.next.size());
  };
  std::for_each_n(items.begin(), std::min(kAhead, items.size()), fetch);
  for (size_t i = 0; i < items.size(); ++i) {
    if (i + kAhead < items.size()) fetch(items[i + kAhead]);
    put(items[i].first);
    put(items[i].next);
  }
  put_value(Xxh3(std::span(bytes).first(total - kChecksumBytes)));
  return bytes;
}

Status DecodeSampleBatch(std::span<const std::byte> bytes, uint64_t schema, double gamma,
                         const ExperienceBounds& bounds, FrameCodec& codec, TransitionBatch& batch) {
  DADRL_ASSIGN_OR_RETURN(const auto body, CheckEnvelope(bytes, schema, batch.size));
  const auto count = static_cast<size_t>(batch.size);
  ByteReader entries(body);
  std::vector<Entry> items(count);
  size_t steps = 0;
  for (Entry& item : items) {
    DADRL_ASSIGN_OR_RETURN(item, GetEntry(entries));
    steps += static_cast<size_t>(item.steps);
  }
  ByteReader rewards(body.subspan(count * kEntryBytes));
  ByteReader payloads = rewards;
  payloads.GetBytes(steps * sizeof(float));
  for (size_t i = 0; i < count; ++i) {
    const Entry& item = items[i];
    double sum = 0.0;
    double factor = 1.0;
    bool possible = true;
    for (int step = 0; step < item.steps; ++step, factor *= gamma) {
      const auto reward = rewards.Get<float>();
      possible = possible && bounds.AllowsReward(reward);
      sum += factor * static_cast<double>(reward);
    }
    const auto first = payloads.GetBytes(item.first_bytes);
    const auto next = payloads.GetBytes(item.next_bytes);
    if (!payloads.ok() || first.empty()) {
      return Fail(ErrorCode::kCorrupt, "sample batch: item {:#x} does not fit into it", item.key);
    }
    if (!possible) {
      return Fail(ErrorCode::kCorrupt, "sample batch: item {:#x} has a reward beyond {:.4g}", item.key,
                  bounds.reward);
    }
    DADRL_RETURN_IF_ERROR(DecodeRow(first, codec, i, batch.observation));
    DADRL_RETURN_IF_ERROR(DecodeRow(next, codec, i, batch.next_observation));
    for (size_t a = 0; a < kActionSize; ++a) batch.action[i * kActionSize + a] = item.action[a];
    batch.reward[i] = static_cast<float>(sum);
    batch.discount[i] = item.terminated ? 0.0f : static_cast<float>(factor);
    batch.weight[i] = item.importance_weight;
    batch.key[i] = item.key;
    batch.policy_version[i] = item.policy_version;
  }
  if (payloads.remaining() != 0) {
    return Fail(ErrorCode::kCorrupt, "sample batch has {} bytes too many", payloads.remaining());
  }
  return {};
}

}  // namespace dadrl
