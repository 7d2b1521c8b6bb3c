// Runs of the service benchmark: the same traffic with the replay and with what bounds it, and their figures.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "tests/bench/peer_process.h"
#include "tests/bench/service_peers.h"

namespace dadrl::bench {

// Of both sides; figures are medians.
constexpr int kRuns = 5;

// Where the replay's files are: on the disk, or where there is none in their way.
std::filesystem::path Disk();
std::filesystem::path Memory();

// A folder with a new name, gone with the object.
class Folder {
 public:
  explicit Folder(const std::filesystem::path& parent);
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// No limiter; on its own ports each time: nothing of the run before is in the way.
Config OnFreePort();

using Traffic = std::function<Numbers(const Config&)>;
// Beside a replay with its files below `parent`.
Numbers WithReplay(const Traffic& traffic, const std::filesystem::path& parent = Memory());
// Beside the bare counterpart, see Mirror.
Numbers WithMirror(const Traffic& traffic, uint64_t chunks, int replies_of = 1, double reply_bytes = 1.0);

// Feed and Fetch, each in a process of its own.
Numbers FeedAll(const Config& config, uint64_t chunks, bool granting);
Numbers FetchAll(const Config& config, const Fetching& fetching);

// One element a run.
struct Comparison {
  std::vector<Numbers> ours;
  std::vector<Numbers> limit;
};
// In turn; the limit's run gets the numbers of ours before it. Says on standard error which run of `part`
// begins.
Comparison Compare(const char* part, const std::function<Numbers()>& ours,
                   const std::function<Numbers(const Numbers&)>& limit);
void SayRun(const char* part, int run);

// `amount` by the seconds of a run; each run goes to standard error.
void PrintRate(const std::string& name, const Comparison& runs, double amount, const char* unit);
// One of the waits.
void PrintWait(const std::string& name, const Comparison& runs, double Numbers::*which);

}  // namespace dadrl::bench
