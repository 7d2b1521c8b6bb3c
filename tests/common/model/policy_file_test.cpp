#include "common/model/policy_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <cmath>
#include <limits>

#include "common/config/config_yaml.h"
#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/read_file.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

class PolicyFileTest : public testing::Test {
 protected:
  PolicyToSave Policy() {
    return {.policy_version = 7,
            .updates = 900,
            .config_yaml = ToYaml(config_, false),
            .networks = {{"policy", 0x1234, parameters_}, {"critic", 0x5678, critic_}}};
  }
  // The same as format 1 (the policy alone) or 2 (both networks).
  std::vector<std::byte> OldPolicy(uint32_t format, std::span<const float> critic) {
    std::vector<std::byte> bytes;
    ByteWriter writer(bytes);
    writer.PutBytes(std::as_bytes(std::span(std::string_view("DADRLPOL"))));
    writer.Put(format);
    writer.Put(uint32_t{7});
    writer.Put(uint64_t{900});
    writer.Put(uint64_t{0x1234});
    writer.PutText(ToYaml(config_, false));
    const std::array<std::span<const float>, 2> networks = {parameters_, critic};
    for (const std::span<const float> network : std::span(networks).first(format)) {
      writer.Put(uint64_t{network.size()});
      writer.PutBytes(std::as_bytes(network));
    }
    writer.Put(Xxh3(bytes));
    return bytes;
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
  EXPECT_EQ(loaded->policy_version, 7u);
  EXPECT_EQ(loaded->updates, 900u);
  EXPECT_EQ(loaded->config.model.hidden, 128);
  EXPECT_EQ(loaded->config.scenario, "double_merge");
  ASSERT_EQ(loaded->networks.size(), 2u);
  EXPECT_EQ(loaded->policy().name, "policy");
  EXPECT_EQ(loaded->policy().layout_hash, 0x1234u);
  EXPECT_EQ(loaded->policy().parameters, parameters_);
  ASSERT_EQ(loaded->Find("critic"), &loaded->networks[1]);
  EXPECT_EQ(loaded->networks[1].layout_hash, 0x5678u);
  EXPECT_EQ(loaded->networks[1].parameters, critic_);
  EXPECT_EQ(loaded->Find("value"), nullptr);
}

// As another program computed it from the format: old files and new ones stay the same.
TEST_F(PolicyFileTest, WritesTheBytesOfItsFormat) {
  PolicyToSave policy = Policy();
  policy.config_yaml = "seed: 3\n";
  ASSERT_TRUE(SavePolicy(path_, policy));
  const std::vector<std::byte> bytes = Saved();
  ASSERT_EQ(bytes.size(), 124u);
  EXPECT_EQ(ByteReader(std::span(bytes).last(8)).Get<uint64_t>(), 0x57ccafee284a2357u);
  EXPECT_TRUE(CheckedContent(bytes));
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

TEST_F(PolicyFileTest, ReadsTheFormatsWithoutNames) {
  WritePlainly(path_, OldPolicy(2, critic_));
  const auto both = LoadPolicy(path_);
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_EQ(both->policy_version, 7u);
  EXPECT_EQ(both->updates, 900u);
  EXPECT_EQ(both->policy().layout_hash, 0x1234u);
  EXPECT_EQ(both->policy().parameters, parameters_);
  ASSERT_NE(both->Find("critic"), nullptr);
  EXPECT_EQ(both->Find("critic")->parameters, critic_);
  EXPECT_TRUE(CheckLayout(*both->Find("critic"), path_, 0x99, 2)) << "it does not say which layout";
  EXPECT_FALSE(CheckLayout(*both->Find("critic"), path_, 0x99, 3));
  for (const auto& bytes : {OldPolicy(1, {}), OldPolicy(2, {})}) {
    WritePlainly(path_, bytes);
    const auto alone = LoadPolicy(path_);
    ASSERT_TRUE(alone) << alone.error().message;
    EXPECT_EQ(alone->policy().parameters, parameters_);
    EXPECT_EQ(alone->networks.size(), 1u);
  }
}

TEST_F(PolicyFileTest, DamageToTheFormatsWithoutNamesIsNoticed) {
  const std::vector<std::byte> good = OldPolicy(2, critic_);
  for (size_t i = 0; i < good.size(); ++i) {
    std::vector<std::byte> bad = good;
    bad[i] ^= std::byte{0x40};
    WritePlainly(path_, bad);
    ASSERT_FALSE(LoadPolicy(path_)) << "byte " << i;
    WritePlainly(path_, std::span(good).first(i));
    ASSERT_FALSE(LoadPolicy(path_)) << "length " << i;
  }
}

TEST_F(PolicyFileTest, NamesThatAreNoneOrDoubleOrMissThePolicyAreCorrupt) {
  const auto refusal = [&](std::vector<NamedNetwork> networks) {
    PolicyToSave policy = Policy();
    policy.networks = std::move(networks);
    EXPECT_TRUE(SavePolicy(path_, policy));
    const auto loaded = LoadPolicy(path_);
    return loaded ? "accepted" : loaded.error().message;
  };
  const NamedNetwork policy{"policy", 1, parameters_};
  EXPECT_THAT(refusal({}), HasSubstr("its first network is not 'policy'"));
  EXPECT_THAT(refusal({{"critic", 1, critic_}, policy}), HasSubstr("its first network is not 'policy'"));
  EXPECT_THAT(refusal({policy, policy}), HasSubstr("name of network 1"));
  const std::string long_name(65, 'a');
  for (const std::string& name : {std::string("../critic"), std::string(), std::string("a b"), long_name}) {
    EXPECT_THAT(refusal({policy, {name, 1, critic_}}), HasSubstr("name of network 1")) << name;
  }
}

// A file that claims to be as long as it is, with nothing in it: what would be taken for its numbers is not
// there to take.
TEST_F(PolicyFileTest, LongFileWithoutContentsIsRefusedByItsHead) {
  std::vector<std::byte> head = OldPolicy(2, critic_);
  head.resize(12);
  for (const size_t kept : {size_t{0}, head.size()}) {
    WritePlainly(path_, std::span(head).first(kept));
    std::filesystem::resize_file(path_, kMaxPolicyBytes);
    rusage before{};
    rusage after{};
    getrusage(RUSAGE_SELF, &before);
    EXPECT_EQ(LoadPolicy(path_).error().code, ErrorCode::kCorrupt);
    getrusage(RUSAGE_SELF, &after);
    EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 64 << 10) << "KiB";
  }
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
  const size_t policy_count =
      critic_count - 8 - 4 - std::string_view("critic").size() - parameters_.size() * sizeof(float) - 8;
  for (const size_t count_at : {critic_count, policy_count}) {
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
  EXPECT_THAT(loaded.error().message, HasSubstr("formats 1 to 3"));
}

TEST_F(PolicyFileTest, ParameterThatIsNotFiniteIsCorrupt) {
  parameters_[2] = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  EXPECT_THAT(LoadPolicy(path_).error().message, HasSubstr("parameter 2 of network 'policy' is not finite"));
}

TEST_F(PolicyFileTest, OtherLayoutIsRefused) {
  ASSERT_TRUE(SavePolicy(path_, Policy()));
  const StoredNetwork policy = LoadPolicy(path_).value().policy();
  EXPECT_TRUE(CheckLayout(policy, path_, 0x1234, 4));
  EXPECT_EQ(CheckLayout(policy, path_, 0x1235, 4).error().code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(CheckLayout(policy, path_, 0x1234, 5));
}

}  // namespace
}  // namespace dadrl
