#include "proto/evaluation/episode_line.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "proto/evaluation/summary_fields.h"

namespace dadrl {
namespace {

nlohmann::ordered_json CollisionJson(const CollisionSummary& collision) {
  return {{"kind", CollisionKind(collision)},
          {"side", ContactSideName(collision.side)},
          {"ego_speed_mps", collision.ego_speed_mps},
          {"other_speed_mps", collision.other_speed_mps},
          {"relative_heading_rad", collision.relative_heading_rad},
          {"junction", collision.junction},
          {"lane_changer", LaneChangerName(collision.lane_changer)}};
}

Result<CollisionSummary> ParseCollision(const nlohmann::json& json) {
  const auto side = ContactSideFromName(json.at("side").get<std::string>());
  const auto changer = LaneChangerFromName(json.at("lane_changer").get<std::string>());
  if (!side || !changer) {
    return Fail(ErrorCode::kCorrupt, "an episode line has the unknown collision {}", json.dump());
  }
  return CollisionSummary{.side = *side,
                          .ego_speed_mps = json.at("ego_speed_mps").get<double>(),
                          .other_speed_mps = json.at("other_speed_mps").get<double>(),
                          .relative_heading_rad = json.at("relative_heading_rad").get<double>(),
                          .junction = json.at("junction").get<bool>(),
                          .lane_changer = *changer};
}

}  // namespace

Result<std::vector<PlannedEpisode>> PlanEpisodes(uint64_t first_seed, int groups, int episodes) {
  if (first_seed < kFirstEvaluationSeed) {
    return Fail(ErrorCode::kInvalidArgument,
                "first seed {} is below {}: smaller seeds are training traffic, choose a larger one",
                first_seed, kFirstEvaluationSeed);
  }
  if (groups < 1) return Fail(ErrorCode::kInvalidArgument, "{} seeds; at least 1 is needed", groups);
  if (episodes < 1 || episodes > static_cast<int>(kSeedGroupStride)) {
    return Fail(ErrorCode::kInvalidArgument, "{} episodes a seed; the range is [1, {}]", episodes,
                kSeedGroupStride);
  }
  std::vector<PlannedEpisode> plan;
  for (int group = 0; group < groups; ++group) {
    for (int episode = 0; episode < episodes; ++episode) {
      plan.push_back({group, first_seed + kSeedGroupStride * static_cast<uint64_t>(group) +
                                 static_cast<uint64_t>(episode)});
    }
  }
  return plan;
}

std::vector<PlannedEpisode> EpisodesOfWorker(const std::vector<PlannedEpisode>& plan, int worker,
                                             int workers) {
  std::vector<PlannedEpisode> part;
  for (auto i = static_cast<size_t>(worker); i < plan.size(); i += static_cast<size_t>(workers)) {
    part.push_back(plan[i]);
  }
  return part;
}

std::string EpisodeLine(const EvaluatedEpisode& episode) {
  nlohmann::ordered_json json;
  json["group"] = episode.group;
  json["seed"] = episode.summary.seed;
  json["scenario"] = episode.summary.scenario;
  if (episode.lost()) {
    json["error"] = episode.error;
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  }
  json["outcome"] = OutcomeName(episode.summary.outcome);
  json["steps"] = episode.summary.steps;
  for (const SummaryField& field : kSummaryFields) json[field.name] = episode.summary.*field.value;
  if (episode.summary.collision) json["crash"] = CollisionJson(*episode.summary.collision);
  return json.dump();
}

Result<EvaluatedEpisode> ParseEpisodeLine(std::string_view line) {
  try {
    const auto json = nlohmann::json::parse(line);
    EvaluatedEpisode episode;
    json.at("group").get_to(episode.group);
    json.at("seed").get_to(episode.summary.seed);
    json.at("scenario").get_to(episode.summary.scenario);
    if (json.contains("error")) {
      json.at("error").get_to(episode.error);
      if (!episode.lost()) return Fail(ErrorCode::kCorrupt, "an episode line has an empty error");
      return episode;
    }
    const auto name = json.at("outcome").get<std::string>();
    const std::optional<Outcome> outcome = OutcomeFromName(name);
    if (!outcome) return Fail(ErrorCode::kCorrupt, "an episode line has the unknown outcome '{}'", name);
    episode.summary.outcome = *outcome;
    json.at("steps").get_to(episode.summary.steps);
    for (const SummaryField& field : kSummaryFields) {
      episode.summary.*field.value = json.at(field.name).get<double>();
    }
    if (json.contains("crash")) {
      DADRL_ASSIGN_OR_RETURN(episode.summary.collision, ParseCollision(json.at("crash")));
    }
    return episode;
  } catch (const nlohmann::json::exception& error) {
    return Fail(ErrorCode::kCorrupt, "not an episode line: {}", error.what());
  }
}

}  // namespace dadrl
