#include "actor/policies/learned_policy.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/config/config_yaml.h"
#include "common/model/policy_file.h"
#include "common/util/random.h"

namespace dadrl {
namespace {

class LearnedPolicyTest : public testing::Test {
 protected:
  LearnedPolicyTest() : path_(testing::TempDir() + "/policy_" + std::to_string(getpid()) + ".dadrl") {
    trained_.task.decision_interval = 4;
    trained_.task.max_speed_mps = 8.0;
    trained_.model.hidden = 32;
  }
  ~LearnedPolicyTest() override { std::filesystem::remove(path_); }

  std::unique_ptr<PolicyModel> Model() const {
    return MakePolicyModel(DrivingShape::From(trained_.observation), trained_.model).value();
  }
  // Small random parameters, saved as a training would.
  std::vector<float> Save() {
    const nn::ParamLayout layout = Model()->layout();
    std::vector<float> parameters(layout.size());
    Random random(1);
    for (float& parameter : parameters) parameter = static_cast<float>(random.Uniform(-0.1, 0.1));
    const PolicyToSave saved{3, 100, ToYaml(trained_, false), {{kPolicyNetwork, layout.hash(), parameters}}};
    EXPECT_TRUE(SavePolicy(path_, saved));
    return parameters;
  }

  std::string path_;
  Config trained_;
};

TEST_F(LearnedPolicyTest, DrivesAsItsModelWithTheTrainingsTask) {
  const std::vector<float> parameters = Save();
  Config config;
  config.scenario = "roundabout_a";
  auto setup = MakePolicy(path_, config, {});
  ASSERT_TRUE(setup) << setup.error().message;
  EXPECT_EQ(setup->config.scenario, "roundabout_a");
  EXPECT_EQ(setup->config.task.decision_interval, 4);
  const auto environment = DrivingEnvironment::Create(setup->config);
  ASSERT_TRUE(environment) << environment.error().message;
  const auto reference = Model();
  ASSERT_TRUE(reference->Load(parameters));
  ASSERT_TRUE((*environment)->Reset(1'000'000));
  for (int decision = 0; decision < 10; ++decision) {
    const Action action = reference->Act((*environment)->observation(), nullptr);
    const Decision chosen = setup->policy->Decide(**environment);
    EXPECT_EQ(chosen.steps, 4);
    EXPECT_DOUBLE_EQ(chosen.command.target_speed_mps, 8.0 * (action[0] + 1.0) / 2.0);
    if ((*environment)->Drive(chosen.command, chosen.steps)->ended()) break;
  }
}

TEST_F(LearnedPolicyTest, ADamagedFileIsRefused) {
  Save();
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 5);
  const auto setup = MakePolicy(path_, Config{}, {});
  ASSERT_FALSE(setup);
  EXPECT_EQ(setup.error().code, ErrorCode::kCorrupt);
}

}  // namespace
}  // namespace dadrl
