#include "proto/evaluation/rendered_episode.h"

#include "common/io/json_text.h"

namespace dadrl {
namespace {

// An animation's episode has a file a step: a hundred thousand names.
constexpr size_t kMaxRenderedLine = size_t{64} << 20;
constexpr double kLargest = 1e9;
constexpr int kMostSteps = 1'000'000'000;

bool ReadNames(const nlohmann::ordered_json* list, std::vector<std::string>& names) {
  if (list == nullptr || !list->is_array()) return false;
  for (const auto& name : *list) {
    if (!name.is_string()) return false;
    names.push_back(name.get<std::string>());
  }
  return true;
}

}  // namespace

std::string RenderedLine(const RenderedEpisode& episode) {
  const nlohmann::ordered_json line = {
      {"seed", episode.seed},         {"outcome", OutcomeName(episode.outcome)},
      {"steps", episode.steps},       {"return", episode.episode_return},
      {"sentence", episode.sentence}, {"files", episode.files},
      {"error", episode.error}};
  return line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

Result<RenderedEpisode> ParseRenderedLine(std::string_view line) {
  if (line.size() > kMaxRenderedLine) {
    return Fail(ErrorCode::kCorrupt, "the line of a rendered episode has {} bytes, at most {} are read",
                line.size(), kMaxRenderedLine);
  }
  DADRL_ASSIGN_OR_RETURN(const nlohmann::ordered_json json,
                         ParseJson(line, "the line of a rendered episode"));
  JsonFields fields(json);
  RenderedEpisode episode;
  episode.seed = fields.Whole("seed", UINT64_MAX);
  const auto outcome = OutcomeFromName(fields.Text("outcome", kMaxRenderedLine));
  if (!outcome) fields.Refuse("outcome");
  episode.steps = fields.Whole("steps", kMostSteps);
  episode.episode_return = fields.Number("return", -kLargest, kLargest);
  episode.sentence = fields.Text("sentence", kMaxRenderedLine);
  episode.error = fields.Text("error", kMaxRenderedLine);
  if (!ReadNames(fields.Find("files"), episode.files)) fields.Refuse("files");
  if (!fields.ok()) {
    return Fail(ErrorCode::kCorrupt, "the line of a rendered episode has no possible '{}'", fields.bad());
  }
  episode.outcome = *outcome;
  return episode;
}

}  // namespace dadrl
