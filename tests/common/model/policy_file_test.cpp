#include "common/model/policy_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/config/config_yaml.h"
#include "common/io/checksum.h"
#include "common/io/read_file.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

class PolicyFileTest : public testing::Test {
 protected:
  PolicyToSave Policy() {
    return {.layout_hash = 0x1234,
            .policy_version = 7,
            .updates = 900,
            .config_yaml = ToYaml(config_, false),
            .parameters = parameters_,
            .critic = critic_};
  }
  std::vector<std::byte> Saved() { return ReadFile(path_, 1 << 20).value(); }
  // Makes the checksum right again.
  static void Seal(std::vector<std::byte>& bytes) {
    const uint64_t checksum = Xxh3(std::span(bytes).first(bytes.size() - 8));
    std::memcpy(bytes.data() + bytes.size() - 8, &checksum, 8);
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "policy-900.dadrl";
  Config config_;
  std::vector<float> parameters_ = {0.5f, -1.25f, 3e-20f, 1e20f};
  std::vector<float> critic_ = {2.5f, -0.125f};
};

TEST_F(PolicyFileTest, ReadsBackEverything) {
  config_.model.hidden = 128;
  config_.scenario = "double_merge";
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  const auto loaded = LoadPolicy(path_);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->layout_hash, 0x1234u);
  EXPECT_EQ(loaded->policy_version, 7u);
  EXPECT_EQ(loaded->updates, 900u);
  EXPECT_EQ(loaded->config.model.hidden, 128);
  EXPECT_EQ(loaded->config.scenario, "double_merge");
  EXPECT_EQ(loaded->parameters, parameters_);
  EXPECT_EQ(loaded->critic, critic_);
}

TEST_F(PolicyFileTest, OutlivesChangesOfKeysThatNobodyDrivesBy) {
  config_.model.hidden = 128;
  PolicyToSave policy = Policy();
  policy.config_yaml += "replays:\n  once_was: 3\n";
  ASSERT_TRUE(SavePolicy(path_, policy));
  const auto loaded = LoadPolicy(path_);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->config.model.hidden, 128);
}

TEST_F(PolicyFileTest, RefusesAKeyOfTheNetworkThatItDoesNotKnow) {
  PolicyToSave policy = Policy();
  policy.config_yaml = "model:\n  hiden: 3\n";
  ASSERT_TRUE(SavePolicy(path_, policy));
  const auto loaded = LoadPolicy(path_);
  ASSERT_FALSE(loaded);
  EXPECT_THAT(loaded.error().message, HasSubstr("model.hidden"));
}

TEST_F(PolicyFileTest, ReadsTheFormatWithoutCritics) {
  critic_.clear();
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  std::vector<std::byte> bytes = Saved();
  bytes[8] = std::byte{1};
  bytes.erase(bytes.end() - 16, bytes.end() - 8);  // the critics' count
  Seal(bytes);
  WritePlainly(path_, bytes);
  const auto loaded = LoadPolicy(path_);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->parameters, parameters_);
  EXPECT_TRUE(loaded->critic.empty());
}

TEST_F(PolicyFileTest, MissingFileIsNotFoundAndNamed) {
  const auto loaded = LoadPolicy(path_);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(loaded.error().message, HasSubstr(path_.string()));
}

TEST_F(PolicyFileTest, EveryFlippedByteIsNoticed) {
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  const std::vector<std::byte> good = Saved();
  for (size_t i = 0; i < good.size(); ++i) {
    std::vector<std::byte> bad = good;
    bad[i] ^= std::byte{0x40};
    WritePlainly(path_, bad);
    const auto loaded = LoadPolicy(path_);
    ASSERT_FALSE(loaded) << "byte " << i;
    EXPECT_THAT(loaded.error().message, HasSubstr(path_.string()));
  }
}

TEST_F(PolicyFileTest, EveryTruncationIsCorrupt) {
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  const std::vector<std::byte> good = Saved();
  for (size_t length = 0; length < good.size(); ++length) {
    WritePlainly(path_, std::span(good).first(length));
    ASSERT_FALSE(LoadPolicy(path_)) << length;
    EXPECT_EQ(LoadPolicy(path_).error().code, ErrorCode::kCorrupt);
  }
}

TEST_F(PolicyFileTest, LengthsThatLieUnderAValidChecksumAreCorrupt) {
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  const std::vector<std::byte> good = Saved();
  const size_t critic_count = good.size() - 8 - critic_.size() * sizeof(float) - 8;
  for (const size_t count_at : {critic_count, critic_count - parameters_.size() * sizeof(float) - 8}) {
    for (const std::byte high : {std::byte{0xFF}, std::byte{0}}) {
      std::vector<std::byte> bytes = good;
      for (size_t i = 0; i < 8; ++i) bytes[count_at + i] = high;
      Seal(bytes);
      WritePlainly(path_, bytes);
      EXPECT_THAT(LoadPolicy(path_).error().message, HasSubstr("lengths"));
    }
  }
}

TEST_F(PolicyFileTest, AnotherFormatIsRefusedWithBothNumbers) {
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  std::vector<std::byte> bytes = Saved();
  bytes[8] = std::byte{9};
  WritePlainly(path_, bytes);
  const auto loaded = LoadPolicy(path_);
  EXPECT_EQ(loaded.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(loaded.error().message, HasSubstr("format 9"));
  EXPECT_THAT(loaded.error().message, HasSubstr("formats 1 and 2"));
}

TEST_F(PolicyFileTest, ParameterThatIsNotFiniteIsCorrupt) {
  parameters_[2] = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  EXPECT_THAT(LoadPolicy(path_).error().message, HasSubstr("parameter 2 is not finite"));
}

TEST_F(PolicyFileTest, OtherLayoutIsRefused) {
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  const PolicyFile loaded = LoadPolicy(path_).value();
  EXPECT_TRUE(CheckLayout(loaded, path_, 0x1234, 4));
  EXPECT_EQ(CheckLayout(loaded, path_, 0x1235, 4).error().code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(CheckLayout(loaded, path_, 0x1234, 5));
}

}  // namespace
}  // namespace dadrl
