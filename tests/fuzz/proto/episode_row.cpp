// A row of an actor's table of episodes, which becomes one of the run's.
#include "proto/evaluation/episode_row.h"

#include <algorithm>
#include <cmath>

#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {

const int kMutants = 30000;

bool Check(std::span<std::byte> input) {
  const std::string_view row = AsText(input);
  if (row.find('\n') != std::string_view::npos) return false;  // a row is a line
  const auto key = ActorEpisodeKey(row);
  if (!key) return false;
  Require(std::isfinite(key->time_s));
  const std::string of_run = RunEpisodeRow(7, row);
  Require(of_run.size() <= row.size() + 3 && of_run.ends_with('\n'));
  int actor = 0;
  const auto again = RunEpisodeKey(std::string_view(of_run).substr(0, of_run.size() - 1), actor);
  Require(again && actor == 7 && again->episode == key->episode && again->steps == key->steps);
  return true;
}

Seeds MakeSeeds() {
  TrainingEpisode episode{};
  episode.wall_time_ns = 1'700'000'000'123'456'789;
  episode.incarnation = 5;
  episode.episode = 12;
  episode.policy_version = 3;
  episode.summary.scenario = "left_turn";
  std::string plain = ActorEpisodeRow(episode);
  episode.summary.scenario = "on, \"ramp\"";
  std::string quoted = ActorEpisodeRow(episode);
  for (std::string* row : {&plain, &quoted}) row->pop_back();
  Seeds seeds{.accepted = {AsBytes(plain), AsBytes(quoted)},
              .refused = {AsBytes(ActorEpisodeColumns()), AsBytes(""), AsBytes(std::string(5000, ',')),
                          AsBytes("nan" + plain.substr(plain.find(','))), AsBytes(plain + ",\"")}};
  seeds.refused.push_back(AsBytes("1e999" + plain.substr(plain.find(','))));
  return seeds;
}

}  // namespace dadrl::fuzz
