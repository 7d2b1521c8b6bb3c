#include "replay/sequence_table.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

using Verdict = SequenceTable::Verdict;

TEST(SequenceTable, TakesEachSequenceOnceAndInOrder) {
  SequenceTable table;
  EXPECT_EQ(table.Check({1, 10, 1}, 1), Verdict::kNext);
  table.Accept({1, 10, 1});
  EXPECT_EQ(table.Check({1, 10, 1}, 1), Verdict::kDuplicate);
  EXPECT_EQ(table.Check({1, 10, 3}, 1), Verdict::kGap);
  EXPECT_EQ(table.Check({1, 10, 2}, 2), Verdict::kNext);
  EXPECT_EQ(table.Accept({1, 10, 2}), 0u);
  EXPECT_EQ(table.Stored(1, 10), 2u);
  EXPECT_EQ(table.Stored(1, 11), std::nullopt);
  EXPECT_EQ(table.Stored(2, 10), std::nullopt);
}

TEST(SequenceTable, SkipsOnlyWhatTheActorNoLongerHas) {
  SequenceTable table;
  table.Accept({1, 10, 1});
  EXPECT_EQ(table.Check({1, 10, 7}, 5), Verdict::kGap);
  EXPECT_EQ(table.Check({1, 10, 5}, 5), Verdict::kNext);
  EXPECT_EQ(table.Accept({1, 10, 5}), 3u);
  EXPECT_EQ(table.Check({1, 10, 6}, 5), Verdict::kNext);
}

TEST(SequenceTable, AnUnknownIncarnationStartsWhereItsActorDoes) {
  SequenceTable table;
  EXPECT_EQ(table.Check({1, 10, 57}, 57), Verdict::kNext);
  EXPECT_EQ(table.Check({1, 10, 58}, 57), Verdict::kGap);
  EXPECT_EQ(table.Check({1, 10, 58}, 0), Verdict::kNext);
  table.Accept({1, 10, 57});
  EXPECT_EQ(table.Check({1, 10, 60}, 0), Verdict::kGap);
  EXPECT_EQ(table.Check({1, 11, 1}, 1), Verdict::kNext);
}

TEST(SequenceTable, ForgetsTheOldestIncarnationsButNotThatTheyAreOver) {
  SequenceTable table;
  for (uint64_t incarnation = 1; incarnation <= 6; ++incarnation) table.Accept({1, incarnation, 9});
  EXPECT_EQ(table.Check({1, 1, 10}, 10), Verdict::kStale);
  EXPECT_EQ(table.Check({1, 3, 9}, 9), Verdict::kDuplicate);
  ASSERT_EQ(table.Newest().size(), 1u);
  EXPECT_EQ(table.Newest()[0].incarnation, 6u);
}

TEST(SequenceTable, TheNumberOfActorsIsBounded) {
  SequenceTable table;
  for (uint32_t actor = 0; actor < SequenceTable::kMaxActors; ++actor) table.Accept({actor, 1, 1});
  EXPECT_EQ(table.Check({SequenceTable::kMaxActors, 1, 1}, 1), Verdict::kTooMany);
  EXPECT_EQ(table.Check({5, 1, 2}, 2), Verdict::kNext);
}

TEST(SequenceTable, NoSequenceIsBeyondWhatAnActorCanSend) {
  SequenceTable table;
  constexpr uint64_t kLast = SequenceTable::kMaxSequence;
  EXPECT_EQ(table.Check({1, 10, kLast + 1}, kLast + 1), Verdict::kImpossible);
  EXPECT_EQ(table.Check({1, 10, UINT64_MAX}, UINT64_MAX), Verdict::kImpossible);
  table.Accept({1, 10, 1});
  EXPECT_EQ(table.Check({1, 10, UINT64_MAX}, UINT64_MAX), Verdict::kImpossible);
  EXPECT_EQ(table.Check({1, 10, kLast}, kLast), Verdict::kNext);
}

TEST(SequenceTable, MergeTakesTheHigherOfBoth) {
  SequenceTable left;
  SequenceTable right;
  left.Accept({1, 10, 5});
  right.Accept({1, 10, 3});
  right.Accept({1, 9, 8});
  right.Accept({2, 1, 4});
  left.Merge(right);
  EXPECT_EQ(left.Stored(1, 10), 5u);
  EXPECT_EQ(left.Stored(1, 9), 8u);
  EXPECT_EQ(left.Stored(2, 1), 4u);
}

TEST(SequenceTable, SurvivesItsBytes) {
  SequenceTable table;
  table.Accept({1, 10, 5});
  table.Accept({1, 11, 6});
  table.Accept({900, 1, 1});
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  table.Put(writer);
  ByteReader reader(bytes);
  const auto copy = SequenceTable::Get(reader);
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->Stored(1, 10), 5u);
  EXPECT_EQ(copy->Stored(1, 11), 6u);
  EXPECT_EQ(copy->Stored(900, 1), 1u);
}

TEST(SequenceTable, BytesThatNoTableWritesAreRefused) {
  const auto read = [](std::initializer_list<ChunkIdentity> rows, uint32_t count) {
    std::vector<std::byte> bytes;
    ByteWriter writer(bytes);
    writer.Put(count);
    for (const ChunkIdentity& row : rows) {
      writer.Put(row.actor);
      writer.Put(row.incarnation);
      writer.Put(row.sequence);
    }
    ByteReader reader(bytes);
    return SequenceTable::Get(reader).has_value();
  };
  EXPECT_TRUE(read({{1, 1, kMaxSequence}}, 1));
  EXPECT_FALSE(read({{1, 1, kMaxSequence + 1}}, 1));
  EXPECT_FALSE(read({{1, 1, UINT64_MAX}}, 1));
  EXPECT_FALSE(read({{1, 1, 1}}, 2)) << "cut short";
  EXPECT_FALSE(read({{1, 1, 1}}, UINT32_MAX));
  EXPECT_TRUE(read({{1, 1, 1}, {1, 2, 1}, {1, 3, 1}, {1, 4, 1}}, 4));
  EXPECT_FALSE(read({{1, 1, 1}, {1, 2, 1}, {1, 3, 1}, {1, 4, 1}, {1, 5, 1}}, 5)) << "incarnations";
}

}  // namespace
}  // namespace dadrl
