#include "proto/sequence_batch.h"

#include <algorithm>
#include <cassert>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"

namespace dadrl {
namespace {

constexpr uint32_t kSequenceMagic = 0x51584441;  // "ADXQ"
constexpr uint32_t kSequenceVersion = 1;
constexpr size_t kHeaderBytes = 24;
constexpr size_t kEntryBytes = 20;
constexpr size_t kStepBytes = 8 + sizeof(Action);
constexpr size_t kChecksumBytes = 8;
constexpr uint16_t kEndsTerminated = 1;
constexpr uint16_t kEndsTruncated = 2;

struct Entry {
  int steps = 0;
  uint16_t ends = 0;
  int frames() const { return steps + ((ends & kEndsTerminated) != 0 ? 0 : 1); }
};

Result<ByteReader> CheckEnvelope(std::span<const std::byte> bytes, uint64_t schema,
                                 const SequenceBatch& batch) {
  if (bytes.size() < kChecksumBytes || ByteReader(bytes.last(kChecksumBytes)).Get<uint64_t>() !=
                                           Xxh3(bytes.first(bytes.size() - kChecksumBytes))) {
    return Fail(ErrorCode::kCorrupt, "sequence batch of {} bytes fails its checksum", bytes.size());
  }
  ByteReader reader(bytes.first(bytes.size() - kChecksumBytes));
  const bool ours = reader.Get<uint32_t>() == kSequenceMagic && reader.Get<uint32_t>() == kSequenceVersion;
  const auto batch_schema = reader.Get<uint64_t>();
  const auto count = reader.Get<uint32_t>();
  const auto length = reader.Get<uint32_t>();
  if (!reader.ok() || !ours) {
    return Fail(ErrorCode::kCorrupt, "sequence batch has no magic number of version {}", kSequenceVersion);
  }
  if (batch_schema != schema || count != static_cast<uint32_t>(batch.size) ||
      length != static_cast<uint32_t>(batch.length)) {
    return Fail(ErrorCode::kCorrupt,
                "sequence batch of {} sequences of {} steps and schema {:#x}; asked for {} of {} and {:#x}",
                count, length, batch_schema, batch.size, batch.length, schema);
  }
  return reader;
}

Result<Entry> GetEntry(ByteReader& reader, size_t index, SequenceBatch& batch) {
  Entry entry;
  batch.key[index] = reader.Get<uint64_t>();
  const auto probability = reader.Get<float>();
  const auto weight = reader.Get<float>();
  entry.steps = reader.Get<uint16_t>();
  entry.ends = reader.Get<uint16_t>();
  const bool fits = entry.steps >= 1 && entry.steps <= batch.length && entry.ends <= kEndsTruncated &&
                    (entry.steps == batch.length || entry.ends != 0);
  const bool shares = probability >= 0.0f && probability <= 1.0f && weight >= 0.0f && weight <= 1.0f;
  if (!reader.ok() || !fits || !shares) {
    return Fail(ErrorCode::kCorrupt, "sequence batch: sequence {:#x} of {} steps is malformed",
                batch.key[index], entry.steps);
  }
  batch.weight[index] = weight;
  batch.steps[index] = entry.steps;
  batch.terminated[index] = entry.ends == kEndsTerminated;
  batch.truncated[index] = entry.ends == kEndsTruncated;
  return entry;
}

// False when a number is missing or impossible.
bool GetSteps(ByteReader& reader, size_t index, int steps, const ExperienceBounds& bounds,
              SequenceBatch& batch) {
  const auto first = index * static_cast<size_t>(batch.length);
  bool possible = true;
  for (size_t at = first; at < first + static_cast<size_t>(steps); ++at) {
    batch.policy_version[at] = reader.Get<uint32_t>();
    Action action{};
    for (float& a : action) a = reader.Get<float>();
    std::ranges::copy(action, &batch.action[at * kActionSize]);
    batch.reward[at] = reader.Get<float>();
    possible = possible && IsPossibleAction(action) && bounds.AllowsReward(batch.reward[at]);
  }
  return possible && reader.ok();
}

void Clear(SequenceBatch& batch) {
  for (auto* values : {&batch.observation.vehicles, &batch.observation.ego, &batch.action, &batch.reward}) {
    std::fill(values->begin(), values->end(), 0.0f);
  }
  std::fill(batch.observation.context.begin(), batch.observation.context.end(), uint8_t{0});
  std::fill(batch.policy_version.begin(), batch.policy_version.end(), 0u);
}

Status DecodeRow(std::span<const std::byte> payload, FrameCodec& codec, size_t row, ObservationBatch& batch) {
  const auto part = [&](auto& values) {
    const size_t length = values.size() / static_cast<size_t>(batch.size);
    return std::span(values).subspan(row * length, length);
  };
  return DecodeWithinBounds(codec, payload, part(batch.vehicles), part(batch.ego), part(batch.context));
}

}  // namespace

size_t SequenceBatchBytes(std::span<const SampledSequence> sequences) {
  size_t total = kHeaderBytes + sequences.size() * kEntryBytes + kChecksumBytes;
  for (const SampledSequence& sequence : sequences) {
    total += sequence.steps.size() * kStepBytes;
    for (const auto& frame : sequence.frames) total += sizeof(uint32_t) + frame.size();
  }
  return total;
}

std::vector<std::byte> EncodeSequenceBatch(std::span<const SampledSequence> sequences, int length,
                                           uint64_t schema) {
  std::vector<std::byte> bytes;
  bytes.reserve(SequenceBatchBytes(sequences));
  ByteWriter writer(bytes);
  writer.Put(kSequenceMagic);
  writer.Put(kSequenceVersion);
  writer.Put(schema);
  writer.Put(static_cast<uint32_t>(sequences.size()));
  writer.Put(static_cast<uint32_t>(length));
  for (const SampledSequence& sequence : sequences) {
    assert(!sequence.steps.empty() && sequence.steps.size() <= static_cast<size_t>(length));
    assert(sequence.frames.size() == sequence.steps.size() + (sequence.terminated ? 0 : 1));
    writer.Put(sequence.key);
    writer.Put(sequence.probability);
    writer.Put(sequence.importance_weight);
    writer.Put(static_cast<uint16_t>(sequence.steps.size()));
    writer.Put(sequence.terminated ? kEndsTerminated : sequence.truncated ? kEndsTruncated : uint16_t{0});
  }
  for (const SampledSequence& sequence : sequences) {
    for (const SequenceStep& step : sequence.steps) {
      writer.Put(step.policy_version);
      for (const float a : step.action) writer.Put(a);
      writer.Put(step.reward);
    }
  }
  for (const SampledSequence& sequence : sequences) {
    for (const auto& frame : sequence.frames) writer.Put(static_cast<uint32_t>(frame.size()));
  }
  for (const SampledSequence& sequence : sequences) {
    for (const auto& frame : sequence.frames) writer.PutBytes(frame);
  }
  writer.Put(Xxh3(bytes));
  return bytes;
}

Status DecodeSequenceBatch(std::span<const std::byte> bytes, uint64_t schema, const ExperienceBounds& bounds,
                           FrameCodec& codec, SequenceBatch& batch) {
  DADRL_ASSIGN_OR_RETURN(ByteReader reader, CheckEnvelope(bytes, schema, batch));
  Clear(batch);
  std::vector<Entry> entries(static_cast<size_t>(batch.size));
  uint64_t frames = 0;
  for (size_t i = 0; i < entries.size(); ++i) {
    DADRL_ASSIGN_OR_RETURN(entries[i], GetEntry(reader, i, batch));
    frames += static_cast<uint64_t>(entries[i].frames());
  }
  for (size_t i = 0; i < entries.size(); ++i) {
    if (GetSteps(reader, i, entries[i].steps, bounds, batch)) continue;
    return Fail(ErrorCode::kCorrupt,
                "sequence batch: sequence {:#x} does not fit into it, or has an action outside [-1, 1] or a "
                "reward beyond {:.4g}",
                batch.key[i], bounds.reward);
  }
  ByteReader lengths(reader.GetBytes(frames * sizeof(uint32_t)));
  for (size_t i = 0; i < entries.size(); ++i) {
    for (int frame = 0; frame < entries[i].frames(); ++frame) {
      const auto payload = reader.GetBytes(lengths.Get<uint32_t>());
      if (!reader.ok() || !lengths.ok() || payload.empty()) {
        return Fail(ErrorCode::kCorrupt, "sequence batch: sequence {:#x} does not fit into it", batch.key[i]);
      }
      const size_t row = i * static_cast<size_t>(batch.length + 1) + static_cast<size_t>(frame);
      DADRL_RETURN_IF_ERROR(DecodeRow(payload, codec, row, batch.observation));
    }
  }
  if (reader.remaining() != 0) {
    return Fail(ErrorCode::kCorrupt, "sequence batch has {} bytes too many", reader.remaining());
  }
  return {};
}

}  // namespace dadrl
