#include "replay/storage/state_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "common/io/read_file.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

TEST(StateFile, ComesBackAsItWasWritten) {
  TemporaryFolder folder;
  ReplayState state{.schema = 5, .up_to_segment = 7, .limiter = {10, 20, 1.5, 2.5}, .sequences = {}};
  state.sequences.Accept({3, 4, 5});
  const auto file = folder.path() / "state";
  ASSERT_TRUE(WriteReplayState(file, state));
  const auto read = ReadReplayState(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->schema, 5u);
  EXPECT_EQ(read->up_to_segment, 7u);
  EXPECT_EQ(read->limiter.inserted, 10);
  EXPECT_EQ(read->limiter.sampled, 20);
  EXPECT_EQ(read->limiter.sample_credit, 1.5);
  EXPECT_EQ(read->limiter.insert_debt, 2.5);
  EXPECT_EQ(read->sequences.Stored(3, 4), 5u);
}

TEST(StateFile, DamageAndAbsenceAreToldApart) {
  TemporaryFolder folder;
  const auto file = folder.path() / "state";
  EXPECT_EQ(ReadReplayState(file).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(WriteReplayState(file, {}));
  const auto good = ReadTextFile(file, 1 << 20).value();
  for (size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 1);
    std::ofstream(file, std::ios::trunc) << bad;
    EXPECT_EQ(ReadReplayState(file).error().code, ErrorCode::kCorrupt);
    std::ofstream(file, std::ios::trunc) << good.substr(0, i);
    EXPECT_EQ(ReadReplayState(file).error().code, ErrorCode::kCorrupt);
  }
}

}  // namespace
}  // namespace dadrl
