#include "actor/collect/actor_episode_log.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <sstream>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

class ActorEpisodeLogTest : public ::testing::Test {
 protected:
  std::vector<std::string> Lines() const {
    std::ifstream file(path_);
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }
  static CollectedEpisode Episode(uint64_t number) {
    CollectedEpisode episode{.episode = number, .policy_version = 12};
    episode.summary.seed = 77;
    episode.summary.outcome = Outcome::kCollision;
    episode.summary.steps = 123;
    episode.summary.episode_return = -0.5;
    return episode;
  }

  const TemporaryFolder root_;
  const std::filesystem::path path_ = root_.path() / "logs" / "episodes-actor-3.csv";
};

TEST_F(ActorEpisodeLogTest, WritesARowForAnEpisodeUnderAHeader) {
  auto log = ActorEpisodeLog::Open(path_);
  ASSERT_TRUE(log.Append(9, 1'500'000'000, Episode(1)));
  const auto lines = Lines();
  ASSERT_EQ(lines.size(), 2);
  EXPECT_EQ(lines[1].substr(0, 33), "1.500,9,1,77,collision,123,-0.5,0");
  EXPECT_EQ(std::count(lines[0].begin(), lines[0].end(), ','),
            std::count(lines[1].begin(), lines[1].end(), ','));
}

TEST_F(ActorEpisodeLogTest, GoesOnBehindTheLastWholeRow) {
  ASSERT_TRUE(ActorEpisodeLog::Open(path_).Append(1, 0, Episode(1)));
  std::ofstream(path_, std::ios::app) << "1.000,1,2,77,coll";  // killed in the middle
  ASSERT_TRUE(ActorEpisodeLog::Open(path_).Append(2, 0, Episode(1)));
  const auto lines = Lines();
  ASSERT_EQ(lines.size(), 3);
  EXPECT_EQ(lines[1].substr(0, 12), "0.000,1,1,77");
  EXPECT_EQ(lines[2].substr(0, 12), "0.000,2,1,77");
}

TEST_F(ActorEpisodeLogTest, KnowsTheLargestNumberThatIsThere) {
  EXPECT_EQ(ActorEpisodeLog::Open(path_).last_episode(), 0u);
  ASSERT_TRUE(ActorEpisodeLog::Open(path_).Append(1, 0, Episode(7)));
  ASSERT_TRUE(ActorEpisodeLog::Open(path_).Append(2, 0, Episode(3)));  // as earlier versions did
  EXPECT_EQ(ActorEpisodeLog::Open(path_).last_episode(), 7u);
}

// A child, because the limit on the size of files is its whole process's.
TEST_F(ActorEpisodeLogTest, AFullDiskDelaysARow) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    auto log = ActorEpisodeLog::Open(path_);
    const rlimit full{std::filesystem::file_size(path_) + 10, RLIM_INFINITY};
    const rlimit free{RLIM_INFINITY, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &full);
    const bool refused = !log.Append(1, 0, Episode(1));
    setrlimit(RLIMIT_FSIZE, &free);
    _exit(refused && log.Append(1, 0, Episode(2)) ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  const auto lines = Lines();
  ASSERT_EQ(lines.size(), 3);
  EXPECT_EQ(lines[1].substr(0, 12), "0.000,1,1,77");
  EXPECT_EQ(lines[2].substr(0, 12), "0.000,1,2,77");
}

TEST_F(ActorEpisodeLogTest, AFileThatCannotBeOpenedIsNamedAndTriedAgainWithEachRow) {
  std::ofstream(root_.path() / "logs") << "a file where the folder should be";
  auto log = ActorEpisodeLog::Open(path_);
  const Status refused = log.Append(1, 0, Episode(1));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find((root_.path() / "logs").string()), std::string::npos);
  std::filesystem::remove(root_.path() / "logs");
  ASSERT_TRUE(log.Append(1, 0, Episode(2)));
  EXPECT_EQ(Lines().size(), 3) << "nothing is lost";
}

}  // namespace
}  // namespace dadrl
