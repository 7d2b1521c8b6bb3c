// The state file: what it decodes to is written as it was, and a table that starts from it works.
#include <algorithm>
#include <cmath>

#include "replay/chunk_index.h"
#include "replay/storage/state_file.h"
#include "tests/fuzz/harness.h"
#include "tests/replay/test_chunks.h"

namespace dadrl::fuzz {
namespace {

ReplayState Whole() {
  ReplayState state{.schema = 5, .up_to = {1, 70}, .limiter = {10, 20, 1.5, 2.5}};
  state.limiter_change = {{.min_size = 1}, {.min_size = 2, .max_samples_per_insert = 3.0}};
  state.sequences.Accept({3, 4, 5});
  state.sequences.Accept({3, 5, 1});
  state.items.max_priority = 4.0;
  return state;
}

// An index of one chunk, and the states of its items.
struct Indexed {
  std::shared_ptr<const Segment> segment = Segment::Create({}, 1, SchemaHash(kTestSpec), 1 << 16).value();
  Bytes chunk = Build({.frames = 6, .end = kTerminated});

  std::unique_ptr<ChunkIndex> Make() const {
    auto index = std::make_unique<ChunkIndex>(
        ChunkIndex::Options{.sampler = SamplerKind::kPrioritized, .max_times_sampled = 9});
    index->Add(segment, ChunkView::Parse(chunk).value());
    return index;
  }
};

void CheckRestart(const ReplayState& state) {
  static const Indexed indexed;
  const std::unique_ptr<ChunkIndex> index = indexed.Make();
  index->Restore(state.items);
  Random random(1);
  if (!index->CanSample(4)) return;
  for (const SampledItems::Item& item : index->SampleItems(4, 1, random).items) {
    Require(item.probability > 0.0f && item.probability <= 1.0f);
    Require(item.importance_weight > 0.0f && item.importance_weight <= 1.0f);
  }
  RateLimiter limiter({});
  if (state.limiter_change) limiter.Reconfigure(state.limiter_change->current);
  limiter.Restore(state.limiter);
  limiter.OnInsert(64);
  limiter.OnSample(64);
  Require(std::isfinite(limiter.state().sample_credit) && std::isfinite(limiter.state().insert_debt));
}

}  // namespace

const int kMutants = 60000;

bool Check(std::span<std::byte> input) {
  const std::span<const std::byte> bytes = MendedIfAsked(input);
  const auto state = DecodeReplayState(bytes, "state");
  if (!state) return false;
  for (const SequenceTable::Stream& stream : state->sequences.Newest())
    Require(stream.stored <= kMaxSequence);
  // Not the same bytes: streams may come in another order. The same state.
  const Bytes again = EncodeReplayState(*state);
  const auto copy = DecodeReplayState(again, "state");
  Require(copy.has_value() && EncodeReplayState(*copy) == again);
  CheckRestart(*state);
  return true;
}

Seeds MakeSeeds() {
  const auto input = [](const ReplayState& state) { return AskMended(EncodeReplayState(state)); };
  ReplayState with_items = Whole();
  with_items.items = Indexed().Make()->States();
  Seeds seeds{.accepted = {input({}), input(Whole()), input(with_items)}, .refused = {}};
  ReplayState endless = with_items;
  endless.limiter.insert_debt = INFINITY;
  ReplayState heavy = with_items;
  heavy.items.priorities[1] = NAN;
  ReplayState far = Whole();
  far.sequences.Accept({3, 5, UINT64_MAX});
  for (const ReplayState& state : {endless, heavy, far}) seeds.refused.push_back(input(state));
  return seeds;
}

}  // namespace dadrl::fuzz
