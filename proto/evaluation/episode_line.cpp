#include "proto/evaluation/episode_line.h"

#include <optional>
#include <utility>

#include "common/io/json_text.h"
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

// Names and errors may be no UTF-8.
std::string OneLine(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

// What a measured field may come to: far beyond any, and still a number to compute with.
constexpr double kLargest = 1e9;
constexpr int kMostSteps = 1'000'000'000;

tl::unexpected<Error> Wrong(const std::string& field) {
  return Fail(ErrorCode::kCorrupt, "an episode line without a possible '{}'", field);
}

Result<CollisionSummary> ParseCollision(const nlohmann::ordered_json& json) {
  JsonFields fields(json);
  const auto side = ContactSideFromName(fields.Text("side", kMaxName));
  const auto changer = LaneChangerFromName(fields.Text("lane_changer", kMaxName));
  if (!side) fields.Refuse("side");
  if (!changer) fields.Refuse("lane_changer");
  CollisionSummary collision;
  collision.ego_speed_mps = fields.Number("ego_speed_mps", -kLargest, kLargest);
  collision.other_speed_mps = fields.Number("other_speed_mps", -kLargest, kLargest);
  collision.relative_heading_rad = fields.Number("relative_heading_rad", -kLargest, kLargest);
  collision.junction = fields.Boolean("junction");
  if (!fields.ok()) return Wrong("crash." + fields.bad());
  collision.side = *side;
  collision.lane_changer = *changer;
  return collision;
}

}  // namespace

Result<std::vector<PlannedEpisode>> PlanEpisodes(uint64_t first_seed, int groups, int episodes) {
  if (first_seed < kFirstEvaluationSeed) {
    return Fail(ErrorCode::kInvalidArgument,
                "first seed {} is below {}: smaller seeds are training traffic, choose a larger one",
                first_seed, kFirstEvaluationSeed);
  }
  if (groups < 1) return Fail(ErrorCode::kInvalidArgument, "{} seeds; at least 1 is needed", groups);
  const uint64_t largest = UINT64_MAX - kSeedGroupStride * static_cast<uint64_t>(groups);
  if (first_seed > largest) {
    return Fail(ErrorCode::kInvalidArgument,
                "first seed {} is above {}: with {} seeds it would wrap around to training traffic",
                first_seed, largest, groups);
  }
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
    return OneLine(json);
  }
  json["outcome"] = OutcomeName(episode.summary.outcome);
  json["steps"] = episode.summary.steps;
  for (const SummaryField& field : kSummaryFields) json[field.name] = episode.summary.*field.value;
  if (episode.summary.collision) json["crash"] = CollisionJson(*episode.summary.collision);
  return OneLine(json);
}

Result<EvaluatedEpisode> ParseEpisodeLine(std::string_view line) {
  if (line.size() > kMaxEpisodeLine) {
    return Fail(ErrorCode::kCorrupt, "an episode line of {} bytes, at most {} are read", line.size(),
                kMaxEpisodeLine);
  }
  DADRL_ASSIGN_OR_RETURN(const nlohmann::ordered_json json, ParseJson(line, "an episode line"));
  JsonFields fields(json);
  EvaluatedEpisode episode;
  EpisodeSummary& summary = episode.summary;
  episode.group = fields.Whole("group", kMaxSeedGroups);
  summary.seed = fields.Whole("seed", UINT64_MAX);
  summary.scenario = fields.Text("scenario", kMaxName);
  if (fields.Has("error")) {
    episode.error = fields.Text("error", kMaxEpisodeLine);
    if (!episode.lost()) fields.Refuse("error");
    return fields.ok() ? Result<EvaluatedEpisode>(std::move(episode)) : Wrong(fields.bad());
  }
  const std::optional<Outcome> outcome = OutcomeFromName(fields.Text("outcome", kMaxName));
  if (!outcome) fields.Refuse("outcome");
  summary.steps = fields.Whole("steps", kMostSteps);
  for (const SummaryField& field : kSummaryFields) {
    summary.*field.value = fields.Number(field.name, -kLargest, kLargest);
  }
  if (!fields.ok()) return Wrong(fields.bad());
  summary.outcome = *outcome;
  if (const auto* crash = fields.Find("crash")) {
    DADRL_ASSIGN_OR_RETURN(summary.collision, ParseCollision(*crash));
  }
  return episode;
}

}  // namespace dadrl
