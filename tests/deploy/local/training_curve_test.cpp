#include "deploy/local/training_curve.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

class TrainingCurveTest : public testing::Test {
 protected:
  TrainedSoFar After(const std::string& text) const {
    std::ofstream(file_) << text;
    return LastOfTraining(file_);
  }

  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "training.csv";
};

constexpr const char* kHeader = "wall_time_s,updates,critic_loss,weights_version\n";

TEST_F(TrainingCurveTest, TellsTheLastWholeRow) {
  const std::string header = kHeader;
  const TrainedSoFar two = After(header + "1.5,100,0.5,7\n2.5,250,,12\n");
  EXPECT_EQ(two.updates, 250u);
  EXPECT_EQ(two.weights_version, 12u);
  const TrainedSoFar half = After(header + "1.5,100,0.5,7\n2.5,25");
  EXPECT_EQ(half.updates, 100u);
  std::string many = header;
  for (int i = 1; i <= 1000; ++i) many += fmt::format("{}.5,{},0.25,{}\n", i, 10 * i, i);
  EXPECT_EQ(After(many).updates, 10'000u);
}

TEST_F(TrainingCurveTest, TellsNothingOfNoRow) {
  EXPECT_EQ(LastOfTraining(folder_.path() / "missing.csv").updates, 0u);
  for (const char* text : {"", kHeader, "no such column\n1,2,3\n", "\n\n\n", "updates\nmany\n"}) {
    EXPECT_EQ(After(text).updates, 0u) << text;
  }
}

}  // namespace
}  // namespace dadrl
