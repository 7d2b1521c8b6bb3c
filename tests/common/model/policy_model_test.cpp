#include "common/model/policy_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/model/named_network.h"
#include "common/model/value_model.h"
#include "tests/common/model/counting_policy.h"

namespace dadrl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(PolicyModelTest, EveryNameMakesAModel) {
  for (const std::string& name : PolicyModelNames()) {
    ModelConfig config;
    config.policy = name;
    EXPECT_TRUE(CheckPolicyModel(config)) << name;
    const auto policy = MakePolicyModel(DrivingShape{}, config);
    ASSERT_TRUE(policy) << name;
    EXPECT_GT((*policy)->layout().size(), 0u);
  }
  EXPECT_THAT(PolicyModelNames(), testing::Contains(ModelConfig{}.policy)) << "the default is one of them";
}

TEST(PolicyModelTest, UnknownNameIsRefusedWithTheNearest) {
  ModelConfig config;
  config.policy = "squashed_gausian";
  const auto policy = MakePolicyModel(DrivingShape{}, config);
  ASSERT_FALSE(policy);
  EXPECT_EQ(policy.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(policy.error().message,
              HasSubstr("model.policy: 'squashed_gausian' is unknown; did you mean squashed_gaussian?"));
  EXPECT_EQ(CheckPolicyModel(config).error().message, policy.error().message);
}

TEST(PolicyModelTest, StepsWithoutAColumnThatItReadsAreRefusedByItsName) {
  StepSpec spec = DrivingShape{};
  spec.observation.erase(spec.observation.begin() + 1);
  EXPECT_THAT(MakePolicyModel(spec, {}).error().message, HasSubstr("ego"));
  EXPECT_THAT(MakeValueModel(kCriticNetwork, spec, {}).error().message, HasSubstr("ego"));
}

TEST(PolicyModelTest, DetailsAreFoundByName) {
  const std::vector<float> values = {1.0f, 2.0f};
  PolicyModel::Details details;
  details.numbers = {{"mean", values}};
  EXPECT_THAT(details.Find("mean"), ElementsAre(1.0f, 2.0f));
  EXPECT_THAT(details.Find("log_std"), IsEmpty());
}

TEST(ValueModelTest, NetworkThatNobodyKnowsIsRefusedByName) {
  EXPECT_TRUE(MakeValueModel(kCriticNetwork, DrivingShape{}, {}));
  const auto values = MakeValueModel("prophet", DrivingShape{}, {});
  ASSERT_FALSE(values);
  EXPECT_EQ(values.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(values.error().message, HasSubstr("'prophet'"));
}

}  // namespace
}  // namespace dadrl
