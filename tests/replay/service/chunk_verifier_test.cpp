#include "replay/service/chunk_verifier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/io/checksum.h"
#include "tests/driving_columns.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

std::vector<std::byte> Sound(uint64_t incarnation = 1) { return Build({.identity = {7, incarnation, 1}}); }

// A chunk whose envelope is whole, and whose frame `frame` is no observation.
std::vector<std::byte> Faulty(int frame, uint64_t incarnation = 1) {
  std::vector<std::byte> bytes = Sound(incarnation);
  const ChunkView view = ChunkView::Parse(bytes).value();
  bytes[static_cast<size_t>(view.payload(frame).data() - bytes.data())] = std::byte{0xff};
  const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
  std::memcpy(&bytes[bytes.size() - 8], &checksum, 8);
  return bytes;
}

Status Check(ChunkVerifier& verifier, const std::vector<std::byte>& bytes) {
  return verifier.Check(ChunkView::Parse(bytes).value());
}

void Trust(ChunkVerifier& verifier) {
  for (int i = 0; i < ChunkVerifier::kProbation; ++i) ASSERT_TRUE(Check(verifier, Sound()));
}

// Of 400 chunks with one faulty frame of four.
int Refused(ChunkVerifier& verifier) {
  int refused = 0;
  for (int i = 0; i < 400; ++i) {
    if (Check(verifier, Faulty(i % 4))) continue;
    ++refused;
    Trust(verifier);
  }
  return refused;
}

TEST(ChunkVerifier, FindsAnyFaultyFrameOfANewWriter) {
  for (int frame = 0; frame < 4; ++frame) {
    ChunkVerifier verifier(kTestSpec, false, 1);
    const Status checked = Check(verifier, Faulty(frame));
    ASSERT_FALSE(checked);
    EXPECT_THAT(checked.error().message, HasSubstr(fmt::format("actor 7, episode 1, frame {}", frame)));
  }
}

TEST(ChunkVerifier, FindsAFeatureBeyondWhatSensingClampsTo) {
  Observation impossible(kTestSpec);
  EgoOf(impossible)[4] = 1e30f;
  ChunkBuilder builder(kTestSpec, FloatCoding::kFloat32);
  builder.AddTransition(Observation(kTestSpec), Action{}, 0.0f, 0, 1);
  builder.AddTransition(impossible, Action{}, 0.0f, 0, 1);
  ChunkVerifier verifier(kTestSpec, false, 1);
  const Status checked = Check(verifier, builder.Finish({7, 1, 1}));
  ASSERT_FALSE(checked);
  EXPECT_THAT(checked.error().message, HasSubstr("frame 1: payload: column ego holds a number beyond 5"));
}

TEST(ChunkVerifier, LooksAtOneFrameOfATrustedWritersChunks) {
  ChunkVerifier verifier(kTestSpec, false, 1);
  Trust(verifier);
  // A quarter, within five standard deviations.
  EXPECT_NEAR(Refused(verifier), 100, 45);
}

TEST(ChunkVerifier, AFaultAndARestartEndTheTrust) {
  ChunkVerifier verifier(kTestSpec, false, 1);
  Trust(verifier);
  EXPECT_FALSE(Check(verifier, Faulty(3, /*incarnation=*/2)));
  Trust(verifier);
  while (Check(verifier, Faulty(0))) {
  }
  EXPECT_FALSE(Check(verifier, Faulty(3)));
}

TEST(ChunkVerifier, LooksAtEveryFrameWhenToldTo) {
  ChunkVerifier verifier(kTestSpec, true, 1);
  Trust(verifier);
  EXPECT_EQ(Refused(verifier), 400);
}

}  // namespace
}  // namespace dadrl
