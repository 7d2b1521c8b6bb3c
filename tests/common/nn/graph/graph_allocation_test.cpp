// A pass through a graph must not touch the heap.
#include "tests/common/allocation_counter.h"
#include "tests/common/nn/graph/graph_cases.h"

namespace dadrl::nn {
namespace {

using testing::Allocations;

TEST(GraphAllocationTest, NoPassAllocates) {
  if (!testing::CountsAllocations()) GTEST_SKIP() << "the sanitizer owns malloc";
  for (const GraphCase& c : GraphCases()) {
    CaseUnderTest test(c);
    const long before = Allocations();
    test.Forward();
    test.Backward();
    EXPECT_EQ(Allocations(), before) << c.name;
  }
}

}  // namespace
}  // namespace dadrl::nn
