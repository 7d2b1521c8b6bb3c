#include "common/util/fault.h"

#include <gmock/gmock.h>

#include <set>

namespace dadrl {
namespace {

const Status kFull = Fail(ErrorCode::kExhausted, "the disk is full");

TEST(FaultBoard, AFaultLastsFromItsFirstFailureToTheNextSuccess) {
  ManualClock clock;
  FaultBoard board(clock);
  EXPECT_THAT(board.Current(), testing::IsEmpty());
  board.Report(FaultKind::kCheckpoint, kFull);
  clock.Advance(std::chrono::seconds(3));
  board.Report(FaultKind::kCheckpoint, Fail(ErrorCode::kInternal, "something else"));
  EXPECT_THAT(board.Current(), testing::ElementsAre(Fault{FaultKind::kCheckpoint, "the disk is full", 3.0}));
  EXPECT_TRUE(board.Lasts(FaultKind::kCheckpoint));
  board.Report(FaultKind::kCheckpoint, {});
  EXPECT_THAT(board.Current(), testing::IsEmpty());
  EXPECT_FALSE(board.Lasts(FaultKind::kCheckpoint));
}

TEST(FaultBoard, SuccessOfOneEndsNoOther) {
  ManualClock clock;
  FaultBoard board(clock);
  board.Report(FaultKind::kState, kFull);
  board.Report(FaultKind::kExperience, kFull);
  board.Report(FaultKind::kState, {});
  ASSERT_EQ(board.Current().size(), 1u);
  EXPECT_EQ(board.Current().front().kind, FaultKind::kExperience);
}

TEST(FaultBoard, TellsItsFollowerWhatHoldsUpTraining) {
  ManualClock clock;
  FaultBoard board(clock, FaultBoard::Logging::kOff);
  std::vector<std::string> told;
  board.Follow([&](std::string_view what) { told.emplace_back(what); });
  board.Report(FaultKind::kTrainingLog, kFull);
  EXPECT_THAT(told, testing::IsEmpty()) << "training goes on without it";
  board.Report(FaultKind::kWeights, kFull);
  board.Report(FaultKind::kWeights, kFull);
  board.Report(FaultKind::kWeights, {});
  EXPECT_THAT(told, testing::ElementsAre("the disk is full", ""));
}

TEST(FaultKind, EachHasANameOfItsOwnAndAMeaning) {
  std::set<std::string_view> names;
  for (int i = 0; i < static_cast<int>(FaultKind::kCount); ++i) {
    names.insert(FaultName(static_cast<FaultKind>(i)));
    EXPECT_FALSE(FaultMeaning(static_cast<FaultKind>(i)).empty());
  }
  EXPECT_EQ(names.size(), static_cast<size_t>(FaultKind::kCount));
  EXPECT_TRUE(HoldsUpTraining(FaultKind::kExperience));
  EXPECT_FALSE(HoldsUpTraining(FaultKind::kTrainingLog));
}

}  // namespace
}  // namespace dadrl
