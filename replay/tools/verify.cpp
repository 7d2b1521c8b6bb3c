#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/config/config_yaml.h"
#include "proto/experience_bounds.h"
#include "replay/service/chunk_verifier.h"
#include "replay/storage/state_file.h"
#include "replay/tools/shard_reader.h"
#include "replay/tools/tool.h"

namespace dadrl {
namespace {

constexpr size_t kMostNamed = 100;

struct Options {
  std::string directory;
  bool json = false;
};

struct Findings {
  uint64_t chunks = 0;
  uint64_t frames = 0;
  uint64_t damages = 0;
  std::vector<Damage> named;

  void Add(Damage damage) {
    if (damages++ < kMostNamed) named.push_back(std::move(damage));
  }
};

// Of the run that `shard`, or a snapshot of it, belongs to; of any task where that is not at hand.
ExperienceBounds BoundsOf(const std::filesystem::path& shard) {
  constexpr int kLevels = 3;  // RUN/snapshots/shard-K/NAME
  std::error_code error;
  std::filesystem::path folder = std::filesystem::canonical(shard, error);
  for (int level = 0; level < kLevels && !error; ++level) {
    folder = folder.parent_path();
    Config config;
    if (LoadYaml(folder / "config.yaml", config)) return ExperienceBounds::From(config);
  }
  return ExperienceBounds::OfAnyTask();
}

void CheckState(const ShardReader& reader, const std::filesystem::path& shard, Findings& findings) {
  const auto file = shard / "state";
  const Result<ReplayState> state = ReadReplayState(file, MaxStateBytes(reader.BytesOf(shard)));
  if (state || state.error().code == ErrorCode::kNotFound) return;
  findings.Add({.file = file, .what = state.error().message});
}

void PrintJson(const ShardReader& reader, const Findings& findings) {
  nlohmann::ordered_json damage = nlohmann::json::array();
  for (const Damage& one : findings.named) {
    damage.push_back(
        {{"file", one.file.string()}, {"offset", one.offset}, {"bytes", one.bytes}, {"what", one.what}});
  }
  const nlohmann::ordered_json json = {{"ok", findings.damages == 0}, {"segments", reader.segments()},
                                       {"bytes", reader.bytes()},     {"chunks", findings.chunks},
                                       {"frames", findings.frames},   {"damages", findings.damages},
                                       {"damage", std::move(damage)}};
  fmt::print("{}\n", json.dump());
}

void PrintText(const ShardReader& reader, const Findings& findings) {
  for (const Damage& one : findings.named) {
    fmt::print("{}: offset {}, {} bytes: {}\n", one.file.string(), one.offset, one.bytes, one.what);
  }
  if (findings.damages > findings.named.size()) {
    fmt::print("... and {} more\n", findings.damages - findings.named.size());
  }
  fmt::print("{} frames in {} chunks and {} segments decode; {} damaged places\n", findings.frames,
             findings.chunks, reader.segments(), findings.damages);
}

Result<int> Verify(const Options& options) {
  DADRL_ASSIGN_OR_RETURN(const ShardReader reader, ShardReader::Open(options.directory));
  ChunkVerifier verifier(reader.spec(), /*all=*/true, /*seed=*/0);
  const ExperienceBounds bounds = BoundsOf(reader.shards().front());
  Findings findings;
  reader.ForEachChunk(
      [&](const std::filesystem::path& file, uint64_t offset, const ChunkView& chunk) {
        Status sound = CheckRewards(chunk, bounds);
        if (sound) sound = CheckDecisions(chunk, reader.spec());
        if (sound) sound = verifier.Check(chunk);
        if (!sound) {
          findings.Add({file, offset, chunk.bytes().size(), sound.error().message});
          return true;
        }
        ++findings.chunks;
        findings.frames += static_cast<uint64_t>(chunk.frames());
        return true;
      },
      [&](const Damage& damage) { findings.Add(damage); });
  for (const std::filesystem::path& shard : reader.shards()) CheckState(reader, shard, findings);
  if (options.json) {
    PrintJson(reader, findings);
  } else {
    PrintText(reader, findings);
  }
  return findings.damages == 0 ? 0 : 1;
}

}  // namespace

Tool MakeVerifyTool(CLI::App& replay) {
  auto options = std::make_shared<Options>();
  CLI::App* app = replay.add_subcommand(
      "verify",
      "Check every checksum, decode every frame, hold its numbers against what the run's task can give; exit "
      "code 1 and file and offset of any damage");
  app->add_option("DIR", options->directory, "Run directory, its replay folder, one shard, or a snapshot")
      ->required();
  app->add_flag("--json", options->json, "One JSON object on standard output");
  return {app, [options] { return Verify(*options); }};
}

}  // namespace dadrl
