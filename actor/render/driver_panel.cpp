#include "actor/render/driver_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "actor/render/palette.h"

namespace dadrl {
namespace {

using svg::Box;
using svg::Node;

// `text` of each moment of the film.
template <typename Text>
Track TrackOf(const Film& film, Text text) {
  Track track;
  track.reserve(film.size());
  for (size_t i = 0; i < film.size(); ++i) track.push_back(text(film[i]));
  return track;
}

struct LaneCommand {
  int lane;
  const char* words;
};
constexpr std::array<LaneCommand, 3> kLaneCommands = {
    {{1, "\u2190 lane left"}, {0, "\u2191 keep lane"}, {-1, "lane right \u2192"}}};

void DrawLaneCommand(Node parent, const Film& film, const Box& box) {
  if (!film[0].command) {
    svg::AddText(parent, {box.right(), box.y + 19}, "driven by SUMO: no commands",
                 {{"text-anchor", "end"}, {"fill", colour::kFaint}});
    return;
  }
  constexpr double kGap = 6;
  const double width = (box.width - 2 * kGap) / 3;
  double x = box.x;
  for (const LaneCommand& command : kLaneCommands) {
    const auto given = [&](const Moment& moment) { return moment.command->lane == command.lane; };
    const Box button{x, box.y, width, box.height};
    const Node border = svg::AddBox(parent, button, {{"rx", "5"}, {"stroke", colour::kLine}});
    Animate(border, film, "fill",
            TrackOf(film, [&](const Moment& m) { return given(m) ? colour::kEgo : colour::kPaper; }),
            Motion::kSteps);
    const Node text = svg::AddText(parent, {button.centre().x, button.centre().y + 4.5}, command.words,
                                   {{"class", "small"}, {"text-anchor", "middle"}});
    Animate(text, film, "fill",
            TrackOf(film, [&](const Moment& m) { return given(m) ? colour::kPaper : colour::kFaint; }),
            Motion::kSteps);
    x += width + kGap;
  }
}

double TopSpeed(const Recording& recording) {
  double top = recording.max_speed_mps;
  for (const Moment& moment : recording.moments) {
    top = std::max(top, moment.world.ego.speed_mps);
    if (moment.command) top = std::max(top, moment.command->target_speed_mps);
  }
  return std::ceil(top);
}

void DrawSpeed(Node parent, const Film& film, const Box& box) {
  const double pixels_per_mps = box.width / TopSpeed(film.recording());
  svg::AddText(parent, {box.x, box.y}, "speed", {{"class", "strong"}, {"fill", colour::kEgo}});
  AddDigits(parent, film, {box.x + 100, box.y}, 15,
            TrackOf(film, [](const Moment& m) { return fmt::format("{:4.1f}", m.world.ego.speed_mps); }),
            {{"class", "strong"}, {"fill", colour::kEgo}});
  svg::AddText(parent, {box.x + 105, box.y}, "m/s", {{"fill", colour::kEgo}});
  const Box bar{box.x, box.y + 9, box.width, 14};
  svg::AddBox(parent, bar, {{"rx", "3"}, {"fill", colour::kGround}});
  const Node level =
      svg::Add(parent, "rect",
               {{"x", bar.x}, {"y", bar.y}, {"height", bar.height}, {"rx", "3"}, {"fill", colour::kEgo}});
  Animate(level, film, "width",
          TrackOf(film,
                  [&](const Moment& m) {
                    return svg::Number(std::max(0.0, m.world.ego.speed_mps) * pixels_per_mps);
                  }),
          Motion::kSmooth);
  if (!film[0].command) return;
  const auto target = [](const Moment& m) { return m.command->target_speed_mps; };
  svg::AddText(parent, {box.right() - 92, box.y}, "asked for",
               {{"text-anchor", "end"}, {"fill", colour::kInk}});
  AddDigits(parent, film, {box.right() - 36, box.y}, 15,
            TrackOf(film, [&](const Moment& m) { return fmt::format("{:4.1f}", target(m)); }),
            {{"class", "strong"}, {"fill", colour::kInk}});
  svg::AddText(parent, {box.right(), box.y}, "m/s", {{"text-anchor", "end"}});
  const Node marker = svg::Add(parent, "path",
                               {{"d", fmt::format("M0,{0}v22M-6,{1}h12l-6,-8z", svg::Number(bar.y - 3),
                                                  svg::Number(bar.bottom() + 12))},
                                {"stroke", colour::kInk},
                                {"stroke-width", "2"}});
  AnimateTransform(
      marker, film, "translate",
      TrackOf(film, [&](const Moment& m) { return svg::Number(bar.x + target(m) * pixels_per_mps); }),
      Motion::kSteps);
}

struct RewardRow {
  const char* words;
  double RewardTerms::*term;
};
constexpr std::array<RewardRow, 8> kRewardRows = {{{"progress on route", &RewardTerms::progress},
                                                   {"speed", &RewardTerms::speed},
                                                   {"goal reached", &RewardTerms::goal},
                                                   {"collision", &RewardTerms::crash},
                                                   {"off the road", &RewardTerms::off_road},
                                                   {"off the route", &RewardTerms::off_route},
                                                   {"wrong way", &RewardTerms::wrong_way},
                                                   {"standing still", &RewardTerms::slow}}};

// What the bars have to hold.
struct Range {
  double low = 0.0;
  double high = 0.0;
  void Include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

Range RangeOfSums(const Recording& recording) {
  Range range{-0.5, 0.5};
  for (const Moment& moment : recording.moments) {
    for (const RewardRow& row : kRewardRows) range.Include(moment.reward_so_far.*row.term);
    range.Include(moment.reward_so_far.Sum());
  }
  return range;
}

struct RewardColumns {
  double step_end;  // right end of the step's numbers
  double sum_end;   // right end of the sums
  double zero;      // of the bars
  double unit;      // pixels of a bar for a reward of 1
};

// One line: what it is, of this step, so far, and the latter as a bar.
template <typename Value>
void DrawRewardRow(Node parent, const Film& film, double y, const RewardColumns& columns, double left,
                   const char* words, const char* style, Value value) {
  const bool never = std::all_of(film.recording().moments.begin(), film.recording().moments.end(),
                                 [&](const Moment& m) { return value(m.reward_so_far) == 0.0; });
  const char* const ink = never ? colour::kFaint : colour::kInk;
  svg::AddText(parent, {left, y}, words, {{"class", style}, {"fill", ink}});
  AddDigits(parent, film, {columns.step_end, y}, 13,
            TrackOf(film,
                    [&](const Moment& m) {
                      return value(m.reward) == 0.0 ? std::string("     0")
                                                    : fmt::format("{:+6.3f}", value(m.reward));
                    }),
            {{"class", style}, {"fill", ink}});
  AddDigits(parent, film, {columns.sum_end, y}, 13,
            TrackOf(film,
                    [&](const Moment& m) {
                      return value(m.reward_so_far) == 0.0 ? std::string("    0")
                                                           : fmt::format("{:+5.2f}", value(m.reward_so_far));
                    }),
            {{"class", style}, {"fill", ink}});
  if (never) return;
  for (const bool gain : {true, false}) {
    const Node bar = svg::Add(
        parent, "rect", {{"y", y - 10}, {"height", "11"}, {"fill", gain ? colour::kEgo : colour::kHarm}});
    const auto length = [&](const Moment& m) {
      const double sum = value(m.reward_so_far);
      return columns.unit * std::max(0.0, gain ? sum : -sum);
    };
    Animate(bar, film, "width", TrackOf(film, [&](const Moment& m) { return svg::Number(length(m)); }),
            Motion::kSteps);
    Animate(
        bar, film, "x",
        TrackOf(film,
                [&](const Moment& m) { return svg::Number(gain ? columns.zero : columns.zero - length(m)); }),
        Motion::kSteps);
  }
}

}  // namespace

void DrawDriver(Node parent, const Film& film, const Box& box) {
  const Node group = svg::Add(parent, "g", {{"class", "driver"}});
  const double seconds = film.recording().summary.steps * kStepSeconds;
  AddDigits(
      group, film, {box.x + 74, box.y + 26}, 28,
      TrackOf(film, [](const Moment& m) { return fmt::format("{:4.1f}", m.world.step * kStepSeconds); }),
      {{"class", "strong time"}});
  svg::AddText(group, {box.x + 80, box.y + 26}, fmt::format("s of {:.1f}", seconds),
               {{"fill", colour::kFaint}});
  DrawLaneCommand(group, film, {box.x, box.y + 42, box.width, 28});
  DrawSpeed(group, film, {box.x, box.y + 96, box.width, 60});
}

void DrawReward(Node parent, const Film& film, const Box& box, const char* title) {
  const Node group = svg::Add(parent, "g", {{"class", "reward"}});
  svg::AddText(group, {box.x, box.y}, title, {{"class", "strong"}});
  constexpr double kRow = 20;
  constexpr double kNumbers = 250;
  const Range range = RangeOfSums(film.recording());
  const double unit = (box.width - kNumbers) / (range.high - range.low);
  const RewardColumns columns{.step_end = box.x + 186,
                              .sum_end = box.x + 240,
                              .zero = box.x + kNumbers - unit * range.low,
                              .unit = unit};
  svg::AddText(group, {columns.step_end, box.y}, "this step", {{"class", "small"}, {"text-anchor", "end"}});
  svg::AddText(group, {columns.sum_end, box.y}, "so far", {{"class", "small"}, {"text-anchor", "end"}});
  double y = box.y + kRow;
  for (const RewardRow& row : kRewardRows) {
    DrawRewardRow(group, film, y, columns, box.x, row.words, "number",
                  [&](const RewardTerms& terms) { return terms.*row.term; });
    y += kRow;
  }
  svg::Add(
      group, "path",
      {{"d", fmt::format("M{},{}H{}", svg::Number(box.x), svg::Number(y - 14), svg::Number(box.right()))},
       {"stroke", colour::kLine}});
  DrawRewardRow(group, film, y + 3, columns, box.x, "all together", "number strong",
                [](const RewardTerms& terms) { return terms.Sum(); });
  svg::Add(
      group, "path",
      {{"d", fmt::format("M{},{}V{}", svg::Number(columns.zero), svg::Number(box.y + 6), svg::Number(y + 6))},
       {"stroke", colour::kInk}});
}

}  // namespace dadrl
