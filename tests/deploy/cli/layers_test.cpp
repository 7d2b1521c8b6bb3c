// The guard of the layers must itself be able to fail.
#include <gmock/gmock.h>

#include "tests/deploy/cli/run_command.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

class LayersTest : public testing::Test {
 protected:
  LayersTest() {
    for (const char* name : {"common", "proto", "replay", "learner", "actor", "deploy"}) {
      std::filesystem::create_directories(folder_.path() / name);
      Write(std::string(name) + "/CMakeLists.txt", std::string("dadrl_library(") + name + "_part)\n");
    }
  }
  void Write(const std::string& file, const std::string& text) {
    std::ofstream(folder_.path() / file) << text;
  }
  CommandOutput Check() { return RunCommand({DADRL_SOURCE_DIR "/tests/check_layers.sh", folder_.path()}); }

  TemporaryFolder folder_;
};

TEST_F(LayersTest, AcceptsDownwardUse) {
  Write("learner/a.cpp", "#include \"proto/topics.h\"\n#include \"common/x.h\"\n");
  Write("learner/CMakeLists.txt", "dadrl_library(learner_part LINK dadrl_common_part dadrl_proto_part)\n");
  EXPECT_EQ(Check().exit_code, 0);
}

TEST_F(LayersTest, RefusesUpwardInclude) {
  Write("common/a.h", "#include \"actor/sim/world.h\"\n");
  const CommandOutput output = Check();
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_THAT(output.err, HasSubstr("common/a.h"));
}

TEST_F(LayersTest, RefusesSidewaysLink) {
  Write("learner/CMakeLists.txt", "dadrl_library(learner_part LINK dadrl_replay_part)\n");
  const CommandOutput output = Check();
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_THAT(output.err, HasSubstr("links dadrl_replay_part of replay"));
}

TEST_F(LayersTest, LockstepMayLinkEverythingAndNobodyMayLinkIt) {
  std::filesystem::create_directories(folder_.path() / "deploy/lockstep");
  Write("deploy/lockstep/CMakeLists.txt",
        "dadrl_library(lockstep LINK dadrl_actor_part dadrl_learner_part)\n");
  Write("deploy/lockstep/a.cpp", "#include \"learner/trainer.h\"\n");
  EXPECT_EQ(Check().exit_code, 0);
  Write("deploy/CMakeLists.txt", "dadrl_library(deploy_part LINK dadrl_lockstep)\n");
  EXPECT_EQ(Check().exit_code, 1);
}

TEST_F(LayersTest, RefusesSumoOutsideTheActor) {
  Write("replay/a.cpp", "#include <libsumo/Simulation.h>\n");
  EXPECT_EQ(Check().exit_code, 1);
  EXPECT_EQ((std::filesystem::remove(folder_.path() / "replay/a.cpp"), Check().exit_code), 0);
}

}  // namespace
}  // namespace dadrl
