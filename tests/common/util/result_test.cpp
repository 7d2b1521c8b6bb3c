#include "common/util/result.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

Result<int> Half(int value) {
  if (value % 2 != 0) return Fail(ErrorCode::kInvalidArgument, "{} is odd; give an even number", value);
  return value / 2;
}

Result<int> Quarter(int value) {
  DADRL_ASSIGN_OR_RETURN(const int half, Half(value));
  return Half(half);
}

Status CheckQuarter(int value) {
  DADRL_RETURN_IF_ERROR(Quarter(value).map([](int) {}));
  return {};
}

TEST(Result, PassesValuesAndErrorsThrough) {
  EXPECT_EQ(*Quarter(8), 2);
  EXPECT_TRUE(CheckQuarter(8));
  EXPECT_EQ(Quarter(6).error().message, "3 is odd; give an even number");
  EXPECT_EQ(CheckQuarter(6).error().code, ErrorCode::kInvalidArgument);
}

TEST(Result, WrongUsageExitsWithTwoAndTheRestWithOne) {
  EXPECT_EQ(ExitCode({ErrorCode::kInvalidArgument, ""}), 2);
  EXPECT_EQ(ExitCode({ErrorCode::kCorrupt, ""}), 1);
  EXPECT_EQ(ExitCode({ErrorCode::kUnavailable, ""}), 1);
}

}  // namespace
}  // namespace dadrl
