#include "replay/tools/ask_replay.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>

#include "common/config/config_yaml.h"
#include "common/dds/node.h"
#include "common/io/link_file.h"
#include "common/io/run_key.h"
#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

constexpr Duration kPatience = std::chrono::seconds(60);
constexpr Duration kRepeat = std::chrono::seconds(1);

struct Answer {
  bool done = false;
  std::string text;
};

int Print(const std::map<uint32_t, Answer>& answers, bool json) {
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

// Who did not answer, and what that means.
tl::unexpected<Error> Silence(const std::map<uint32_t, Answer>& heard, const Config& config,
                              const std::filesystem::path& run_directory, int listening) {
  const auto shards = static_cast<uint32_t>(config.replay.shards);
  if (listening < config.replay.shards) {
    return Fail(ErrorCode::kUnavailable,
                "{} of {} replay shards of {} listen at {}:{}; is the training running?", listening, shards,
                run_directory.string(), config.cluster.host, config.cluster.port);
  }
  std::string silent;
  for (uint32_t shard = 0; shard < shards; ++shard) {
    if (!heard.contains(shard)) silent += fmt::format("{}{}", silent.empty() ? "" : ", ", shard);
  }
  return Fail(
      ErrorCode::kUnavailable,
      "replay shard {} was not done within {:.0f} s: its disk is slow, or it is stopped; it may still do "
      "what was asked, and says so in {}",
      silent, ToSeconds(kPatience), (run_directory / "logs").string());
}

}  // namespace

Result<int> AskReplay(const std::filesystem::path& run_directory, dadrl_idl_ReplayCommand command,
                      bool json) {
  Config config;
  DADRL_RETURN_IF_ERROR(LoadYaml(FollowLinks(run_directory) / "config.yaml", config));
  const auto shards = static_cast<size_t>(config.replay.shards);
  DADRL_ASSIGN_OR_RETURN(const std::string key, LoadRunKey(FollowLinks(run_directory)));
  DADRL_ASSIGN_OR_RETURN(
      const auto node, dds::Node::Create(config.cluster, config.replay.shards, dds::Role::kMonitor, 0, key));
  DADRL_ASSIGN_OR_RETURN(const auto answers,
                         Reader<dadrl_idl_ReplayAnswer>::Create(*node, kReplayAnswerTopic));
  DADRL_ASSIGN_OR_RETURN(const auto commands,
                         Writer<dadrl_idl_ReplayCommand>::Create(*node, kReplayCommandTopic));
  command.command = static_cast<uint64_t>(WallTimeNs()) ^ static_cast<uint64_t>(getpid()) << 40;
  std::map<uint32_t, Answer> heard;
  const SystemClock clock;
  const TimePoint end = clock.Now() + kPatience;
  TimePoint next{};
  while (heard.size() < shards && clock.Now() < end) {
    if (commands->matched() > 0 && clock.Now() >= next) {
      for (uint32_t shard = 0; shard < shards; ++shard) {
        command.shard = shard;
        if (!heard.contains(shard)) std::ignore = commands->Write(command);  // is repeated
      }
      next = clock.Now() + kRepeat;
    }
    answers->Wait(std::chrono::milliseconds(50));
    answers->Take(64, [&](const dadrl_idl_ReplayAnswer& answer) {
      if (answer.command != command.command || answer.shard >= shards) return;
      heard[answer.shard] = {answer.done, Shown(answer.text, sizeof(answer.text))};
    });
  }
  if (heard.size() < shards) return Silence(heard, config, run_directory, commands->matched());
  return Print(heard, json);
}

}  // namespace dadrl
