// What a learner asks for, and what becomes of it on its way there. Input: count, steps, which observations,
// version.
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
    TableOptions options{.directory = {}, .spec = kTestSpec, .replay = {}, .n_step = kLongest};
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

Bytes Input(int32_t count, int32_t steps, bool all_observations, uint32_t version) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.Put(count);
  writer.Put(steps);
  writer.Put(static_cast<uint8_t>(all_observations));
  writer.Put(version);
  return bytes;
}

}  // namespace

const int kMutants = 20000;

bool Check(std::span<std::byte> input) {
  ByteReader reader(input);
  TrajectoryShape shape;
  shape.count = reader.Get<int32_t>();
  shape.steps = reader.Get<int32_t>();
  shape.all_observations = (reader.Get<uint8_t>() & 1) != 0;
  const auto version = reader.Get<uint32_t>();
  if (shape.count > 100) shape.count %= 100;  // no memory is at stake here
  Result<SampledItems> items = Table().SampleItems(shape, version);
  if (!items) return false;
  Require(std::cmp_equal(items->items.size(), shape.count));
  const auto sampled = ReadTrajectories(std::move(*items), shape);
  Require(sampled.has_value());
  const Bytes bytes = EncodeTrajectories(sampled->trajectories, shape, SchemaHash(kTestSpec));
  Require(bytes.size() == TrajectoriesBytes(sampled->trajectories));
  TrajectoryBatch batch(kTestSpec, shape);
  Require(TrajectoryDecoder(kTestSpec, kTestBounds).Decode(bytes, batch).has_value());
  return true;
}

Seeds MakeSeeds() {
  return {.accepted = {Input(8, 1, false, 1), Input(30, kLongest, false, UINT32_MAX), Input(5, 2, true, 1)},
          .refused = {Input(8, 0, false, 1), Input(8, kLongest + 1, false, 1), Input(8, INT32_MIN, false, 1),
                      Input(8, INT32_MAX, true, 1), Input(8, INT32_MIN, true, 1), Input(0, 1, false, 1),
                      Input(-1, 1, true, 1)}};
}

}  // namespace dadrl::fuzz
