#include "proto/trajectory_codec.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/util/prefetch.h"

namespace dadrl {
namespace {

constexpr uint32_t kMagic = 0x54584441;  // "ADXT"
constexpr uint32_t kVersion = 1;
constexpr size_t kAhead = 16;  // trajectories whose payloads are asked for before they are copied

// As they are on the wire: there are no gaps.
struct WireHeader {
  uint32_t magic;
  uint32_t version;
  uint64_t schema;
  uint32_t trajectories;
  uint32_t steps;
  uint32_t all_observations;
  uint32_t decision_floats;
  uint64_t total;
};
static_assert(sizeof(WireHeader) == 40);

constexpr size_t kEntryBytes = 20;

enum End : uint16_t { kNone, kTerminatedEnd, kTruncatedEnd, kEnds };

constexpr size_t StepBytes(size_t decision_floats) { return sizeof(float) * (2 + decision_floats); }

size_t DecisionBytes(std::span<const SampledTrajectory> trajectories) {
  return trajectories.empty() ? 0 : trajectories.front().steps.front().decision.size();
}

// Writes into memory of the right size: these are the replay's most copied bytes.
class Output {
 public:
  explicit Output(std::byte* at) : at_(at) {}
  template <typename T>
  void Put(const T& value) {
    PutBytes(std::as_bytes(std::span(&value, 1)));
  }
  void PutBytes(std::span<const std::byte> from) { at_ = std::copy(from.begin(), from.end(), at_); }

 private:
  std::byte* at_;
};

void PutEntry(const SampledTrajectory& trajectory, Output& out) {
  out.Put(trajectory.key);
  out.Put(trajectory.probability);
  out.Put(trajectory.importance_weight);
  out.Put<uint16_t>(trajectory.steps.size());
  out.Put(static_cast<uint16_t>(trajectory.terminated  ? kTerminatedEnd
                                : trajectory.truncated ? kTruncatedEnd
                                                       : kNone));
}

void PutStep(const SampledStep& step, Output& out) {
  out.Put(step.policy_version);
  out.Put(step.reward);
  out.PutBytes(step.decision);
}

// The payloads lie anywhere: while one is copied, those behind it are on their way.
void PutPayloads(std::span<const SampledTrajectory> trajectories, Output& out) {
  const auto fetch = [](const SampledTrajectory& trajectory) {
    for (const auto payload : trajectory.payloads) Prefetch(payload.data(), payload.size());
  };
  std::for_each_n(trajectories.begin(), std::min(kAhead, trajectories.size()), fetch);
  for (size_t i = 0; i < trajectories.size(); ++i) {
    if (i + kAhead < trajectories.size()) fetch(trajectories[i + kAhead]);
    for (const auto payload : trajectories[i].payloads) out.PutBytes(payload);
  }
}

// As the selectors of a replay make them.
bool IsShare(float value) { return value >= 0.0f && value <= 1.0f; }

void Zero(const MutableColumnRows& row, size_t columns) {
  for (size_t i = 0; i < columns; ++i) {
    std::ranges::fill(row.floats(i), 0.0f);
    std::ranges::fill(row.bits(i), uint8_t{0});
  }
}

}  // namespace

size_t TrajectoriesBytes(std::span<const SampledTrajectory> trajectories) {
  const size_t step_bytes = StepBytes(DecisionBytes(trajectories) / sizeof(float));
  size_t total = sizeof(WireHeader) + trajectories.size() * kEntryBytes + kChecksumBytes;
  for (const SampledTrajectory& trajectory : trajectories) {
    assert(!trajectory.steps.empty() && trajectory.steps.size() <= kMaxTrajectorySteps);
    total += trajectory.steps.size() * step_bytes + trajectory.payloads.size() * sizeof(uint32_t);
    for (const auto payload : trajectory.payloads) total += payload.size();
  }
  return total;
}

std::vector<std::byte> EncodeTrajectories(std::span<const SampledTrajectory> trajectories,
                                          const TrajectoryShape& shape, uint64_t schema,
                                          std::vector<std::byte> memory) {
  std::vector<std::byte> bytes = std::move(memory);
  bytes.resize(TrajectoriesBytes(trajectories));
  Output out(bytes.data());
  out.Put(WireHeader{.magic = kMagic,
                     .version = kVersion,
                     .schema = schema,
                     .trajectories = static_cast<uint32_t>(trajectories.size()),
                     .steps = static_cast<uint32_t>(shape.steps),
                     .all_observations = shape.all_observations ? 1u : 0u,
                     .decision_floats = static_cast<uint32_t>(DecisionBytes(trajectories) / sizeof(float)),
                     .total = bytes.size()});
  for (const SampledTrajectory& trajectory : trajectories) PutEntry(trajectory, out);
  for (const SampledTrajectory& trajectory : trajectories) {
    for (const SampledStep& step : trajectory.steps) PutStep(step, out);
  }
  for (const SampledTrajectory& trajectory : trajectories) {
    for (const auto payload : trajectory.payloads) out.Put<uint32_t>(payload.size());
  }
  PutPayloads(trajectories, out);
  out.Put(Xxh3(std::span(bytes).first(bytes.size() - kChecksumBytes)));
  return bytes;
}

struct TrajectoryDecoder::Entry {
  uint64_t key = 0;
  float importance_weight = 0.0f;
  int steps = 0;
  uint16_t end = kNone;

  static Result<Entry> Get(ByteReader& reader, const TrajectoryShape& shape) {
    Entry entry;
    entry.key = reader.Get<uint64_t>();
    const auto probability = reader.Get<float>();
    entry.importance_weight = reader.Get<float>();
    entry.steps = reader.Get<uint16_t>();
    entry.end = reader.Get<uint16_t>();
    const bool whole = entry.steps == shape.steps || (entry.steps < shape.steps && entry.end != kNone);
    if (reader.ok() && IsShare(probability) && IsShare(entry.importance_weight) && entry.steps >= 1 &&
        whole && entry.end < kEnds) {
      return entry;
    }
    return Fail(ErrorCode::kCorrupt, "batch: trajectory {:#x} of {} steps is malformed", entry.key,
                entry.steps);
  }
  int payloads(const TrajectoryShape& shape) const {
    return (shape.all_observations ? steps : 1) + (end == kTerminatedEnd ? 0 : 1);
  }
};

// Readers at the beginnings of the message's parts.
struct TrajectoryDecoder::Sections {
  std::vector<Entry> entries;
  ByteReader steps;
  ByteReader lengths;
  ByteReader payloads;
};

TrajectoryDecoder::TrajectoryDecoder(const StepSpec& spec, const ExperienceBounds& bounds)
    : spec_(spec),
      schema_(SchemaHash(spec)),
      bounds_(bounds),
      codec_(spec, FloatCoding::kFloat16),  // which one only matters to an encoder
      decision_(spec.decision_floats()) {}

Result<TrajectoryDecoder::Sections> TrajectoryDecoder::CheckEnvelope(std::span<const std::byte> bytes,
                                                                     const TrajectoryBatch& batch) const {
  if (bytes.size() < sizeof(WireHeader) + kChecksumBytes) {
    return Fail(ErrorCode::kCorrupt, "batch of {} bytes is too short", bytes.size());
  }
  WireHeader header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.magic != kMagic || header.version != kVersion) {
    return Fail(ErrorCode::kCorrupt, "batch has no magic number of version {}", kVersion);
  }
  const auto content = header.total == bytes.size() ? CheckedContent(bytes) : std::nullopt;
  if (!content) {
    return Fail(ErrorCode::kCorrupt, "batch of {} bytes fails its length, {}, or its checksum", bytes.size(),
                header.total);
  }
  const TrajectoryShape& shape = batch.shape;
  if (header.schema != schema_ || header.decision_floats != decision_.size() ||
      std::cmp_not_equal(header.trajectories, shape.count) || std::cmp_not_equal(header.steps, shape.steps) ||
      header.all_observations != (shape.all_observations ? 1u : 0u)) {
    return Fail(ErrorCode::kCorrupt,
                "batch of {} trajectories of {} steps and schema {:#x}; asked for {} of {} and {:#x}",
                header.trajectories, header.steps, header.schema, shape.count, shape.steps, schema_);
  }
  ByteReader reader(content->subspan(sizeof(header)));
  std::vector<Entry> entries(header.trajectories);
  uint64_t steps = 0;
  uint64_t payloads = 0;
  for (Entry& entry : entries) {
    DADRL_ASSIGN_OR_RETURN(entry, Entry::Get(reader, shape));
    steps += static_cast<uint64_t>(entry.steps);
    payloads += static_cast<uint64_t>(entry.payloads(shape));
  }
  const ByteReader at_steps = reader;
  reader.GetBytes(steps * StepBytes(decision_.size()));
  const ByteReader at_lengths = reader;
  reader.GetBytes(payloads * sizeof(uint32_t));
  if (!reader.ok()) return Fail(ErrorCode::kCorrupt, "batch: its steps do not fit into it");
  return Sections{std::move(entries), at_steps, at_lengths, reader};
}

Status TrajectoryDecoder::DecodeSteps(Sections& sections, const Entry& entry, size_t index,
                                      TrajectoryBatch& batch) {
  const auto count = static_cast<size_t>(batch.shape.count);
  for (size_t t = 0; std::cmp_less(t, entry.steps); ++t) {
    const size_t cell = t * count + index;
    batch.policy_versions[cell] = sections.steps.Get<uint32_t>();
    batch.rewards[cell] = sections.steps.Get<float>();
    for (float& value : decision_) value = sections.steps.Get<float>();
    if (!bounds_.AllowsReward(batch.rewards[cell])) {
      return Fail(ErrorCode::kCorrupt, "batch: trajectory {:#x} has a reward beyond {:.4g}", entry.key,
                  bounds_.reward);
    }
    if (!IsPossibleDecision(spec_, decision_)) {
      return Fail(ErrorCode::kCorrupt, "batch: trajectory {:#x} has a decision beyond its columns' bounds",
                  entry.key);
    }
    size_t from = 0;
    for (std::vector<float>& column : batch.decisions) {
      const size_t elements = column.size() / batch.rewards.size();
      std::copy_n(decision_.data() + from, elements, column.data() + cell * elements);
      from += elements;
    }
  }
  for (size_t t = static_cast<size_t>(entry.steps); std::cmp_less(t, batch.shape.steps); ++t) {
    const size_t cell = t * count + index;
    batch.policy_versions[cell] = 0;
    batch.rewards[cell] = 0.0f;
    for (std::vector<float>& column : batch.decisions) {
      const size_t elements = column.size() / batch.rewards.size();
      std::fill_n(column.data() + cell * elements, elements, 0.0f);
    }
  }
  return {};
}

Status TrajectoryDecoder::DecodePayloads(Sections& sections, const Entry& entry, size_t index,
                                         TrajectoryBatch& batch) {
  const int payloads = entry.payloads(batch.shape);
  for (int t = 0; t < batch.shape.observations(); ++t) {
    const MutableColumnRows row(batch.observations, t * batch.shape.count + static_cast<int>(index), 1);
    if (t >= payloads) {
      Zero(row, batch.observations.columns());
      continue;
    }
    const auto payload = sections.payloads.GetBytes(sections.lengths.Get<uint32_t>());
    if (!sections.payloads.ok()) {
      return Fail(ErrorCode::kCorrupt, "batch: trajectory {:#x} does not fit into it", entry.key);
    }
    DADRL_RETURN_IF_ERROR(codec_.Decode(payload, row));
  }
  return {};
}

Status TrajectoryDecoder::Decode(std::span<const std::byte> bytes, TrajectoryBatch& batch) {
  DADRL_ASSIGN_OR_RETURN(Sections sections, CheckEnvelope(bytes, batch));
  for (size_t i = 0; i < sections.entries.size(); ++i) {
    const Entry& entry = sections.entries[i];
    DADRL_RETURN_IF_ERROR(DecodeSteps(sections, entry, i, batch));
    DADRL_RETURN_IF_ERROR(DecodePayloads(sections, entry, i, batch));
    batch.steps[i] = entry.steps;
    batch.terminated[i] = entry.end == kTerminatedEnd;
    batch.truncated[i] = entry.end == kTruncatedEnd;
    batch.weights[i] = entry.importance_weight;
    batch.keys[i] = entry.key;
  }
  if (sections.payloads.remaining() == 0) return {};
  return Fail(ErrorCode::kCorrupt, "batch has {} bytes too many", sections.payloads.remaining());
}

}  // namespace dadrl
