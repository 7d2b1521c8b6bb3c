// A fixed set of threads that run the same function together: the training step's parallelism.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace dadrl::nn {

// One thread owns the team and calls Run; it takes part as member 0. Between runs the others spin briefly,
// then sleep in the kernel. Every member works with denormals flushed to zero (Run restores the caller's
// setting).
class ThreadTeam {
 public:
  explicit ThreadTeam(int threads);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  int size() const { return std::ssize(helpers_) + 1; }

  // Calls work(member) once on every member, 0 to size() - 1, and returns when all have. Allocates nothing.
  // `work` must not throw.
  template <typename Work>
  void Run(Work& work) {
    RunErased([](void* context, int member) { (*static_cast<Work*>(context))(member); }, &work);
  }

  // Inside Run, by every member: returns when all have arrived; what they wrote before is visible after.
  void Barrier();

 private:
  using Function = void (*)(void* context, int member);
  void RunErased(Function function, void* context);
  void Serve(int member);

  Function function_ = nullptr;
  void* context_ = nullptr;
  std::atomic<uint32_t> round_{0};  // a new value starts a run, or ends the team when function_ is null
  std::atomic<uint32_t> arrived_{0};
  std::atomic<uint32_t> phase_{0};
  std::vector<std::thread> helpers_;
};

}  // namespace dadrl::nn
