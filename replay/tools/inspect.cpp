#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "replay/storage/snapshot_folder.h"
#include "replay/tools/shard_reader.h"
#include "replay/tools/tool.h"

namespace dadrl {
namespace {

struct Contents {
  uint64_t chunks = 0;
  uint64_t frames = 0;       // steps, and what was seen after truncations
  uint64_t transitions = 0;  // frames with a decision
  uint64_t payload_bytes = 0;
  uint64_t episodes = 0;
  uint64_t terminated = 0;
  uint64_t truncated = 0;
  uint64_t successes = 0;  // of the terminated
  uint64_t damaged_bytes = 0;
  uint32_t oldest_version = std::numeric_limits<uint32_t>::max();
  uint32_t newest_version = 0;
  std::set<std::pair<uint32_t, uint64_t>> incarnations;
  std::map<uint32_t, std::pair<uint64_t, uint64_t>> last_episode;  // of each actor: incarnation, episode

  void Add(const ChunkView& chunk) {
    const ChunkHeader& header = chunk.header();
    const std::pair now{header.identity.incarnation, header.episode};
    const auto [last, first_of_actor] = last_episode.try_emplace(header.identity.actor, now);
    if (first_of_actor || last->second != now) ++episodes;
    last->second = now;
    incarnations.emplace(header.identity.actor, header.identity.incarnation);
    ++chunks;
    payload_bytes += chunk.payload_bytes();
    for (int frame = 0; frame < chunk.frames(); ++frame) {
      const uint8_t flags = chunk.flags(frame);
      ++frames;
      if ((flags & kHasDecision) == 0) continue;
      ++transitions;
      terminated += (flags & kTerminated) != 0;
      truncated += (flags & kTruncated) != 0;
      successes += (flags & kSuccess) != 0;
      oldest_version = std::min(oldest_version, chunk.policy_version(frame));
      newest_version = std::max(newest_version, chunk.policy_version(frame));
    }
  }
};

double PerFrame(uint64_t bytes, uint64_t frames) { return frames == 0 ? 0.0 : 1.0 * bytes / frames; }

// Of those that lie beside the shards, in RUN/snapshots.
SnapshotUse UseOfSnapshotsBeside(const std::vector<std::filesystem::path>& shards) {
  SnapshotUse all;
  for (const std::filesystem::path& shard : shards) {
    std::error_code error;
    const std::filesystem::path folder = std::filesystem::canonical(shard, error);
    const std::filesystem::path run = folder.parent_path().parent_path();
    const SnapshotUse use = UseOfSnapshots(run / "snapshots" / folder.filename(), folder);
    all.snapshots += use.snapshots;
    all.bytes += use.bytes;
  }
  return all;
}

nlohmann::ordered_json Json(const ShardReader& reader, const Contents& c) {
  const SnapshotUse snapshots = UseOfSnapshotsBeside(reader.shards());
  return {{"shards", reader.shards().size()},
          {"segments", reader.segments()},
          {"bytes", reader.bytes()},
          {"chunks", c.chunks},
          {"frames", c.frames},
          {"transitions", c.transitions},
          {"bytes_per_frame", PerFrame(reader.bytes(), c.frames)},
          {"payload_bytes_per_frame", PerFrame(c.payload_bytes, c.frames)},
          {"episodes", c.episodes},
          {"ends",
           {{"terminated", c.terminated},
            {"by_success", c.successes},
            {"truncated", c.truncated},
            {"unfinished", c.episodes - std::min(c.episodes, c.terminated + c.truncated)}}},
          {"actors", c.last_episode.size()},
          {"incarnations", c.incarnations.size()},
          {"policy_versions",
           {{"oldest", c.transitions == 0 ? 0 : c.oldest_version}, {"newest", c.newest_version}}},
          {"columns",
           {{"observation", ColumnsText(reader.spec().observation)},
            {"decision", ColumnsText(reader.spec().decision)}}},
          {"snapshots", {{"count", snapshots.snapshots}, {"bytes_only_there", snapshots.bytes}}},
          {"damaged_bytes", c.damaged_bytes}};
}

void PrintTable(const nlohmann::ordered_json& json, const std::string& indent) {
  for (const auto& [key, value] : json.items()) {
    if (value.is_object()) {
      fmt::print("{}{}\n", indent, key);
      PrintTable(value, indent + "  ");
    } else if (value.is_number_float()) {
      fmt::print("{}{:<{}}{:>14.1f}\n", indent, key, 28 - indent.size(), value.get<double>());
    } else {
      fmt::print("{}{:<{}}{:>14}\n", indent, key, 28 - indent.size(), value.dump());
    }
  }
}

struct Options {
  std::string directory;
  bool json = false;
};

Result<int> Inspect(const Options& options) {
  DADRL_ASSIGN_OR_RETURN(const ShardReader reader, ShardReader::Open(options.directory));
  Contents contents;
  reader.ForEachChunk(
      [&](const auto&, uint64_t, const ChunkView& chunk) {
        contents.Add(chunk);
        return true;
      },
      [&](const Damage& damage) { contents.damaged_bytes += damage.bytes; });
  const nlohmann::ordered_json json = Json(reader, contents);
  if (options.json) {
    fmt::print("{}\n", json.dump());
  } else {
    PrintTable(json, "");
  }
  return 0;
}

}  // namespace

Tool MakeInspectTool(CLI::App& replay) {
  auto options = std::make_shared<Options>();
  CLI::App* app =
      replay.add_subcommand("inspect", "What is stored: frames, episodes, actors, versions, bytes");
  app->add_option("DIR", options->directory, "Run directory, its replay folder, one shard, or a snapshot")
      ->required();
  app->add_flag("--json", options->json, "One JSON object on standard output");
  return {app, [options] { return Inspect(*options); }};
}

}  // namespace dadrl
