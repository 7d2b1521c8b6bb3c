#include "tests/fuzz/decoders.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "common/io/checksum.h"
#include "proto/sample_batch.h"
#include "proto/sequence_batch.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl {
namespace {

enum Decoder : uint8_t { kFrame, kChunk, kBatch, kSequences, kDecoders };
constexpr uint8_t kMendChecksum = 0x80;
constexpr int kBatchSize = 3;
constexpr int kSequenceLength = 2;
const ObservationSpec kSpec;

void Require(bool condition) {
  if (!condition) std::abort();
}

// Memory that ends where an unreadable page begins: a read one byte beyond the input is a crash, sanitizer or
// not.
class GuardedBuffer {
 public:
  GuardedBuffer() {
    const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    void* memory = mmap(nullptr, kSize + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    Require(memory != MAP_FAILED);
    end_ = static_cast<std::byte*>(memory) + kSize;
    Require(mprotect(end_, page, PROT_NONE) == 0);
  }
  std::span<std::byte> Copy(std::span<const uint8_t> bytes) {
    const size_t size = std::min(bytes.size(), kSize);
    std::byte* begin = end_ - size;
    if (size > 0) std::memcpy(begin, bytes.data(), size);
    return {begin, size};
  }

 private:
  static constexpr size_t kSize = size_t{1} << 20;
  std::byte* end_;
};

void MendChecksum(std::span<std::byte> bytes) {
  if (bytes.size() < 8) return;
  const uint64_t checksum = Xxh3(bytes.first(bytes.size() - 8));
  std::memcpy(&bytes[bytes.size() - 8], &checksum, 8);
}

bool CheckFrame(std::span<const std::byte> payload) {
  static FrameCodec codec(kSpec, FloatCoding::kFloat16);
  static FrameCodec exact(kSpec, FloatCoding::kFloat32);
  Observation observation(kSpec);
  if (!codec.Decode(payload, observation.vehicles, observation.ego, observation.context)) return false;
  for (const auto* values : {&observation.vehicles, &observation.ego}) {
    for (const float value : *values) Require(std::isfinite(value));
  }
  // Whatever was decoded is an observation like any other.
  std::vector<std::byte> again;
  exact.Encode(observation, again);
  Observation copy(kSpec);
  Require(exact.Decode(again, copy.vehicles, copy.ego, copy.context).has_value());
  Require(std::memcmp(copy.ego.data(), observation.ego.data(), copy.ego.size() * sizeof(float)) == 0);
  Require(copy.context == observation.context);
  return true;
}

bool CheckChunk(std::span<const std::byte> bytes) {
  const auto view = ChunkView::Parse(bytes);
  if (!view) return false;
  Require(view->frames() >= 1 && view->frames() <= kMaxChunkFrames);
  size_t payload_bytes = 0;
  for (int frame = 0; frame < view->frames(); ++frame) {
    Require(std::isfinite(view->reward(frame)));
    Require(std::isfinite(view->action(frame)[0]) && std::isfinite(view->action(frame)[1]));
    const bool last = frame + 1 == view->frames();
    Require(last || (view->flags(frame) & (kHasAction | kTerminated)) == kHasAction);
    payload_bytes += view->payload(frame).size();
    CheckFrame(view->payload(frame));
  }
  Require(payload_bytes == view->payload_bytes() && payload_bytes < bytes.size());
  return true;
}

bool CheckBatch(std::span<const std::byte> bytes) {
  static FrameCodec codec(kSpec, FloatCoding::kFloat16);
  static TransitionBatch batch(kSpec, kBatchSize);
  if (!DecodeSampleBatch(bytes, SchemaHash(kSpec), 0.99, codec, batch)) return false;
  for (const auto* values : {&batch.reward, &batch.discount, &batch.weight, &batch.action,
                             &batch.observation.ego, &batch.next_observation.vehicles}) {
    for (const float value : *values) Require(std::isfinite(value));
  }
  return true;
}

bool CheckSequences(std::span<const std::byte> bytes) {
  static FrameCodec codec(kSpec, FloatCoding::kFloat16);
  static SequenceBatch batch(kSpec, kBatchSize, kSequenceLength);
  if (!DecodeSequenceBatch(bytes, SchemaHash(kSpec), codec, batch)) return false;
  for (const auto* values :
       {&batch.reward, &batch.weight, &batch.action, &batch.observation.ego, &batch.observation.vehicles}) {
    for (const float value : *values) Require(std::isfinite(value));
  }
  for (size_t i = 0; i < kBatchSize; ++i) {
    const int steps = batch.steps[i];
    const bool ended = batch.terminated[i] != 0 || batch.truncated[i] != 0;
    Require(steps >= 1 && steps <= kSequenceLength && (ended || steps == kSequenceLength));
    Require(batch.terminated[i] == 0 || batch.truncated[i] == 0);
    for (auto behind = static_cast<size_t>(steps); behind < kSequenceLength; ++behind) {
      Require(batch.reward[i * kSequenceLength + behind] == 0.0f);
    }
  }
  return true;
}

std::vector<uint8_t> Input(uint8_t decoder, std::span<const std::byte> bytes) {
  std::vector<uint8_t> input{decoder};
  for (const std::byte byte : bytes) input.push_back(static_cast<uint8_t>(byte));
  return input;
}

// One that goes on, one cut short by a termination, one that is truncated.
std::vector<std::byte> SeedSequences(std::span<const std::byte> ended, std::span<const std::byte> truncated) {
  const auto first = ChunkView::Parse(ended).value();
  const auto second = ChunkView::Parse(truncated).value();
  std::vector<SampledSequence> sequences(kBatchSize);
  sequences[0].steps.resize(2);
  sequences[0].frames = {first.payload(0), first.payload(1), first.payload(2)};
  sequences[1].terminated = true;
  sequences[1].steps.resize(1);
  sequences[1].frames = {first.payload(2)};
  sequences[2].truncated = true;
  sequences[2].steps.resize(2);
  sequences[2].frames = {second.payload(0), second.payload(1), second.payload(2)};
  return EncodeSequenceBatch(sequences, kSequenceLength, SchemaHash(kSpec));
}

}  // namespace

bool CheckDecoder(std::span<const uint8_t> input) {
  static GuardedBuffer buffer;
  if (input.empty()) return false;
  const std::span<std::byte> bytes = buffer.Copy(input.subspan(1));
  if ((input[0] & kMendChecksum) != 0) MendChecksum(bytes);
  switch ((input[0] & ~kMendChecksum) % kDecoders) {
    case kFrame:
      return CheckFrame(bytes);
    case kChunk:
      return CheckChunk(bytes);
    case kBatch:
      return CheckBatch(bytes);
    default:
      return CheckSequences(bytes);
  }
}

std::vector<std::vector<uint8_t>> SeedInputs() {
  std::vector<std::vector<uint8_t>> inputs;
  Random random(1);
  for (const FloatCoding coding : {FloatCoding::kFloat16, FloatCoding::kFloat32}) {
    FrameCodec codec(kSpec, coding);
    for (const Observation& observation :
         {SyntheticObservation(kSpec, random), NoiseObservation(kSpec, random), Observation(kSpec)}) {
      std::vector<std::byte> payload;
      codec.Encode(observation, payload);
      inputs.push_back(Input(kFrame, payload));
    }
  }
  const auto ended = MakeSyntheticChunk(kSpec, {.identity = {1, 2, 3}, .frames = 3, .end = kTerminated});
  const auto truncated =
      MakeSyntheticChunk(kSpec, {.identity = {1, 2, 4}, .frames = 2, .end = kTruncated, .final_frame = true});
  for (const auto& chunk : {ended, truncated}) inputs.push_back(Input(kChunk | kMendChecksum, chunk));

  const auto view = ChunkView::Parse(truncated).value();
  const std::vector<float> rewards{1.0f, 2.0f};
  std::vector<SampledItem> items(kBatchSize);
  for (SampledItem& item : items) {
    item.rewards = rewards;
    item.first = view.payload(0);
    item.next = view.payload(2);
  }
  items[1].terminated = true;
  items[1].next = {};
  inputs.push_back(Input(kBatch | kMendChecksum, EncodeSampleBatch(items, SchemaHash(kSpec))));
  inputs.push_back(Input(kSequences | kMendChecksum, SeedSequences(ended, truncated)));
  return inputs;
}

}  // namespace dadrl
