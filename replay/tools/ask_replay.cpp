#include "replay/tools/ask_replay.h"

#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/dds/cluster_key.h"
#include "common/dds/node.h"
#include "common/io/link_file.h"
#include "common/util/clock.h"
#include "replay/tools/replay_question.h"

namespace dadrl {
namespace {

int Print(const std::map<uint32_t, ReplayAnswer>& answers, bool json) {
  bool all_done = true;
  nlohmann::ordered_json shards = nlohmann::ordered_json::array();
  for (const auto& [shard, answer] : answers) {
    all_done = all_done && answer.done;
    shards.push_back({{"shard", shard}, {"done", answer.done}, {"text", answer.text}});
    if (!json) fmt::print(answer.done ? stdout : stderr, "{}\n", answer.text);
  }
  if (json) {
    const nlohmann::ordered_json answer{{"done", all_done}, {"shards", std::move(shards)}};
    // A shard that says something else than UTF-8 ends nobody.
    fmt::print("{}\n", answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  return all_done ? 0 : 1;
}

}  // namespace

Result<int> AskReplay(const std::filesystem::path& run_directory, const dadrl_idl_ReplayCommand& command,
                      bool json) {
  const std::filesystem::path root = FollowLinks(run_directory);
  Config config;
  DADRL_RETURN_IF_ERROR(LoadYaml(root / "config.yaml", config));
  DADRL_ASSIGN_OR_RETURN(const std::string key, dds::LoadClusterKey(root, config.cluster));
  DADRL_ASSIGN_OR_RETURN(
      const auto node, dds::Node::Create(config.cluster, config.replay.shards, dds::Role::kMonitor, 0, key));
  const SystemClock clock;
  DADRL_ASSIGN_OR_RETURN(const auto answers,
                         AskShards(*node, config, command, clock,
                                   [](const std::string& text) { fmt::print(stderr, "{}\n", text); }));
  return Print(answers, json);
}

}  // namespace dadrl
