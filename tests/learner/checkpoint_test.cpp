#include "learner/checkpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "common/config/config_yaml.h"
#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/read_file.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/learner/fake_algorithm.h"

namespace dadrl {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class CheckpointTest : public testing::Test {
 protected:
  Checkpoint Captured() {
    Checkpoint checkpoint;
    CaptureState(algorithm_, checkpoint);
    checkpoint.updates = 12;
    checkpoint.weights_version = 5;
    checkpoint.trained_s = 61.5;
    checkpoint.cpu_s = 40.25;
    checkpoint.config_yaml = ToYaml(config_, false);
    checkpoint.published_ns = {100, 200, 300};
    return checkpoint;
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "checkpoint-12.ckpt";
  Config config_;
  FakeAlgorithm algorithm_;
};

TEST_F(CheckpointTest, ReadsBackEverything) {
  ASSERT_TRUE(SaveCheckpoint(path_, Captured()));
  const auto loaded = LoadCheckpoint(path_);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->updates, 12u);
  EXPECT_EQ(loaded->weights_version, 5u);
  EXPECT_EQ(loaded->trained_s, 61.5);
  EXPECT_EQ(loaded->cpu_s, 40.25);
  ASSERT_EQ(loaded->networks.size(), 1u);
  EXPECT_EQ(loaded->networks[0].name, kPolicyNetwork);
  EXPECT_EQ(loaded->networks[0].layout_hash, 0xfa4eu);
  EXPECT_EQ(loaded->config_yaml, ToYaml(config_, false));
  EXPECT_THAT(loaded->published_ns, testing::ElementsAre(100, 200, 300));
  EXPECT_THAT(loaded->networks[0].parameters,
              testing::ElementsAreArray(algorithm_.published_policy().parameters));
  FakeAlgorithm other(200, 99);
  ASSERT_TRUE(RestoreState(*loaded, path_, other));
  EXPECT_EQ(StateOf(other), StateOf(algorithm_));
}

// As another program computed it from the format: old files and new ones stay the same.
TEST_F(CheckpointTest, WritesTheBytesOfItsFormat) {
  Checkpoint checkpoint;
  checkpoint.updates = 12;
  checkpoint.weights_version = 5;
  checkpoint.trained_s = 61.5;
  checkpoint.cpu_s = 40.25;
  checkpoint.config_yaml = "seed: 3\n";
  checkpoint.published_ns = {100, 200};
  checkpoint.networks = {{"policy", 0x1234, {0.5f, -1.25f}}};
  checkpoint.blocks = {{"a", {std::byte{1}, std::byte{2}, std::byte{3}}}};
  ASSERT_TRUE(SaveCheckpoint(path_, checkpoint));
  const std::vector<std::byte> bytes = ReadFile(path_, 1 << 20).value();
  ASSERT_EQ(bytes.size(), 136u);
  EXPECT_EQ(ByteReader(std::span(bytes).last(8)).Get<uint64_t>(), 0xa4af2991e1be4f3cu);
  EXPECT_TRUE(CheckedContent(bytes));
}

// Of a run that was begun before processor time was counted: without the eight bytes of it.
TEST_F(CheckpointTest, ReadsItsFirstFormat) {
  ASSERT_TRUE(SaveCheckpoint(path_, Captured()));
  std::vector<std::byte> bytes = ReadFile(path_, 1 << 24).value();
  constexpr size_t kLengthAt = 8 + 4 + 4;
  constexpr size_t kCpuAt = 24 + 8 + 4 + 8;
  bytes.erase(bytes.begin() + kCpuAt, bytes.begin() + kCpuAt + 8);
  bytes[8] = std::byte{1};
  const uint64_t length = bytes.size();
  std::memcpy(bytes.data() + kLengthAt, &length, 8);
  const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
  std::memcpy(bytes.data() + bytes.size() - 8, &checksum, 8);
  WritePlainly(path_, bytes);
  const auto loaded = LoadCheckpoint(path_);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->trained_s, 61.5);
  EXPECT_EQ(loaded->cpu_s, 0.0);
  EXPECT_THAT(loaded->published_ns, testing::ElementsAre(100, 200, 300));
}

TEST_F(CheckpointTest, DamageAtAnyOffsetIsNoticed) {
  ASSERT_TRUE(SaveCheckpoint(path_, Captured()));
  const std::vector<std::byte> good = ReadFile(path_, 1 << 24).value();
  // Every byte of the head, then a sample of the rest down to the last.
  for (size_t i = 0; i < good.size(); i += i < 64 ? 1 : 37) {
    std::vector<std::byte> bad = good;
    bad[i] ^= std::byte{0x10};
    WritePlainly(path_, bad);
    const auto loaded = LoadCheckpoint(path_);
    ASSERT_FALSE(loaded) << "byte " << i;
    EXPECT_THAT(loaded.error().message, HasSubstr(path_.string()));
  }
}

TEST_F(CheckpointTest, TruncationAtAnyLengthIsCorruptWithTheRemedy) {
  ASSERT_TRUE(SaveCheckpoint(path_, Captured()));
  const std::vector<std::byte> good = ReadFile(path_, 1 << 24).value();
  for (size_t length = 0; length < good.size(); length += length < 64 ? 1 : 41) {
    WritePlainly(path_, std::span(good).first(length));
    const auto loaded = LoadCheckpoint(path_);
    ASSERT_FALSE(loaded) << length;
    EXPECT_EQ(loaded.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(loaded.error().message,
                AllOf(HasSubstr(path_.string()), HasSubstr("resume from the checkpoint")));
  }
}

TEST_F(CheckpointTest, LengthsThatLieUnderAValidChecksumAreCorrupt) {
  Checkpoint checkpoint = Captured();
  ASSERT_TRUE(SaveCheckpoint(path_, checkpoint));
  std::vector<std::byte> bytes = ReadFile(path_, 1 << 24).value();
  const size_t publish_count_at = 24 + 8 + 4 + 8 + 8 + 8 + 4 + checkpoint.config_yaml.size();
  for (size_t i = 0; i < 8; ++i) bytes[publish_count_at + i] = std::byte{0xFF};
  const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
  std::memcpy(bytes.data() + bytes.size() - 8, &checksum, 8);
  WritePlainly(path_, bytes);
  EXPECT_THAT(LoadCheckpoint(path_).error().message, HasSubstr("lengths"));
}

TEST_F(CheckpointTest, LongFileIsRefusedByItsHead) {
  ASSERT_TRUE(SaveCheckpoint(path_, Captured()));
  std::filesystem::resize_file(path_, uint64_t{4} << 30);
  rusage before{};
  rusage after{};
  getrusage(RUSAGE_SELF, &before);
  EXPECT_EQ(LoadCheckpoint(path_).error().code, ErrorCode::kCorrupt);
  std::filesystem::resize_file(path_, (uint64_t{4} << 30) + 1);
  EXPECT_EQ(LoadCheckpoint(path_).error().code, ErrorCode::kExhausted);
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 64 << 10) << "KiB";
}

TEST_F(CheckpointTest, AnotherFormatIsRefusedWithBothNumbers) {
  ASSERT_TRUE(SaveCheckpoint(path_, Captured()));
  std::vector<std::byte> bytes = ReadFile(path_, 1 << 24).value();
  bytes[8] = std::byte{3};
  WritePlainly(path_, bytes);
  EXPECT_EQ(LoadCheckpoint(path_).error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(LoadCheckpoint(path_).error().message,
              AllOf(HasSubstr("format 3"), HasSubstr("formats 1 to 2")));
}

TEST_F(CheckpointTest, StateOfOtherSizeLeavesTheAlgorithmUntouched) {
  FakeAlgorithm larger(300);
  const std::vector<std::byte> before = StateOf(larger);
  const Status restored = RestoreState(Captured(), path_, larger);
  ASSERT_FALSE(restored);
  EXPECT_THAT(restored.error().message, AllOf(HasSubstr("'policy' of 800 bytes"), HasSubstr("of 1200")));
  EXPECT_EQ(StateOf(larger), before);
}

TEST_F(CheckpointTest, OtherNetworksAreRefusedByKeyAndBothValues) {
  Config other = config_;
  other.model.hidden = 128;
  other.observation.vehicles = 9;
  other.algorithm.gamma = 0.5;  // does not shape the networks
  const Status same = CheckSameNetworks(config_, other, path_);
  ASSERT_FALSE(same);
  EXPECT_EQ(same.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(same.error().message,
              AllOf(HasSubstr("model.hidden (there 256, now 128)"),
                    HasSubstr("observation.vehicles (there 6, now 9)"), Not(HasSubstr("gamma"))));
}

TEST_F(CheckpointTest, OtherLearningRatesAndLimitsAreWelcome) {
  Config other = config_;
  other.algorithm.actor_learning_rate = 1e-5;
  other.learner.max_updates = 10;
  EXPECT_TRUE(CheckSameNetworks(config_, other, path_));
}

}  // namespace
}  // namespace dadrl
