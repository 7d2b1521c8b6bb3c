#include "deploy/local/fault_history.h"

#include <gmock/gmock.h>

namespace dadrl {
namespace {

using std::chrono::seconds;
using testing::ElementsAre;
using testing::IsEmpty;
constexpr TimePoint kStart{};

const ProcessFault kFull{"replay-0", {FaultKind::kExperience, "the disk is full", 1.0}};
const ProcessFault kNoCurves{"learner", {FaultKind::kTrainingLog, "the disk is full", 1.0}};

TEST(FaultHistory, SaysOnceThatAFaultBeganAndOnceThatItIsOver) {
  FaultHistory history;
  EXPECT_THAT(history.Update({kFull}, kStart),
              ElementsAre("fault of replay-0: the disk is full; actors keep their experience until it can be "
                          "stored, sampling goes on"));
  for (int i = 1; i <= 10; ++i) EXPECT_THAT(history.Update({kFull}, kStart + seconds(i)), IsEmpty());
  EXPECT_THAT(history.Update({}, kStart + seconds(11)), IsEmpty()) << "its process may only have died";
  EXPECT_THAT(history.Update({}, kStart + seconds(16)),
              ElementsAre("replay-0: experience can be stored again, after 10 s"));
  EXPECT_THAT(history.Update({}, kStart + seconds(30)), IsEmpty());
  EXPECT_THAT(history.Update({kFull}, kStart + seconds(40)), testing::SizeIs(1)) << "another one";
}

TEST(FaultHistory, AProcessThatComesBackWithItsFaultIsNotNewsAgain) {
  FaultHistory history;
  history.Update({kFull}, kStart);
  history.Update({}, kStart + seconds(1));
  EXPECT_THAT(history.Update({kFull}, kStart + seconds(4)), IsEmpty());
  EXPECT_EQ(history.Summary(), "replay-0 experience 4 s");
}

TEST(FaultHistory, SumsUpAtTheEnd) {
  FaultHistory history;
  EXPECT_EQ(history.Summary(), "");
  history.Update({kFull, kNoCurves}, kStart);
  history.Update({kFull, kNoCurves}, kStart + seconds(3));
  history.Update({kFull}, kStart + seconds(20));
  EXPECT_EQ(history.Summary(), "learner training_log 3 s, replay-0 experience 20 s");
}

}  // namespace
}  // namespace dadrl
