// The replay as a process, fed and emptied by others over DDS on loopback.
//
// Its files are in memory (/dev/shm), so that it is the service that is measured; one case shows what a disk
// makes of it, beside a plain file of the same bytes on the same disk.
//
// Prints JSON lines, each the median of kRuns; with an argument (inserts, disk, samples, latencies,
// snapshots) only that part. The limit is the same traffic in the same run without a replay: one process
// writes the same bytes under the same QoS, another takes and drops them. For latencies it is the bare peer
// answering while it is flooded with chunks in the same way.
#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/dds/node.h"
#include "common/util/clock.h"
#include "common/util/log.h"
#include "tests/bench/chunk_stream.h"
#include "tests/bench/service_peers.h"
#include "tests/replay/service/replay_process.h"

namespace dadrl::bench {
namespace {

constexpr int kRuns = 5;
constexpr uint64_t kChunks = 30000;
constexpr int kBatches = 6000;
constexpr int kOutstanding = 16;    // the most that learner.credits allows
constexpr int kAnswers = 1500;      // of the latency
constexpr uint64_t kStored = 3000;  // chunks to sample from

using Numbers = std::vector<double>;

Config BenchConfig() {
  Config config;
  config.replay.min_size = 1;
  config.replay.samples_per_insert = 0.0;
  config.replay.max_disk_bytes = int64_t{1} << 30;
  return config;
}

// On its own ports each time: nothing of the run before is in the way.
Config OnFreePort() {
  Config config = BenchConfig();
  const auto port = dds::FindFreePort();
  config.cluster.port = port ? *port : 0;
  return config;
}

// Gone with the object.
class Folder {
 public:
  explicit Folder(const std::filesystem::path& parent) {
    std::string name = (parent / "dadrl-bench-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::filesystem::path Disk() { return std::filesystem::temp_directory_path(); }
std::filesystem::path Memory() { return access("/dev/shm", W_OK) == 0 ? "/dev/shm" : Disk(); }

Numbers Bare(const std::function<Numbers(const Config&)>& traffic, int replies_of, size_t reply_bytes) {
  const Config config = OnFreePort();
  const Peer mirror([&] {
    Mirror(config, kChunks, replies_of, reply_bytes);
    return Numbers{};
  });
  return traffic(config);
}

Numbers WithReplay(const std::function<Numbers(const Config&)>& traffic,
                   const std::filesystem::path& parent = Memory()) {
  const Config config = OnFreePort();
  const Folder folder(parent);
  ReplayProcess replay(folder.path(), config);
  replay.Start();
  return traffic(config);
}

// Writes the chunks to one file on the disk and forces them there.
Numbers WriteFile() {
  const Folder folder(Disk());
  ChunkStream stream(ObservationSpec{});
  const SystemClock clock;
  const TimePoint begin = clock.Now();
  const int file = open((folder.path() / "chunks").c_str(), O_WRONLY | O_CREAT, 0600);
  for (uint64_t i = 1; i <= kChunks; ++i) {
    const auto chunk = stream.At(i);
    if (write(file, chunk.data(), chunk.size()) != static_cast<ssize_t>(chunk.size())) std::abort();
  }
  fsync(file);
  close(file);
  return {ToSeconds(clock.Now() - begin)};
}

Numbers FeedAll(const Config& config, bool granting) {
  return Peer([&] { return Feed(config, kChunks, granting); }).Wait();
}

Numbers FetchAll(const Config& config, const Fetching& fetching) {
  return Peer([&] { return Fetch(config, fetching); }).Wait();
}

Numbers FetchStored(const Config& config, const Fetching& fetching) {
  Peer([&] { return Feed(config, kStored, true); }).Wait();
  return FetchAll(config, fetching);
}

Numbers FetchUnderFlood(const Config& config, bool granting) {
  const Peer flood([&] {
    granting ? FeedForEver(config) : static_cast<void>(Feed(config, UINT64_MAX, false));
    return Numbers{};
  });
  return FetchAll(config, {.batches = kAnswers});
}

// The numbers of several runs, one vector a run; the median of one of them.
double Median(const std::vector<Numbers>& runs, size_t which) {
  Numbers values;
  for (const Numbers& run : runs) values.push_back(run.at(which));
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void Print(const std::string& name, double value, const char* unit, double limit, double of_limit) {
  fmt::print(R"({{"bench": "replay_service", "case": "{}", "value": {:.4g}, "unit": "{}", "limit": {:.4g}, )"
             R"("of_limit": {:.3f}}})"
             "\n",
             name, value, unit, limit, of_limit);
  std::fflush(stdout);
}

void PrintSpread(const char* name, const std::vector<Numbers>& bare, const std::vector<Numbers>& ours,
                 size_t which, double amount) {
  std::string line;
  for (size_t i = 0; i < ours.size(); ++i) {
    line += fmt::format(" {:.4g}/{:.4g}", amount / ours[i].at(which), amount / bare[i].at(which));
  }
  fmt::print(stderr, "{}, ours/bare of each run:{}\n", name, line);
}

void Inserts() {
  std::vector<Numbers> bare;
  std::vector<Numbers> ours;
  for (int run = 0; run < kRuns; ++run) {
    bare.push_back(Bare([](const Config& config) { return FeedAll(config, false); }, 1, 1));
    ours.push_back(WithReplay([](const Config& config) { return FeedAll(config, true); }));
  }
  constexpr double kFrames = static_cast<double>(kChunks) * ChunkStream::kFrames;
  const double limit = kFrames / Median(bare, 0);
  const double value = kFrames / Median(ours, 0);
  PrintSpread("frames inserted/s", bare, ours, 0, kFrames);
  Print("inserted frames", value, "frames/s", limit, value / limit);
}

void InsertsToDisk() {
  std::vector<Numbers> bare;
  std::vector<Numbers> ours;
  for (int run = 0; run < kRuns; ++run) {
    bare.push_back(WriteFile());
    ours.push_back(WithReplay([](const Config& config) { return FeedAll(config, true); }, Disk()));
  }
  constexpr double kFrames = static_cast<double>(kChunks) * ChunkStream::kFrames;
  const double limit = kFrames / Median(bare, 0);
  const double value = kFrames / Median(ours, 0);
  PrintSpread("frames inserted/s on disk", bare, ours, 0, kFrames);
  Print("inserted frames, on disk, forced every second", value, "frames/s", limit, value / limit);
}

void Samples() {
  std::vector<Numbers> bare;
  std::vector<Numbers> ours;
  for (int run = 0; run < kRuns; ++run) {
    ours.push_back(WithReplay([](const Config& config) {
      return FetchStored(config, {.batches = kBatches, .outstanding = kOutstanding});
    }));
    const auto bytes = static_cast<size_t>(ours.back().at(1));
    bare.push_back(Bare(
        [](const Config& config) { return FetchAll(config, {.batches = kBatches, .replies_of = kBatches}); },
        kBatches, bytes));
  }
  const double limit = kBatches / Median(bare, 0);
  const double value = kBatches / Median(ours, 0);
  PrintSpread("batches sampled/s", bare, ours, 0, kBatches);
  Print("sampled batches of 256, 3 steps", value, "batches/s", limit, value / limit);
}

void Latencies() {
  std::vector<Numbers> bare;
  std::vector<Numbers> ours;
  for (int run = 0; run < kRuns; ++run) {
    ours.push_back(WithReplay([](const Config& config) { return FetchUnderFlood(config, true); }));
    const auto bytes = static_cast<size_t>(ours.back().at(1));
    bare.push_back(Bare([](const Config& config) { return FetchUnderFlood(config, false); }, 1, bytes));
  }
  const auto print = [&](const char* name, size_t which) {
    const double value = Median(ours, which);
    const double limit = Median(bare, which);
    Print(name, 1e3 * value, "ms", 1e3 * limit, limit / value);
  };
  print("batch of 256 while inserts run, p50", 2);
  print("batch of 256 while inserts run, p99", 3);
}

// What a snapshot of a million frames does to both sides: prioritised, so that there is most to copy.
void Snapshots() {
  constexpr uint64_t kMillion = 1000000 / ChunkStream::kFrames;
  constexpr uint64_t kMore = 20000;
  constexpr int kSnapshots = 5;
  const auto measure = [&](int snapshots) {
    Config config = OnFreePort();
    config.replay.sampler = SamplerKind::kPrioritized;
    const Folder folder(Memory());
    ReplayProcess replay(folder.path(), config);
    replay.Start();
    Peer([&] { return Feed(config, kMillion, true); }).Wait();
    Peer feed([&] { return Feed(config, kMillion + kMore, true); });
    Peer fetch([&] { return Fetch(config, {.batches = kAnswers}); });
    for (int i = 0; i < snapshots; ++i) {
      const std::string command =
          fmt::format("{}/bin/dadrl-replay tool snapshot --run-dir {} --name {} >/dev/null 2>&1",
                      DADRL_BINARY_DIR, folder.path().string(), i);
      if (std::system(command.c_str()) != 0) spdlog::error("no snapshot: {}", command);
    }
    Numbers numbers = feed.Wait();
    for (const double number : fetch.Wait()) numbers.push_back(number);
    return numbers;
  };
  std::vector<Numbers> without;
  std::vector<Numbers> with;
  for (int run = 0; run < kRuns; ++run) {
    without.push_back(measure(0));
    with.push_back(measure(kSnapshots));
  }
  const auto print = [&](const char* name, size_t which) {
    const double value = Median(with, which);
    const double limit = Median(without, which);
    Print(name, 1e3 * value, "ms", 1e3 * limit, limit / value);
  };
  print("insert acknowledged during snapshots, p50", 1);
  print("insert acknowledged during snapshots, p99", 2);
  print("insert acknowledged during snapshots, largest", 3);
  print("batch of 256 during snapshots, p50", 6);
  print("batch of 256 during snapshots, p99", 7);
  print("batch of 256 during snapshots, largest", 8);
}

}  // namespace
}  // namespace dadrl::bench

int main(int argc, char** argv) {
  dadrl::InitLogging("replay_service");
  const std::string only = argc > 1 ? argv[1] : "";
  const auto chosen = [&](const char* part) { return only.empty() || only == part; };
  if (chosen("inserts")) dadrl::bench::Inserts();
  if (chosen("disk")) dadrl::bench::InsertsToDisk();
  if (chosen("samples")) dadrl::bench::Samples();
  if (chosen("latencies")) dadrl::bench::Latencies();
  if (chosen("snapshots")) dadrl::bench::Snapshots();
  return 0;
}
