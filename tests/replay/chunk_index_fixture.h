// A chunk index over segments in memory, for its tests.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "replay/chunk_index.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {

// An index over segments in memory.
class IndexFixture {
 public:
  explicit IndexFixture(const ChunkIndex::Options& options) : index(options) { NewSegment(); }

  void NewSegment() { segments.push_back(Segment::Create({}, segments.size() + 1, 1, 1 << 24).value()); }
  void Add(const TestChunk& chunk) {
    const auto stored = segments.back()->Append(Build(chunk)).value();
    index.Add(segments.back(), ChunkView::Parse(stored).value());
  }
  SampledBatch Sample(size_t count, int n_step) {
    auto batch =
        ReadTrajectories(index.SampleItems(count, n_step, random), {static_cast<int>(count), n_step});
    EXPECT_TRUE(batch) << batch.error().message;
    return std::move(*batch);
  }

  std::vector<std::shared_ptr<Segment>> segments;
  ChunkIndex index;
  Random random{1};
};

}  // namespace dadrl
