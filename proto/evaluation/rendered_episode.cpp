#include "proto/evaluation/rendered_episode.h"

#include <nlohmann/json.hpp>

namespace dadrl {

std::string RenderedLine(const RenderedEpisode& episode) {
  const nlohmann::ordered_json line = {
      {"seed", episode.seed},         {"outcome", OutcomeName(episode.outcome)},
      {"steps", episode.steps},       {"return", episode.episode_return},
      {"sentence", episode.sentence}, {"files", episode.files},
      {"error", episode.error}};
  return line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

Result<RenderedEpisode> ParseRenderedLine(std::string_view line) {
  try {
    const auto json = nlohmann::json::parse(line);
    const auto outcome = OutcomeFromName(json.at("outcome").get<std::string>());
    if (!outcome) return Fail(ErrorCode::kCorrupt, "no such outcome: {}", line);
    return RenderedEpisode{.seed = json.at("seed"),
                           .outcome = *outcome,
                           .steps = json.at("steps"),
                           .episode_return = json.at("return"),
                           .sentence = json.at("sentence"),
                           .files = json.at("files"),
                           .error = json.at("error")};
  } catch (const nlohmann::json::exception& exception) {
    return Fail(ErrorCode::kCorrupt, "not a rendered episode: {} ({})", line, exception.what());
  }
}

}  // namespace dadrl
