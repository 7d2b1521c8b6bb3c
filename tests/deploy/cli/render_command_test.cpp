// `dadrl render` as a user calls it.
#include <gmock/gmock.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/deploy/cli/run_command.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(RenderCommand, DrawsAnEpisodeAndSaysWhatItDrew) {
  const TemporaryFolder folder;
  const std::string out = folder.path() / "episode.png";
  const CommandOutput output = Dadrl(
      {"render", "--policy", "rdm", "--scenario", "left_turn", "--seed", "1000001", "--out", out, "--json"});
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const auto json = nlohmann::json::parse(output.out);
  EXPECT_EQ(json.at("scenario"), "left_turn");
  EXPECT_EQ(json.at("policy"), "rdm");
  EXPECT_EQ(json.at("seed"), 1'000'001);
  EXPECT_THAT(json.at("outcome").get<std::string>(), testing::AnyOf("success", "collision"));
  EXPECT_GT(json.at("steps").get<int>(), 10);
  EXPECT_TRUE(json.at("return").is_number());
  EXPECT_EQ(json.at("files"), nlohmann::json::array({out}));
  EXPECT_EQ(FileText(out).substr(1, 3), "PNG");
}

TEST(RenderCommand, TheSameSeedIsTheSameFile) {
  const TemporaryFolder folder;
  std::vector<std::string> pictures;
  for (const char* name : {"one.svg", "two.svg"}) {
    const std::string out = folder.path() / name;
    const CommandOutput output = Dadrl({"render", "--policy", "predictive", "--scenario", "double_merge",
                                        "--seed", "1000002", "--out", out});
    ASSERT_EQ(output.exit_code, 0) << output.err;
    EXPECT_THAT(output.out, HasSubstr(out));
    pictures.push_back(FileText(out));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_GT(pictures[0].size(), 10'000U);
}

TEST(RenderCommand, AGalleryReportsEachEpisodeItDrew) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "failures").string() + '/';
  const CommandOutput output = Dadrl({"render", "--policy", "rdm", "--scenario", "left_turn", "--seeds",
                                      "1000000:4", "--outcome", "collision", "--out", out, "--json"});
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const auto json = nlohmann::json::parse(output.out);
  EXPECT_EQ(json.at("driven"), 4);
  ASSERT_FALSE(json.at("episodes").empty());
  for (const auto& episode : json.at("episodes")) {
    EXPECT_EQ(episode.at("outcome"), "collision");
    EXPECT_TRUE(std::filesystem::exists(episode.at("files").at(0).get<std::string>()));
  }
}

}  // namespace
}  // namespace dadrl
