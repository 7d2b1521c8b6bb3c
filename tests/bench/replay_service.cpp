// The replay as a process, fed and emptied by others over DDS on loopback.
//
// Its files are in memory (/dev/shm), so that it is the service that is measured; one case shows what a disk
// makes of it, beside a plain file of the same bytes on the same disk.
//
// Prints JSON lines, each the median of kRuns, and each run to standard error; with arguments (inserts, disk,
// samples, latencies, snapshots) only those parts. The limit is the same traffic in the same run without a
// replay: one process writes the same bytes under the same QoS, another takes and drops them. For latencies
// it is the bare peer answering while it is flooded with chunks in the same way; for snapshots, the replay
// that takes none.
#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/util/clock.h"
#include "common/util/log.h"
#include "tests/bench/chunk_stream.h"
#include "tests/bench/help.h"
#include "tests/bench/service_runs.h"
#include "tests/paths.h"
#include "tests/replay/service/replay_process.h"

namespace dadrl::bench {
namespace {

constexpr uint64_t kChunks = 30000;
constexpr double kFrames = static_cast<double>(kChunks) * ChunkStream::kFrames;
constexpr int kBatches = 6000;
constexpr int kOutstanding = 16;    // the most that learner.credits allows
constexpr int kAnswers = 1500;      // of the latency
constexpr uint64_t kStored = 3000;  // chunks to sample from

// Writes the chunks to one file on the disk and forces them there.
Numbers WriteFile() {
  const Folder folder(Disk());
  ChunkStream stream;
  const SystemClock clock;
  const TimePoint begin = clock.Now();
  const int file = open((folder.path() / "chunks").c_str(), O_WRONLY | O_CREAT, 0600);
  for (uint64_t i = 1; i <= kChunks; ++i) {
    const auto chunk = stream.At(i);
    if (write(file, chunk.data(), chunk.size()) != static_cast<ssize_t>(chunk.size())) {
      throw std::runtime_error("cannot write to " + folder.path().string());
    }
  }
  fsync(file);
  close(file);
  return {.seconds = ToSeconds(clock.Now() - begin)};
}

Numbers FeedGranted(const Config& config) { return FeedAll(config, kChunks, true); }

void Inserts() {
  const Comparison runs = Compare(
      "inserts", [] { return WithReplay(FeedGranted); },
      [](const Numbers&) {
        return WithMirror([](const Config& config) { return FeedAll(config, kChunks, false); }, kChunks);
      });
  PrintRate("inserted frames", runs, kFrames, "frames/s");
}

void InsertsToDisk() {
  const Comparison runs = Compare(
      "disk", [] { return WithReplay(FeedGranted, Disk()); }, [](const Numbers&) { return WriteFile(); });
  PrintRate("inserted frames, on disk, forced every second", runs, kFrames, "frames/s");
}

void Samples() {
  const Traffic fetch_stored = [](const Config& config) {
    FeedAll(config, kStored, true);
    return FetchAll(config, {.batches = kBatches, .outstanding = kOutstanding});
  };
  const Traffic fetch_bare = [](const Config& config) {
    return FetchAll(config, {.batches = kBatches, .replies_of = kBatches});
  };
  const Comparison runs = Compare(
      "samples", [&] { return WithReplay(fetch_stored); },
      [&](const Numbers& ours) { return WithMirror(fetch_bare, kChunks, kBatches, ours.bytes); });
  PrintRate("sampled batches of 256, 3 steps", runs, kBatches, "batches/s");
}

Numbers FetchUnderFlood(const Config& config, bool granting) {
  const PeerProcess flood([&]() -> Numbers { FeedForEver(config, granting); });
  return FetchAll(config, {.batches = kAnswers});
}

void Latencies() {
  const Comparison runs = Compare(
      "latencies",
      [] { return WithReplay([](const Config& config) { return FetchUnderFlood(config, true); }); },
      [](const Numbers& ours) {
        return WithMirror([](const Config& config) { return FetchUnderFlood(config, false); }, kChunks, 1,
                          ours.bytes);
      });
  PrintWait("batch of 256 while inserts run, p50", runs, &Numbers::p50_s);
  PrintWait("batch of 256 while inserts run, p99", runs, &Numbers::p99_s);
}

struct BothSides {
  Numbers inserts;
  Numbers batches;
};

// A replay of a million frames that takes so many snapshots while both sides go on. Prioritised, so that
// there is most to copy.
BothSides FeedAndFetchDuring(int snapshots) {
  constexpr uint64_t kMillion = 1000000 / ChunkStream::kFrames;
  constexpr uint64_t kMore = 20000;
  Config config = OnFreePort();
  config.replay.sampler = SamplerKind::kPrioritized;
  const Folder folder(Memory());
  ReplayProcess replay(folder.path(), config);
  replay.Start();
  FeedAll(config, kMillion, true);
  PeerProcess feed([&] { return Feed(config, kMillion + kMore, true); });
  PeerProcess fetch([&] { return Fetch(config, {.batches = kAnswers}); });
  for (int i = 0; i < snapshots; ++i) {
    const std::string command =
        fmt::format("{}/bin/dadrl-replay tool snapshot --run-dir {} --name {} >/dev/null 2>&1",
                    DADRL_BINARY_DIR, folder.path().string(), i);
    if (std::system(command.c_str()) != 0) throw std::runtime_error("no snapshot: " + command);
  }
  const Numbers inserts = feed.Wait();
  return {inserts, fetch.Wait()};
}

void Snapshots() {
  constexpr int kSnapshots = 5;
  Comparison inserts;
  Comparison batches;
  for (int run = 0; run < kRuns; ++run) {
    SayRun("snapshots", run);
    const BothSides without = FeedAndFetchDuring(0);
    const BothSides with = FeedAndFetchDuring(kSnapshots);
    inserts.limit.push_back(without.inserts);
    inserts.ours.push_back(with.inserts);
    batches.limit.push_back(without.batches);
    batches.ours.push_back(with.batches);
  }
  const auto print = [](const std::string& what, const Comparison& runs) {
    PrintWait(what + " during snapshots, p50", runs, &Numbers::p50_s);
    PrintWait(what + " during snapshots, p99", runs, &Numbers::p99_s);
    PrintWait(what + " during snapshots, largest", runs, &Numbers::largest_s);
  };
  print("insert acknowledged", inserts);
  print("batch of 256", batches);
}

}  // namespace
}  // namespace dadrl::bench

namespace {

constexpr std::string_view kUsage =
    "replay_service [PART...]: the replay as a process, beside the same traffic without it; parts: inserts, "
    "disk,\nsamples, latencies, snapshots; without: all\n";
using Part = std::pair<std::string_view, void (*)()>;
constexpr std::array<Part, 5> kParts{{{"inserts", dadrl::bench::Inserts},
                                      {"disk", dadrl::bench::InsertsToDisk},
                                      {"samples", dadrl::bench::Samples},
                                      {"latencies", dadrl::bench::Latencies},
                                      {"snapshots", dadrl::bench::Snapshots}}};

bool IsPart(std::string_view name) {
  return std::any_of(kParts.begin(), kParts.end(), [&](const Part& part) { return part.first == name; });
}

}  // namespace

int main(int argc, char** argv) {
  if (dadrl::bench::HelpAsked(argc, argv, kUsage)) return 0;
  const std::vector<std::string_view> wanted(argv + 1, argv + argc);
  for (const std::string_view name : wanted) {
    if (IsPart(name)) continue;
    fmt::print(stderr, "no part '{}'; {}", name, kUsage);
    return 2;
  }
  dadrl::InitLogging("replay_service");
  const dadrl::bench::ChunkStream generated_before_any_fork;
  try {
    for (const auto& [name, run] : kParts) {
      if (wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end()) run();
    }
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return 1;
  }
  return 0;
}
