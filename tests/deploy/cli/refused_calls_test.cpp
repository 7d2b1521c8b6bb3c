// A host that refuses what supervision would rather have: things work, and `doctor` says what is missing.
#include <gmock/gmock.h>

#include "tests/deploy/cli/run_command.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

CommandOutput Sandboxed(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {DADRL_BINARY_DIR "/tests/refuse_calls", DadrlProgram()});
  return RunCommand(std::move(arguments), 100);
}

TEST(RefusedCalls, DoctorNamesThemAndWhatFollows) {
  const CommandOutput output = Sandboxed({"doctor"});
  if (output.exit_code == 77) GTEST_SKIP() << "no seccomp";
  EXPECT_THAT(output.out, HasSubstr("refused: memfd_create (files in /dev/shm or TMPDIR stand in)"));
  EXPECT_THAT(output.out, HasSubstr("pidfd_open"));
  EXPECT_THAT(output.out, HasSubstr("signalfd"));
}

TEST(RefusedCalls, AnEvaluationRunsWithoutThem) {
  const CommandOutput output = Sandboxed(
      {"evaluate", "--policy", "idm", "--scenario", "left_turn", "--episodes", "2", "--seeds", "1"});
  if (output.exit_code == 77) GTEST_SKIP() << "no seccomp";
  EXPECT_EQ(output.exit_code, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("2 episodes"));
}

}  // namespace
}  // namespace dadrl
