#include "deploy/local/captured_process.h"

#include <gmock/gmock.h>
#include <poll.h>

namespace dadrl {
namespace {

using ::testing::ElementsAre;

CapturedProcess RunShell(const std::string& script) {
  auto process = CapturedProcess::Spawn({"sh", "-c", script});
  EXPECT_TRUE(process) << process.error().message;
  pollfd fd{.fd = process->child().pidfd(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(poll(&fd, 1, 60'000), 1);
  EXPECT_TRUE(process->child().TryWait());
  return std::move(*process);
}

TEST(CapturedProcess, KeepsOutputAndLogApart) {
  const CapturedProcess process = RunShell("echo one; echo two; printf half; echo wrong >&2");
  EXPECT_EQ(process.Output(), "one\ntwo\nhalf");
  EXPECT_THAT(process.OutputLines(), ElementsAre("one", "two"));
  EXPECT_EQ(process.OutputLineCount(), 2);
  EXPECT_THAT(process.LogEnd(5), ElementsAre("wrong"));
}

TEST(CapturedProcess, TakesTheStampOffTheLastMessage) {
  EXPECT_EQ(RunShell("echo '12:00:00.000 E render: no such policy' >&2").LastMessage(), "no such policy");
  EXPECT_EQ(RunShell("echo 'plain words' >&2").LastMessage(), "plain words");
  EXPECT_EQ(RunShell("true").LastMessage(), "");
}

TEST(CapturedProcess, AProgramThatIsNotThereIsAnError) {
  const auto process = CapturedProcess::Spawn({"/no/such/program"});
  ASSERT_FALSE(process);
  EXPECT_EQ(process.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace dadrl
