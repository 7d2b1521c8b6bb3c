// Priorities of items, as a learner sends them. Input: pairs of a key and a priority.
#include <cmath>

#include "common/io/byte_io.h"
#include "replay/table.h"
#include "tests/fuzz/harness.h"
#include "tests/replay/test_chunks.h"

namespace dadrl::fuzz {
namespace {

constexpr size_t kSamples = 16;

std::unique_ptr<ReplayTable> OpenTable() {
  static const SystemClock clock;
  TableOptions options{.directory = {}, .spec = kTestSpec, .replay = {}, .n_step = 2};
  options.replay.sampler = SamplerKind::kPrioritized;
  options.replay.priority_exponent = 2.0;
  options.replay.min_size = 1;
  options.replay.samples_per_insert = 0.0;
  auto table = ReplayTable::Open(options, clock).value();
  for (uint64_t sequence = 1; sequence <= 4; ++sequence) {
    Require(table->Insert(Build({.identity = {1, 1, sequence}, .episode = sequence, .end = kTerminated})) ==
            ReplayTable::Insertion::kStored);
  }
  return table;
}

Bytes Input(std::initializer_list<std::pair<uint64_t, float>> pairs) {
  Bytes bytes;
  ByteWriter writer(bytes);
  for (const auto& [key, priority] : pairs) {
    writer.Put(key);
    writer.Put(priority);
  }
  return bytes;
}

}  // namespace

const int kMutants = 3000;

// Whatever they are, items are sampled with probabilities that can be divided by.
bool Check(std::span<std::byte> input) {
  const std::unique_ptr<ReplayTable> table = OpenTable();
  std::vector<uint64_t> keys;
  std::vector<float> priorities;
  for (ByteReader reader(input); reader.remaining() >= 12;) {
    keys.push_back(reader.Get<uint64_t>());
    priorities.push_back(reader.Get<float>());
  }
  table->UpdatePriorities(keys, priorities);
  const auto sampled = table->SampleItems({.count = kSamples}, 0);
  Require(sampled.has_value() && sampled->items.size() == kSamples);
  for (const SampledItems::Item& item : sampled->items) {
    Require(item.probability > 0.0f && item.probability <= 1.0f);
    Require(item.importance_weight > 0.0f && item.importance_weight <= 1.0f);
  }
  return table->stats().refused_priorities == 0;
}

Seeds MakeSeeds() {
  constexpr uint64_t kFirst = uint64_t{1} << 32;  // segment 1, chunk 0, frame 0
  return {.accepted = {Input({}), Input({{kFirst, 1.0f}, {kFirst + 1, 0.0f}, {kFirst + 64, 5000.0f}})},
          .refused = {Input({{kFirst, NAN}}), Input({{kFirst, -1.0f}}), Input({{kFirst, 3e38f}}),
                      Input({{kFirst, INFINITY}})}};
}

}  // namespace dadrl::fuzz
