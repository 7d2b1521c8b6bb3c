#include "actor/render/render_command.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "common/config/config_yaml.h"
#include "common/model/policy_file.h"
#include "common/model/policy_model.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class RenderCommandTest : public testing::Test {
 protected:
  RenderCommandTest() : folder_(fs::path(testing::TempDir()) / ("render_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
    options_.config.scenario = "left_turn";
    options_.policy = "rdm";
    options_.seeds = {1'000'000};
  }
  ~RenderCommandTest() override { fs::remove_all(folder_); }

  Status Run() {
    episodes_.clear();
    return RunRender(options_, [this](const RenderedEpisode& episode) {
      episodes_.push_back(episode);
      return true;
    });
  }
  std::string Out(const std::string& name) { return options_.out = (folder_ / name).string(); }
  static std::string Content(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
  std::vector<std::string> Names(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

  fs::path folder_;
  RenderOptions options_;
  std::vector<RenderedEpisode> episodes_;
};

TEST_F(RenderCommandTest, TheEndingChoosesWhatIsDrawn) {
  Out("episode.svg");
  ASSERT_TRUE(Run());
  EXPECT_THAT(Content(options_.out), HasSubstr("<animate"));
  Out("episode.png");
  ASSERT_TRUE(Run());
  EXPECT_EQ(Content(options_.out).substr(1, 3), "PNG");
  Out("frames/");
  ASSERT_TRUE(Run());
  ASSERT_THAT(episodes_, SizeIs(1));
  // Each fifth step, and the last.
  EXPECT_EQ(static_cast<int>(episodes_[0].files.size()), (episodes_[0].steps + 4) / 5 + 1);
  EXPECT_EQ(episodes_[0].files.size(), Names(options_.out).size());
  for (const std::string& file : episodes_[0].files) {
    EXPECT_THAT(Content(file), testing::Not(HasSubstr("<animate"))) << file;
  }
  EXPECT_TRUE(episodes_[0].files.back().ends_with(fmt::format("frame-{:04}.svg", episodes_[0].steps)));
}

TEST_F(RenderCommandTest, ASecondRunLeavesNoFramesOfTheFirst) {
  Out("frames/");
  options_.every = 1;
  ASSERT_TRUE(Run());
  std::ofstream(folder_ / "frames" / "notes.txt") << "mine";
  options_.every = 10;
  ASSERT_TRUE(Run());
  EXPECT_EQ(Names(options_.out).size(), episodes_[0].files.size() + 1);
  EXPECT_EQ(Content(folder_ / "frames" / "notes.txt"), "mine");
}

TEST_F(RenderCommandTest, AGalleryHoldsTheEpisodesThatEndAsAsked) {
  Out("failures/");
  options_.gallery = true;
  options_.seeds = {1'000'000, 1'000'001, 1'000'002, 1'000'003};
  options_.outcome = Outcome::kCollision;
  ASSERT_TRUE(Run());
  ASSERT_THAT(episodes_, SizeIs(4));
  std::vector<std::string> expected;
  for (const RenderedEpisode& episode : episodes_) {
    EXPECT_EQ(episode.files.empty(), episode.outcome != Outcome::kCollision);
    if (!episode.files.empty()) expected.push_back(fmt::format("{}-collision.png", episode.seed));
  }
  EXPECT_GT(expected.size(), 0U);
  EXPECT_LT(expected.size(), 4U);
  EXPECT_EQ(Names(options_.out), expected);
}

TEST_F(RenderCommandTest, StopsWhenNobodyReads) {
  Out("failures/");
  options_.gallery = true;
  options_.seeds = {1'000'000, 1'000'001, 1'000'002};
  int lines = 0;
  ASSERT_TRUE(RunRender(options_, [&](const RenderedEpisode&) { return ++lines < 2; }));
  EXPECT_EQ(lines, 2);
}

TEST_F(RenderCommandTest, AnUnknownEndingIsRefused) {
  for (const char* name : {"episode.gif", "episode", "episode.PNG"}) {
    Out(name);
    const Status status = Run();
    ASSERT_FALSE(status) << name;
    EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(status.error().message, HasSubstr("end it in .svg (animation), .png"));
  }
  options_.gallery = true;
  Out("all.png");
  const Status status = Run();
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("does not end in /"));
}

TEST_F(RenderCommandTest, WhatCannotBeWrittenIsToldBeforeAnythingIsDriven) {
  Out("no/such/folder/episode.png");
  const Status missing = Run();
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message,
              HasSubstr("there is no folder " + (folder_ / "no/such/folder").string()));
  std::ofstream(folder_ / "file") << "not a folder";
  Out("file/frames/");
  const Status file = Run();
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().message, HasSubstr("--out: the folder"));
  options_.out = "/proc/episode.png";  // where nobody can make files
  const Status refused = Run();
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("--out: "));
  EXPECT_THAT(episodes_, SizeIs(0));
}

TEST_F(RenderCommandTest, APartBeyondTheEpisodeIsRefused) {
  Out("episode.svg");
  options_.from_s = 70.0;
  const Status late = Run();
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(late.error().message, HasSubstr("--from 70: the episode of seed 1000000 ends after"));
  options_.from_s = 1.0;
  options_.to_s = 0.5;
  const Status empty = Run();
  ASSERT_FALSE(empty);
  EXPECT_THAT(empty.error().message, HasSubstr("nothing lies between"));
  options_.to_s = 70.0;  // until it ends
  EXPECT_TRUE(Run());
}

nn::ParamLayout LayoutOf(const Config& config) {
  return MakePolicyModel(DrivingShape::From(config.observation), config.model).value()->layout();
}

TEST_F(RenderCommandTest, APolicyOfAnotherLayoutIsRefused) {
  Config trained;
  trained.observation.vehicles = 4;
  const nn::ParamLayout layout = LayoutOf(trained);
  const std::vector<float> parameters(layout.size());
  options_.policy = (folder_ / "other.policy").string();
  ASSERT_TRUE(SavePolicy(options_.policy,
                         {1, 1, ToYaml(trained, false), {{kPolicyNetwork, layout.hash() + 1, parameters}}}));
  Out("episode.png");
  const Status status = Run();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(status.error().message, HasSubstr("other.policy"));
}

TEST_F(RenderCommandTest, ALearnedPolicyBringsItsOwnObservation) {
  Config trained;
  trained.observation.vehicles = 3;
  trained.model.hidden = 32;
  const nn::ParamLayout layout = LayoutOf(trained);
  const std::vector<float> parameters(layout.size(), 0.01f);
  options_.policy = (folder_ / "three.policy").string();
  ASSERT_TRUE(SavePolicy(options_.policy,
                         {1, 500, ToYaml(trained, false), {{kPolicyNetwork, layout.hash(), parameters}}}));
  Out("frames/");
  options_.every = 100;
  ASSERT_TRUE(Run());
  const std::string frame = Content(episodes_.at(0).files.at(0));
  EXPECT_THAT(frame, HasSubstr("a policy trained for 500 updates"));
  EXPECT_THAT(frame, HasSubstr("class=\"gaze\""));
}

}  // namespace
}  // namespace dadrl
