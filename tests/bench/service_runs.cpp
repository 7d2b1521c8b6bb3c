#include "tests/bench/service_runs.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

#include "common/dds/node.h"
#include "tests/bench/figure.h"
#include "tests/replay/service/replay_process.h"

namespace dadrl::bench {
namespace {

constexpr const char* kBench = "replay_service";

double Median(const std::vector<Numbers>& runs, double Numbers::*which) {
  std::vector<double> values;
  for (const Numbers& run : runs) values.push_back(run.*which);
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

std::filesystem::path Disk() { return std::filesystem::temp_directory_path(); }
std::filesystem::path Memory() { return access("/dev/shm", W_OK) == 0 ? "/dev/shm" : Disk(); }

Folder::Folder(const std::filesystem::path& parent) {
  std::string name = (parent / "dadrl-bench-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot create " + name);
  path_ = name;
}

Config OnFreePort() {
  Config config;
  config.replay.min_size = 1;
  config.replay.samples_per_insert = 0.0;
  config.replay.max_disk_bytes = int64_t{1} << 30;
  config.cluster.port = dds::FindFreePort().value();
  return config;
}

Numbers WithReplay(const Traffic& traffic, const std::filesystem::path& parent) {
  const Config config = OnFreePort();
  const Folder folder(parent);
  ReplayProcess replay(folder.path(), config);
  replay.Start();
  return traffic(config);
}

Numbers WithMirror(const Traffic& traffic, uint64_t chunks, int replies_of, double reply_bytes) {
  const Config config = OnFreePort();
  const PeerProcess mirror(
      [&]() -> Numbers { Mirror(config, chunks, replies_of, static_cast<size_t>(reply_bytes)); });
  return traffic(config);
}

Numbers FeedAll(const Config& config, uint64_t chunks, bool granting) {
  return PeerProcess([&] { return Feed(config, chunks, granting); }).Wait();
}

Numbers FetchAll(const Config& config, const Fetching& fetching) {
  return PeerProcess([&] { return Fetch(config, fetching); }).Wait();
}

void SayRun(const char* part, int run) {
  fmt::print(stderr, "{} {}: run {} of {}\n", kBench, part, run + 1, kRuns);
}

Comparison Compare(const char* part, const std::function<Numbers()>& ours,
                   const std::function<Numbers(const Numbers&)>& limit) {
  Comparison runs;
  for (int run = 0; run < kRuns; ++run) {
    SayRun(part, run);
    runs.ours.push_back(ours());
    runs.limit.push_back(limit(runs.ours.back()));
  }
  return runs;
}

void PrintRate(const std::string& name, const Comparison& runs, double amount, const char* unit) {
  std::string each;
  for (size_t i = 0; i < runs.ours.size(); ++i) {
    each += fmt::format(" {:.4g}/{:.4g}", amount / runs.ours[i].seconds, amount / runs.limit[i].seconds);
  }
  fmt::print(stderr, "{}, {}, ours/limit of each run:{}\n", name, unit, each);
  PrintRate(kBench, name, amount / Median(runs.ours, &Numbers::seconds), unit,
            amount / Median(runs.limit, &Numbers::seconds));
}

void PrintWait(const std::string& name, const Comparison& runs, double Numbers::*which) {
  PrintCost(kBench, name, 1e3 * Median(runs.ours, which), "ms", 1e3 * Median(runs.limit, which));
}

}  // namespace dadrl::bench
