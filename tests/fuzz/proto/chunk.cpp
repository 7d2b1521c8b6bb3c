// A chunk as an actor sends it and a segment holds it.
#include <cmath>
#include <cstring>

#include "proto/experience.h"
#include "tests/fuzz/harness.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl::fuzz {
namespace {

const DrivingShape kSpec;

// What every reader relies on.
void CheckFrame(const ChunkView& view, int frame) {
  Require(std::isfinite(view.reward(frame)));
  for (size_t i = 0; i < view.decision_floats(); ++i) Require(std::isfinite(view.decision(frame, i)));
  Require(view.decision(frame).size() == view.decision_floats() * sizeof(float));
  const bool last = frame + 1 == view.frames();
  Require(last || (view.flags(frame) & (kHasDecision | kTerminated)) == kHasDecision);
  const std::span<const std::byte> payload = view.payload(frame);
  Require(!payload.empty());
  Require(payload.data() >= view.bytes().data());
  Require(payload.data() + payload.size() + 8 <= view.bytes().data() + view.bytes().size());
}

}  // namespace

const int kMutants = 100000;

bool Check(std::span<std::byte> input) {
  const std::span<const std::byte> bytes = MendedIfAsked(input);
  ChunkFault fault = ChunkFault::kCount;
  const auto view = ChunkView::Parse(bytes, &fault);
  Require(view.has_value() || (fault >= ChunkFault::kGarbage && fault <= ChunkFault::kContents));
  if (!view) return false;
  Require(view->frames() >= 1 && view->frames() <= kMaxChunkFrames);
  const ChunkHeader header = view->header();
  Require(header.identity.sequence >= 1 && header.identity.sequence <= kMaxSequence);
  Require(header.first_frame + header.frames > header.first_frame);
  size_t payload_bytes = 0;
  for (int frame = 0; frame < view->frames(); ++frame) {
    CheckFrame(*view, frame);
    payload_bytes += view->payload(frame).size();
  }
  Require(payload_bytes == view->payload_bytes() && payload_bytes < bytes.size());
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds;
  const auto ended = MakeSyntheticChunk(kSpec, {.identity = {1, 2, 3}, .frames = 3, .end = kTerminated});
  const auto truncated =
      MakeSyntheticChunk(kSpec, {.identity = {1, 2, 4}, .frames = 2, .end = kTruncated, .final_frame = true});
  for (const Bytes& chunk : {ended, truncated}) seeds.accepted.push_back(AskMended(chunk));
  // What came from outside once: rewards, actions and numbers that no task produces.
  const auto spoiled = [&](size_t at, auto value) {
    Bytes bytes = AskMended(ended);
    std::memcpy(&bytes[1 + at], &value, sizeof(value));
    seeds.refused.push_back(std::move(bytes));
  };
  constexpr size_t kActions = kChunkHeaderBytes + 3 * 4;
  constexpr size_t kRewards = kActions + 3 * 8;
  spoiled(kRewards, INFINITY);
  spoiled(kActions, std::nanf(""));
  spoiled(32, UINT64_MAX);                         // sequence
  spoiled(12, UINT32_MAX);                         // first frame
  spoiled(kRewards + 3 * 4 + 4 + 4, uint32_t{0});  // offset of the second payload: the first is empty
  return seeds;
}

}  // namespace dadrl::fuzz
