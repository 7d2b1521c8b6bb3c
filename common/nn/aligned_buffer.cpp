#include "common/nn/aligned_buffer.h"

#include <sys/mman.h>

#include <cstdlib>
#include <cstring>
#include <new>

namespace dadrl::nn {
namespace {

constexpr size_t kHugePage = size_t{2} << 20;

}  // namespace

FloatBuffer::FloatBuffer(size_t count) : size_(count) {
  if (count == 0) return;
  const size_t alignment = count * sizeof(float) >= kHugePage ? kHugePage : kAlignment;
  const size_t bytes = RoundUp(count * sizeof(float), alignment);
  void* memory = std::aligned_alloc(alignment, bytes);
  if (memory == nullptr) throw std::bad_alloc();
  // Advice only: without huge pages everything works, with more misses in the page tables.
  if (alignment == kHugePage) (void)madvise(memory, bytes, MADV_HUGEPAGE);
  std::memset(memory, 0, bytes);
  data_.reset(static_cast<float*>(memory));
}

void FloatBuffer::Release::operator()(float* memory) const { std::free(memory); }

float* Arena::Take(size_t count) {
  const size_t start = used_;
  used_ += RoundUp(count, kAlignedFloats);
  if (capacity_ == 0) return nullptr;
  if (used_ > capacity_) std::abort();
  return buffer_.data() + start;
}

}  // namespace dadrl::nn
