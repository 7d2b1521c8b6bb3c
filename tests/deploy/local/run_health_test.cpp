#include "deploy/local/run_health.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(RunHealth, AListOfProcessesThatCannotBeWrittenIsAFaultUntilItIs) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "disk" / "processes.json";  // there is no such folder yet
  ManualClock clock;
  FaultBoard faults(clock, FaultBoard::Logging::kOff);
  const Supervisor supervisor(RestartLimits{}, HangLimits{}, clock, [](const std::string&) {});
  RunHealth health(file, clock, faults);
  health.Step(supervisor, false);
  EXPECT_THAT(faults.Current(), ElementsAre(Field(&Fault::text, HasSubstr(file.string()))));
  EXPECT_TRUE(faults.Lasts(FaultKind::kProcesses));

  std::filesystem::create_directory(file.parent_path());
  clock.Advance(std::chrono::seconds(1));
  health.Step(supervisor, false);
  EXPECT_THAT(faults.Current(), IsEmpty());
  EXPECT_EQ(LoadSupervision(file)->launcher, getpid());
}

}  // namespace
}  // namespace dadrl
