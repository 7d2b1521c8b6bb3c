#include "deploy/local/shipped_policies.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>

#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

class ShippedPoliciesTest : public testing::Test {
 protected:
  ShippedPoliciesTest() { setenv("DADRL_POLICIES", folder_.path().c_str(), 1); }
  ~ShippedPoliciesTest() override { unsetenv("DADRL_POLICIES"); }
  void Write(const std::string& file, const std::string& text) {
    std::ofstream(folder_.path() / file) << text;
  }

  TemporaryFolder folder_;
};

TEST_F(ShippedPoliciesTest, AreListedByNameWithTheirRecords) {
  Write("roundabout_a.dadrl", "weights");
  Write("left_turn.dadrl", "weights");
  Write("left_turn.json", R"({"scenario": "left_turn"})");
  Write("roundabout_a.json", "{damaged");
  Write("notes.txt", "not a policy");
  const std::vector<ShippedPolicy> policies = ShippedPolicies();
  ASSERT_EQ(policies.size(), 2u);
  EXPECT_EQ(policies[0].name, "left_turn");
  EXPECT_EQ(policies[0].file, folder_.path() / "left_turn.dadrl");
  EXPECT_EQ(policies[0].record["scenario"], "left_turn");
  EXPECT_EQ(policies[1].name, "roundabout_a");
  EXPECT_TRUE(policies[1].record.empty());
}

TEST_F(ShippedPoliciesTest, ResolveByNameAndLeaveOtherTextAlone) {
  Write("left_turn.dadrl", "weights");
  EXPECT_EQ(ResolvePolicy("pretrained:left_turn").value(), (folder_.path() / "left_turn.dadrl").string());
  EXPECT_EQ(ResolvePolicy("rdm").value(), "rdm");
  EXPECT_EQ(ResolvePolicy("runs/latest/checkpoints/latest").value(), "runs/latest/checkpoints/latest");
}

TEST_F(ShippedPoliciesTest, AnUnknownNameIsToldTheNearest) {
  EXPECT_THAT(ResolvePolicy("pretrained:left_turn").error().message, HasSubstr("no policy ships in"));
  Write("left_turn.dadrl", "weights");
  Write("double_merge.dadrl", "weights");
  const auto unknown = ResolvePolicy("pretrained:lft_turn");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(ExitCode(unknown.error()), 2);
  EXPECT_EQ(unknown.error().message,
            "no shipped policy is called 'lft_turn'; the nearest is 'left_turn' (there are: double_merge, "
            "left_turn)");
}

}  // namespace
}  // namespace dadrl
