// One end of a measured connection, as a process of its own.
#pragma once

#include <functional>
#include <vector>

namespace dadrl::bench {

// What one run of a peer measured, seconds and bytes.
struct Numbers {
  double seconds = 0.0;  // for all of it
  double bytes = 0.0;    // of a batch, the mean
  double p50_s = 0.0;    // of the single waits for an answer
  double p99_s = 0.0;
  double largest_s = 0.0;
};

// A forked process that runs `work` and hands back the numbers it returns. Create it before this process uses
// DDS: Cyclone does not survive a fork.
class PeerProcess {
 public:
  explicit PeerProcess(const std::function<Numbers()>& work);
  // Kills it when it still runs.
  ~PeerProcess();
  PeerProcess(const PeerProcess&) = delete;
  PeerProcess& operator=(const PeerProcess&) = delete;
  // Waits for it to end; throws when it failed.
  Numbers Wait();

 private:
  int pid_;
  int results_;
};

}  // namespace dadrl::bench
