// What a learner asks for, and what becomes of it on its way there. Input: count, steps, length, version.
#include <cmath>

#include "common/io/byte_io.h"
#include "replay/table.h"
#include "tests/fuzz/harness.h"
#include "tests/replay/test_chunks.h"

namespace dadrl::fuzz {
namespace {

constexpr int kLongest = 3;

ReplayTable& Table() {
  static const SystemClock clock;
  static const std::unique_ptr<ReplayTable> table = [] {
    TableOptions options{.directory = {}, .schema = SchemaHash(kTestSpec), .replay = {}, .n_step = kLongest};
    options.replay.min_size = 1;
    options.replay.samples_per_insert = 0.0;
    options.replay.sequence_length = kLongest;
    auto opened = ReplayTable::Open(options, clock).value();
    for (uint64_t sequence = 1; sequence <= 9; ++sequence) {
      const bool truncated = sequence % 2 == 0;
      Require(opened->Insert(Build({.identity = {1, 1, sequence},
                                    .episode = sequence,
                                    .frames = static_cast<int>(sequence),
                                    .end = truncated ? kTruncated : kTerminated,
                                    .final_frame = truncated})) == ReplayTable::Insertion::kStored);
    }
    return opened;
  }();
  return *table;
}

Bytes Input(uint16_t count, int32_t n_step, int32_t length, uint32_t version) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.Put(count);
  writer.Put(n_step);
  writer.Put(length);
  writer.Put(version);
  return bytes;
}

void CheckSlices(DrawnItems drawn, int n_step, int count) {
  FrameCodec codec(kTestSpec, FloatCoding::kFloat32);
  TransitionBatch batch(kTestSpec, count);
  const auto sampled = AssembleBatch(std::move(drawn), n_step);
  Require(sampled.has_value());
  const Bytes bytes = EncodeSampleBatch(sampled->items, SchemaHash(kTestSpec));
  Require(bytes.size() == SampleBatchBytes(sampled->items));
  Require(DecodeSampleBatch(bytes, SchemaHash(kTestSpec), 0.9, kTestBounds, codec, batch).has_value());
}

void CheckSequences(DrawnItems drawn, int length, int count) {
  FrameCodec codec(kTestSpec, FloatCoding::kFloat32);
  SequenceBatch batch(kTestSpec, count, length);
  const auto sampled = AssembleSequences(std::move(drawn), length);
  Require(sampled.has_value());
  const Bytes bytes = EncodeSequenceBatch(sampled->sequences, length, SchemaHash(kTestSpec));
  Require(DecodeSequenceBatch(bytes, SchemaHash(kTestSpec), kTestBounds, codec, batch).has_value());
}

}  // namespace

const int kMutants = 20000;

bool Check(std::span<std::byte> input) {
  ByteReader reader(input);
  ReplayTable::Wanted wanted;
  wanted.count = reader.Get<uint16_t>() % 100;
  wanted.n_step = reader.Get<int32_t>();
  wanted.sequence_length = reader.Get<int32_t>();
  wanted.policy_version = reader.Get<uint32_t>();
  Result<DrawnItems> drawn = Table().Draw(wanted);
  if (!drawn) return false;
  Require(drawn->items.size() == wanted.count);
  const auto count = static_cast<int>(wanted.count);
  if (wanted.sequence_length > 0) {
    CheckSequences(std::move(*drawn), wanted.sequence_length, count);
  } else {
    CheckSlices(std::move(*drawn), wanted.n_step, count);
  }
  return true;
}

Seeds MakeSeeds() {
  return {.accepted = {Input(8, 1, 0, 1), Input(30, kLongest, 0, UINT32_MAX), Input(5, 0, 2, 1)},
          .refused = {Input(8, 0, 0, 1), Input(8, kLongest + 1, 0, 1), Input(8, INT32_MIN, 0, 1),
                      Input(8, 1, INT32_MAX, 1), Input(8, 1, INT32_MIN, 1), Input(0, 1, 0, 1)}};
}

}  // namespace dadrl::fuzz
