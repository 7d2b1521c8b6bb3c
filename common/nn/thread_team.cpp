#include "common/nn/thread_team.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace dadrl::nn {
namespace {

// About a hundred microseconds: longer than the gaps inside a training step, far shorter than the wait for a
// batch.
constexpr int kSpins = 4000;

void Relax() {
#if defined(__x86_64__)
  _mm_pause();
#endif
}

void WaitWhile(const std::atomic<uint32_t>& value, uint32_t old) {
  for (int spin = 0; spin < kSpins; ++spin) {
    if (value.load(std::memory_order_acquire) != old) return;
    Relax();
  }
  while (value.load(std::memory_order_acquire) == old) value.wait(old, std::memory_order_acquire);
}

// Gradients fade into denormals, which cost a hundred times a normal operation.
class FlushDenormals {
 public:
#if defined(__x86_64__)
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040); }
  ~FlushDenormals() { _mm_setcsr(before_); }

 private:
  unsigned before_;
#else
  FlushDenormals() {}
#endif
};

}  // namespace

ThreadTeam::ThreadTeam(int threads) {
  for (int member = 1; member < threads; ++member) {
    helpers_.emplace_back([this, member] { Serve(member); });
  }
}

ThreadTeam::~ThreadTeam() {
  function_ = nullptr;
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void ThreadTeam::RunErased(Function function, void* context) {
  const FlushDenormals flush;
  function_ = function;
  context_ = context;
  if (!helpers_.empty()) {
    round_.fetch_add(1, std::memory_order_release);
    round_.notify_all();
  }
  function(context, 0);
  Barrier();
}

void ThreadTeam::Serve(int member) {
  const FlushDenormals flush;
  for (uint32_t seen = 0;;) {
    WaitWhile(round_, seen);
    ++seen;
    if (function_ == nullptr) return;
    function_(context_, member);
    Barrier();
  }
}

void ThreadTeam::Barrier() {
  const uint32_t phase = phase_.load(std::memory_order_acquire);
  if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == static_cast<uint32_t>(size())) {
    arrived_.store(0, std::memory_order_relaxed);
    phase_.fetch_add(1, std::memory_order_release);
    phase_.notify_all();
    return;
  }
  WaitWhile(phase_, phase);
}

}  // namespace dadrl::nn
