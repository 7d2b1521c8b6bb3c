// The replay table without a network, one thread: samples, priorities, the frame codec, inserts, batches,
// recovery.
//
// Prints JSON lines. Each figure stands beside what bounds it, measured in this run on the same data: bare
// random access for the samples, zstd for the codec, a plain copy for inserts and batches, a checksum of the
// same files for recovery. of_limit is above 1 where we beat a peer.
//
// With an argument, a copy of a shard's folder that was recorded with the default observation: only what
// that experience keeps resident.
#include <fmt/core.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "common/io/checksum.h"
#include "common/io/read_file.h"
#include "proto/codec/half.h"
#include "replay/table.h"
#include "tests/bench/chunk_stream.h"
#include "tests/bench/figure.h"
#include "tests/bench/help.h"
#include "tests/driving_columns.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl::bench {
namespace {

constexpr const char* kBench = "replay_table";
constexpr uint32_t kItems = 1000000;
const DrivingShape kSpec;
volatile uint64_t sink;

double Seconds(const std::function<void()>& work) {
  const SystemClock clock;
  const TimePoint begin = clock.Now();
  work();
  return ToSeconds(clock.Now() - begin);
}

// Processor time, the best of a few runs: nothing here waits, so other processes must not count.
double BestSeconds(const std::function<void()>& work) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
  };
  double best = std::numeric_limits<double>::max();
  for (int i = 0; i < 5; ++i) {
    const double begin = now();
    work();
    best = std::min(best, now() - begin);
  }
  return best;
}

void Samples() {
  constexpr int kSamples = 3000000;
  Random random(1);
  std::vector<uint32_t> memory(kItems, 1);
  const double bare_read = BestSeconds([&] {
    uint64_t sum = 0;
    for (int i = 0; i < kSamples; ++i) sum += memory[random.Below(kItems)];
    sink = sum;
  });
  const auto uniform = MakeSelector(SamplerKind::kUniform, 0.0);
  for (uint32_t slot = 0; slot < kItems; ++slot) uniform->Insert(slot, 1.0);
  const double sampled = BestSeconds([&] {
    uint64_t sum = 0;
    for (int i = 0; i < kSamples; ++i) sum += uniform->Sample(random).slot;
    sink = sum;
  });
  PrintRate(kBench, "uniform samples, 1M items", kSamples / sampled, "samples/s", kSamples / bare_read);

  constexpr int kUpdates = 500000;
  std::vector<double> weights(kItems, 1.0);
  const double bare_update = BestSeconds([&] {
    for (int i = 0; i < kUpdates; ++i) weights[random.Below(kItems)] = random.Uniform();
  });
  const auto prioritized = MakeSelector(SamplerKind::kPrioritized, 0.6);
  for (uint32_t slot = 0; slot < kItems; ++slot) prioritized->Insert(slot, random.Uniform());
  const double updated = BestSeconds([&] {
    for (int i = 0; i < kUpdates; ++i) {
      prioritized->Update(prioritized->Sample(random).slot, random.Uniform());
    }
  });
  PrintRate(kBench, "prioritised sample and update, 1M items", kUpdates / updated, "pairs/s",
            kUpdates / bare_update);
}

// A frame without our coding: halves and bits, as they are.
std::vector<std::byte> Plain(const Observation& observation) {
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  for (const auto values : {VehiclesOf(observation), EgoOf(observation)}) {
    for (const float value : values) writer.Put(HalfFromFloat(value));
  }
  writer.PutBytes(std::as_bytes(ContextOf(observation)));
  return bytes;
}

double MeanSize(const std::vector<std::vector<std::byte>>& frames) {
  size_t bytes = 0;
  for (const auto& frame : frames) bytes += frame.size();
  return static_cast<double>(bytes) / static_cast<double>(frames.size());
}

void Codec() {
  constexpr size_t kFrames = 2000;
  Random random(1);
  std::vector<Observation> observations;
  for (size_t i = 0; i < kFrames; ++i) observations.push_back(SyntheticObservation(kSpec, random));
  std::vector<std::vector<std::byte>> plain;
  for (const Observation& observation : observations) plain.push_back(Plain(observation));

  std::vector<std::vector<std::byte>> packed(kFrames);
  const double zstd_encode = BestSeconds([&] {
    for (size_t i = 0; i < kFrames; ++i) {
      packed[i].resize(ZSTD_compressBound(plain[i].size()));
      packed[i].resize(
          ZSTD_compress(packed[i].data(), packed[i].size(), plain[i].data(), plain[i].size(), 1));
    }
  });
  const double zstd_decode = BestSeconds([&] {
    for (size_t i = 0; i < kFrames; ++i) {
      ZSTD_decompress(plain[i].data(), plain[i].size(), packed[i].data(), packed[i].size());
    }
  });
  PayloadCodec codec(kSpec, FloatCoding::kFloat16);
  std::vector<std::vector<std::byte>> coded(kFrames);
  const double encode = BestSeconds([&] {
    for (size_t i = 0; i < kFrames; ++i) {
      coded[i].clear();
      codec.Encode(observations[i], coded[i]);
    }
  });
  Observation decoded(kSpec);
  const double decode = BestSeconds([&] {
    for (const auto& payload : coded) {
      if (!codec.Decode(payload, decoded)) std::abort();
    }
  });
  PrintCost(kBench, "frame payload, synthetic junction", MeanSize(coded), "B", MeanSize(packed));
  PrintCost(kBench, "encode a frame", encode / kFrames * 1e6, "us", zstd_encode / kFrames * 1e6);
  PrintCost(kBench, "decode a frame", decode / kFrames * 1e6, "us", zstd_decode / kFrames * 1e6);
}

TableOptions Options(const std::filesystem::path& directory) {
  TableOptions options{
      .directory = directory, .spec = kSpec, .replay = {}, .n_step = 3, .seed = 1, .verify = nullptr};
  options.replay.min_size = 1;
  options.replay.samples_per_insert = 0.0;
  options.replay.sync = SyncMode::kNone;
  return options;
}

// What this process keeps in memory, MB: its own, and pages of files, which the system takes back when it
// needs them.
struct Resident {
  double anonymous = 0.0;
  double files = 0.0;

  static Resident Now() {
    Resident now;
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
      double kilobytes = 0.0;
      if (std::sscanf(line.c_str(), "RssAnon: %lf", &kilobytes) == 1) now.anonymous = kilobytes * 1024e-6;
      if (std::sscanf(line.c_str(), "RssFile: %lf", &kilobytes) == 1) now.files = kilobytes * 1024e-6;
    }
    return now;
  }
};

// Beside the bytes that the index counts for itself, and those on disk.
void PrintResident(const std::string& what, const Resident& before, const ReplayTable::Stats& stats) {
  const Resident now = Resident::Now();
  PrintCost(kBench, "resident with " + what + ": own memory", now.anonymous - before.anonymous, "MB",
            static_cast<double>(stats.index_bytes) / 1e6);
  PrintCost(kBench, "resident with " + what + ": pages of the files", now.files - before.files, "MB",
            static_cast<double>(stats.disk_bytes) / 1e6);
}

bool Table(const std::filesystem::path& directory) {
  constexpr uint64_t kChunks = kItems / 64;
  const SystemClock clock;
  ChunkStream stream;
  uint64_t bytes = 0;
  std::vector<std::byte> copy(kMaxChunkBytes);
  const double bare_copy = Seconds([&] {
    for (uint64_t i = 0; i < kChunks; ++i) {
      const auto chunk = stream.At(i + 1);
      std::memcpy(copy.data(), chunk.data(), chunk.size());
      bytes += chunk.size();
    }
  });
  const Resident before = Resident::Now();
  {
    auto table = ReplayTable::Open(Options(directory), clock);
    if (!table) {
      fmt::print(stderr, "error: {}\n", table.error().message);
      return false;
    }
    const double inserted = Seconds([&] {
      for (uint64_t i = 0; i < kChunks; ++i) {
        if ((*table)->Insert(stream.At(i + 1), i + 1) != ReplayTable::Insertion::kStored) std::abort();
      }
    });
    PrintRate(kBench, "insert with the log, no sync", kChunks * 64 / inserted, "frames/s",
              kChunks * 64 / bare_copy);
    const ReplayTable::Stats stats = (*table)->stats();
    const auto frames = static_cast<double>(stats.frames_held);
    PrintCost(kBench, "all told a frame, on disk", static_cast<double>(stats.disk_bytes) / frames, "B",
              1500.0);
    PrintCost(kBench, "index a frame, in memory", static_cast<double>(stats.index_bytes) / frames, "B",
              static_cast<double>(stats.disk_bytes) / frames);
    constexpr int kBatches = 2000;
    uint64_t batch_bytes = 0;
    const double sampled = Seconds([&] {
      for (int i = 0; i < kBatches; ++i) {
        const auto batch = (*table)->Sample({256, 3}, 0);
        if (!batch) std::abort();
        batch_bytes += EncodeTrajectories(batch->trajectories, {256, 3}, 1).size();
      }
    });
    const double copied = Seconds([&] {
      for (uint64_t left = batch_bytes; left > 0;) {
        const uint64_t size = std::min<uint64_t>(left, copy.size() / 2);
        std::memcpy(copy.data(), copy.data() + copy.size() / 2, size);
        left -= size;
      }
      sink = static_cast<uint64_t>(copy[17]);
    });
    PrintRate(kBench, "sample and serialise, batch 256, 3 steps", kBatches * 256 / sampled, "transitions/s",
              kBatches * 256 / copied);
    PrintResident("1M frames", before, stats);
  }
  const double hashed = Seconds([&] {
    uint64_t sum = 0;
    for (const auto& entry : std::filesystem::directory_iterator(directory)) {
      if (const auto content = ReadFile(entry.path(), 1 << 30)) sum += Xxh3(*content);
    }
    sink = sum;
  });
  uint64_t recovered_frames = 0;
  const double recovered = Seconds([&] {
    const auto table = ReplayTable::Open(Options(directory), clock);
    if (table) recovered_frames = (*table)->stats().frames_held;
  });
  if (recovered_frames != kChunks * 64) return false;
  PrintCost(kBench, "recover 1M frames", recovered, "s", hashed);
  return true;
}

bool Recorded(const std::filesystem::path& directory) {
  const SystemClock clock;
  const Resident before = Resident::Now();
  const auto table = ReplayTable::Open(Options(directory), clock);
  if (!table) {
    fmt::print(stderr, "error: {}\n", table.error().message);
    return false;
  }
  const ReplayTable::Stats stats = (*table)->stats();
  PrintResident(fmt::format("{} recorded frames", stats.frames_held), before, stats);
  return true;
}

}  // namespace
}  // namespace dadrl::bench

int main(int argc, char** argv) {
  if (dadrl::bench::HelpAsked(
          argc, argv,
          "replay_table [SHARD]: the replay table without a network, one thread; of a copy "
          "of a\nrecorded shard's folder, what its experience keeps resident\n")) {
    return 0;
  }
  if (argc > 1) return dadrl::bench::Recorded(argv[1]) ? 0 : 1;
  dadrl::bench::Samples();
  dadrl::bench::Codec();
  const auto directory = std::filesystem::temp_directory_path() / fmt::format("dadrl-bench-{}", getpid());
  const bool done = dadrl::bench::Table(directory);
  std::filesystem::remove_all(directory);
  return done ? 0 : 1;
}
