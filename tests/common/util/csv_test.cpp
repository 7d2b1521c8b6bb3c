#include "common/util/csv.h"

#include <gmock/gmock.h>

#include <limits>

namespace dadrl {
namespace {

using ::testing::ElementsAre;

TEST(Csv, QuotesACellWhereItHasTo) {
  EXPECT_EQ(CsvCell("left turn"), "left turn");
  EXPECT_EQ(CsvCell("a,b"), "\"a,b\"");
  EXPECT_EQ(CsvCell("say \"a\""), "\"say \"\"a\"\"\"");
  EXPECT_EQ(CsvCell("two\r\nlines"), "\"two  lines\"");
}

TEST(Csv, KeepsTheMillisecondsOfATimeStamp) {
  EXPECT_EQ(CsvCell(2.5), "2.5");
  EXPECT_EQ(CsvCell(1.0 / 3.0), "0.333333333");
  EXPECT_EQ(CsvCell(1795812345.123), "1795812345.123");
  EXPECT_EQ(CsvCell(-12345678.0), "-12345678");
}

TEST(Csv, LeavesTheCellOfANumberThatIsNoneEmpty) {
  EXPECT_EQ(CsvCell(std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_EQ(CsvCell(std::numeric_limits<double>::infinity()), "");
}

TEST(Csv, SplitsARowOutsideOfQuotes) {
  EXPECT_THAT(CsvCells("1,,3"), ElementsAre("1", "", "3"));
  EXPECT_THAT(CsvCells(""), ElementsAre(""));
  const std::string row = "1," + CsvCell("a,\"b\",c") + ",2";
  EXPECT_THAT(CsvCells(row), ElementsAre("1", "\"a,\"\"b\"\",c\"", "2"));
  EXPECT_THAT(CsvCells("1,\"open,2"), ElementsAre("1", "\"open,2"));
}

}  // namespace
}  // namespace dadrl
