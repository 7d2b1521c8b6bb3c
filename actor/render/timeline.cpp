#include "actor/render/timeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "actor/render/palette.h"

namespace dadrl {
namespace {

using svg::Box;
using svg::Node;

// Maps time and speed into the plot.
struct Axes {
  Box plot;
  double seconds;
  double top_speed;
  double X(double second) const { return plot.x + plot.width * second / seconds; }
  double Y(double speed) const { return plot.bottom() - plot.height * speed / top_speed; }
};

Axes MakeAxes(const Recording& recording, const Box& plot) {
  double top = recording.max_speed_mps;
  for (const Moment& moment : recording.moments) {
    top = std::max(top, moment.world.ego.speed_mps);
    if (moment.command) top = std::max(top, moment.command->target_speed_mps);
  }
  return {plot, std::max(kStepSeconds, recording.summary.steps * kStepSeconds), 5.0 * std::ceil(top / 5.0)};
}

// A round distance of about `wanted` ticks.
double TickDistance(double range, double wanted) {
  for (const double distance : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0}) {
    if (range / distance <= wanted) return distance;
  }
  return 50.0;
}

void DrawGrid(Node parent, const Axes& axes) {
  const auto line = [&](double x0, double y0, double x1, double y1) {
    svg::Add(parent, "line", {{"x1", x0}, {"y1", y0}, {"x2", x1}, {"y2", y1}, {"stroke", colour::kLine}});
  };
  for (double speed = 0.0; speed <= axes.top_speed; speed += 5.0) {
    line(axes.plot.x, axes.Y(speed), axes.plot.right(), axes.Y(speed));
    const bool top = speed + 5.0 > axes.top_speed;
    svg::AddText(parent, {axes.plot.x - 6, axes.Y(speed) + 4},
                 fmt::format(fmt::runtime(top ? "{:.0f} m/s" : "{:.0f}"), speed),
                 {{"class", "small"}, {"text-anchor", "end"}});
  }
  const double distance = TickDistance(axes.seconds, 12);
  for (double second = 0.0; second <= axes.seconds + 1e-9; second += distance) {
    line(axes.X(second), axes.plot.bottom(), axes.X(second), axes.plot.bottom() + 4);
    svg::AddText(parent, {axes.X(second), axes.plot.bottom() + 17}, fmt::format("{:g} s", second),
                 {{"class", "small"}, {"text-anchor", "middle"}});
  }
}

// Where they end, one above the other.
void NameCurves(Node parent, const Axes& axes, double speed_y, std::optional<double> target_y) {
  constexpr double kLine = 14;
  const double x = axes.plot.right() + 13;
  const double lowest = axes.plot.bottom() - 3;
  double speed_text = std::min(speed_y + 4, lowest);
  if (target_y) {
    double target_text = std::min(*target_y + 4, lowest);
    double& upper = speed_y < *target_y ? speed_text : target_text;
    const double lower = std::max(speed_text, target_text);
    upper = std::min(upper, lower - kLine);
    svg::AddText(parent, {x, target_text}, "asked for", {{"class", "small"}, {"fill", colour::kFaint}});
  }
  svg::AddText(parent, {x, speed_text}, "speed", {{"class", "small strong"}, {"fill", colour::kEgo}});
}

void DrawCurves(Node parent, const Recording& recording, const Axes& axes) {
  std::vector<Point> speed;
  std::vector<Point> target;
  for (const Moment& moment : recording.moments) {
    const double x = axes.X(moment.world.step * kStepSeconds);
    speed.push_back({x, axes.Y(moment.world.ego.speed_mps)});
    if (!moment.command) continue;
    const double y = axes.Y(moment.command->target_speed_mps);
    if (!target.empty()) target.push_back({x, target.back().y});
    target.push_back({x, y});
  }
  if (!target.empty()) {
    svg::Add(parent, "polyline",
             {{"class", "target"},
              {"points", svg::Points(target)},
              {"fill", "none"},
              {"stroke", colour::kFaint},
              {"stroke-width", "1.5"},
              {"stroke-dasharray", "4 3"}});
  }
  svg::Add(parent, "polyline",
           {{"class", "speed"},
            {"points", svg::Points(speed)},
            {"fill", "none"},
            {"stroke", colour::kEgo},
            {"stroke-width", "2.5"}});
  NameCurves(parent, axes, speed.back().y, target.empty() ? std::nullopt : std::optional(target.back().y));
}

struct SpanRow {
  const char* words;
  const char* colour;
  std::function<bool(const Moment&)> holds;
};

std::vector<SpanRow> SpanRows() {
  const auto lane = [](int wanted) {
    return [wanted](const Moment& moment) { return moment.command && moment.command->lane == wanted; };
  };
  return {{"lane left", colour::kEgo, lane(1)},
          {"lane right", colour::kEgo, lane(-1)},
          {"off route", colour::kHarm, [](const Moment& moment) { return moment.events.off_route; }},
          {"wrong way", colour::kHarm, [](const Moment& moment) { return moment.events.wrong_way; }}};
}

// Those that happen at all.
std::vector<SpanRow> RowsInUse(const Recording& recording) {
  std::vector<SpanRow> rows = SpanRows();
  std::erase_if(rows, [&](const SpanRow& row) {
    return std::none_of(recording.moments.begin(), recording.moments.end(), row.holds);
  });
  return rows;
}

constexpr double kSpanRow = 14;

void DrawSpans(Node parent, const Recording& recording, const std::vector<SpanRow>& rows, const Axes& axes) {
  double y = axes.plot.bottom() + 32;
  const int steps = std::ssize(recording.moments);
  for (const SpanRow& row : rows) {
    svg::AddText(parent, {axes.plot.x - 6, y + 4}, row.words,
                 {{"class", "small"}, {"text-anchor", "end"}, {"fill", row.colour}});
    for (int begin = 0; begin < steps;) {
      int end = begin;
      while (end < steps && row.holds(recording.moments[static_cast<size_t>(end)])) ++end;
      if (end > begin) {
        const double left = axes.X(begin * kStepSeconds);
        const double right = std::min(axes.plot.right(), axes.X(end * kStepSeconds));
        svg::AddBox(parent, {left, y - 4, std::max(2.0, right - left), 8}, {{"fill", row.colour}});
      }
      begin = std::max(end, begin + 1);
    }
    y += kSpanRow;
  }
}

void DrawMarks(Node parent, const std::vector<TimelineMark>& marks, const Axes& axes) {
  for (const TimelineMark& mark : marks) {
    const double x = axes.X(mark.moment * kStepSeconds);
    svg::Add(
        parent, "line",
        {{"x1", x}, {"x2", x}, {"y1", axes.plot.y}, {"y2", axes.plot.bottom()}, {"stroke", colour::kInk}});
    svg::Add(parent, "circle", {{"cx", x}, {"cy", axes.plot.y - 9}, {"r", "9"}, {"fill", colour::kInk}});
    svg::AddText(parent, {x, axes.plot.y - 5}, mark.label,
                 {{"class", "small strong"}, {"text-anchor", "middle"}, {"fill", colour::kPaper}});
  }
}

void DrawCursor(Node parent, const Film& film, const Axes& axes) {
  Track track;
  for (size_t i = 0; i < film.size(); ++i) track.push_back(svg::Number(axes.X(film.index(i) * kStepSeconds)));
  const Node cursor =
      svg::Add(parent, "path",
               {{"class", "cursor"},
                {"d", fmt::format("M0,{}V{}", svg::Number(axes.plot.y - 4), svg::Number(axes.plot.bottom()))},
                {"stroke", colour::kInk},
                {"stroke-width", "1.5"}});
  AnimateTransform(cursor, film, "translate", track, Motion::kSmooth);
}

}  // namespace

void DrawTimeline(Node parent, const Film& film, const Box& box, const std::vector<TimelineMark>& marks) {
  const Node group = svg::Add(parent, "g", {{"class", "timeline"}});
  const std::vector<SpanRow> rows = RowsInUse(film.recording());
  const double below = 26 + kSpanRow * rows.size();
  const Box plot{box.x + 68, box.y + 22, box.width - 68 - 72, box.height - 22 - below};
  const Axes axes = MakeAxes(film.recording(), plot);
  DrawGrid(group, axes);
  DrawCurves(group, film.recording(), axes);
  DrawSpans(group, film.recording(), rows, axes);
  DrawMarks(group, marks, axes);
  if (marks.empty()) DrawCursor(group, film, axes);
}

}  // namespace dadrl
