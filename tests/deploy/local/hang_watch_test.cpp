#include "deploy/local/hang_watch.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <optional>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::Optional;

constexpr Duration kTick = 200ms;
constexpr pid_t kMain = 100;
constexpr pid_t kWorker = 101;
constexpr pid_t kHelper = 102;

// What a thread does for a while.
struct Doing {
  char state = 'S';
  double runs = 0.0;   // part of its time on a core
  double waits = 0.0;  // part of its time waiting for one
};

// A process of three threads, one of which beats, on a clock of its own.
class HangWatchTest : public testing::Test {
 protected:
  // The worker is silent for `duration` while the threads do this. The first verdict.
  std::optional<std::string> Silent(Duration duration, Doing worker, Doing helper = {}, Doing main = {}) {
    for (Duration passed{}; passed < duration; passed += kTick) {
      if (const auto verdict = Tick(kTick, worker, helper, main)) return verdict;
    }
    return std::nullopt;
  }

  std::optional<std::string> Tick(Duration interval, Doing worker, Doing helper = {}, Doing main = {}) {
    clock_.Advance(interval);
    Pass(times_[0], main, interval);
    Pass(times_[1], worker, interval);
    Pass(times_[2], helper, interval);
    return watch_.Look(clock_.Now(), threads_, [this] { return times_; });
  }

  static void Pass(ThreadTimes& thread, const Doing& doing, Duration interval) {
    thread.state = doing.state;
    thread.ran += FromSeconds(doing.runs * ToSeconds(interval));
    thread.waited += FromSeconds(doing.waits * ToSeconds(interval));
  }

  void Beat() {
    ++threads_[0].beats;
    EXPECT_FALSE(Tick(kTick, {}));
  }

  ManualClock clock_;
  std::vector<ThreadTimes> times_{{.id = kMain}, {.id = kWorker}, {.id = kHelper}};
  std::vector<BeatPage::Thread> threads_{{.id = kWorker, .name = "train", .beats = 1}};
  HangWatch watch_{HangLimits{}, clock_.Now()};
};

TEST_F(HangWatchTest, AThreadThatSleepsWithoutABeatHangs) {
  Beat();
  EXPECT_FALSE(Silent(5s, {}));
  EXPECT_THAT(Silent(3s, {}), Optional(HasSubstr("its thread 'train' has been silent for 5 s")));
}

TEST_F(HangWatchTest, ABeatBeginsTheCountAnew) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(Silent(4s, {}));
    Beat();
  }
}

TEST_F(HangWatchTest, AStoppedProcessIsFoundWhateverItsThreadsWereAt) {
  threads_[0].limit = 10min;
  EXPECT_FALSE(Silent(3s, {'T'}, {'T'}, {'T'}));
  EXPECT_THAT(watch_.Suspicion(), HasSubstr("stopped by a signal"));
  EXPECT_EQ(Silent(5s, {'T'}, {'T'}, {'T'}), "it is stopped by a signal");
}

TEST_F(HangWatchTest, AProcessThatIsContinuedInTimeIsForgiven) {
  EXPECT_FALSE(Silent(5s, {'T'}, {'T'}, {'T'}));
  Beat();
  EXPECT_EQ(watch_.Suspicion(), "");
  EXPECT_FALSE(Silent(5s, {'T'}, {'T'}, {'T'}));
}

TEST_F(HangWatchTest, StarvedIsNotHung) {
  EXPECT_FALSE(Silent(10min, {'R', 0.05, 0.95}));
  // The kernel counts a wait when it is over.
  EXPECT_FALSE(Silent(10min, {'R', 0.0, 0.0}));
  // It waits for another thread, which starves.
  EXPECT_FALSE(Silent(10min, {'S'}, {'R', 0.05, 0.0}));
  EXPECT_EQ(watch_.Suspicion(), "");
}

TEST_F(HangWatchTest, ABusyHelperDoesNotHideADeadlock) {
  EXPECT_THAT(Silent(8s, {'S'}, {'R', 1.0, 0.0}), Optional(HasSubstr("'train'")));
}

TEST_F(HangWatchTest, ADeadlockOnABusyMachineIsFoundLater) {
  EXPECT_THAT(Silent(20s, {'S'}, {'S', 0.05, 0.5}), Optional(HasSubstr("'train'")));
}

TEST_F(HangWatchTest, WaitingForADeviceOrForADebuggerIsNotHanging) {
  EXPECT_FALSE(Silent(10min, {'D'}));
  EXPECT_FALSE(Silent(10min, {'S'}, {'D'}));
  EXPECT_FALSE(Silent(10min, {'t'}, {'t'}, {'t'}));
}

TEST_F(HangWatchTest, ComputingWithoutEndIsFoundAfterALongTime) {
  EXPECT_FALSE(Silent(58s, {'R', 1.0}));
  EXPECT_THAT(Silent(5s, {'R', 1.0}), Optional(HasSubstr("has computed for 60 s")));
}

TEST_F(HangWatchTest, DeclaredLongWorkMayTakeItsTimeAndNoMore) {
  threads_[0].limit = 1min;
  EXPECT_FALSE(Silent(59s, {}));
  EXPECT_TRUE(Silent(4s, {}));
}

TEST_F(HangWatchTest, AThreadThatWaitsForItsTurnIsNotToBlame) {
  threads_[0].resting = true;
  EXPECT_FALSE(Silent(10min, {}));
  threads_.push_back({.id = kHelper, .name = "serve", .beats = 1});
  EXPECT_THAT(Silent(8s, {}), Optional(HasSubstr("'serve'")));
}

TEST_F(HangWatchTest, TimeInWhichNobodyLookedDoesNotCount) {
  // Stopped together with us (Ctrl-Z), or the machine slept.
  EXPECT_FALSE(Silent(2s, {}));
  EXPECT_FALSE(Tick(10h, {}));
  EXPECT_FALSE(Tick(10h, {'T'}, {'T'}, {'T'}));
  Beat();
  EXPECT_FALSE(Silent(4s, {}));
}

TEST_F(HangWatchTest, AProcessMayTakeItsTimeToBeginButNotForEver) {
  threads_.clear();
  EXPECT_FALSE(Silent(59s, {}));
  EXPECT_FALSE(watch_.begun());
  EXPECT_THAT(Silent(4s, {}), Optional(HasSubstr("no thread of it has worked for 60 s")));
}

TEST_F(HangWatchTest, SaysWhatIsSuspiciousBeforeItActs) {
  EXPECT_FALSE(Silent(2s, {}));
  EXPECT_EQ(watch_.Suspicion(), "");
  EXPECT_FALSE(Silent(2s, {}));
  EXPECT_THAT(watch_.Suspicion(), HasSubstr("its thread 'train'"));
}

TEST(HangLimits, AreAFewTimesTheLiveliness) {
  ClusterConfig cluster;
  cluster.liveliness_s = 2.0;
  EXPECT_EQ(HangLimits::Of(cluster).silent, 10s);
  cluster.liveliness_s = 0.1;
  EXPECT_EQ(HangLimits::Of(cluster).silent, 1s);
}

TEST(ReadThreadTimes, ReadsThisProcess) {
  const std::vector<ThreadTimes> times = ReadThreadTimes(getpid());
  ASSERT_FALSE(times.empty());
  EXPECT_EQ(times.front().id, getpid());
  EXPECT_EQ(times.front().state, 'R');
}

TEST(ReadThreadTimes, TakesWhatIsThere) {
  const TemporaryFolder folder;
  const auto task = folder.path() / "7" / "task";
  std::filesystem::create_directories(task / "9");
  std::filesystem::create_directories(task / "7");
  std::filesystem::create_directories(task / "8");
  std::ofstream(task / "7" / "stat") << "7 (a (odd) name) S 1 7 7 0";
  std::ofstream(task / "7" / "schedstat") << "1500000000 20 3";
  std::ofstream(task / "9" / "stat") << "9 (x) T 1";  // a kernel without schedstat; thread 8 has just gone
  const std::vector<ThreadTimes> times = ReadThreadTimes(7, folder.path());
  ASSERT_EQ(times.size(), 2u);
  EXPECT_EQ(times[0].id, 7);
  EXPECT_EQ(times[0].state, 'S');
  EXPECT_EQ(times[0].ran, 1500ms);
  EXPECT_EQ(times[0].waited, 20ns);
  EXPECT_EQ(times[1].state, 'T');
  EXPECT_TRUE(ReadThreadTimes(8, folder.path()).empty());
}

}  // namespace
}  // namespace dadrl
