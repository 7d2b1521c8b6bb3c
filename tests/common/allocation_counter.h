// Counts what this process takes from the heap. A test that links it is a binary of its own: it replaces
// malloc.
#pragma once

namespace dadrl::testing {

// Calls of malloc, calloc, realloc and aligned_alloc so far, of all threads.
long Allocations();

// False where a sanitizer owns malloc, so that nothing is counted.
bool CountsAllocations();

}  // namespace dadrl::testing
