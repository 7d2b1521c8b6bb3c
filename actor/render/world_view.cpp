#include "actor/render/world_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "actor/render/car_picture.h"
#include "actor/render/palette.h"
#include "actor/render/road_picture.h"
#include "actor/render/vehicle_visits.h"
#include "actor/task/events.h"

namespace dadrl {
namespace {

using svg::Node;

constexpr double kAttentionShown = 0.02;  // less is nobody's business

std::string RoutePoints(const Recording& recording, const svg::Scale& scale) {
  std::vector<Point> points;
  for (const Point& point : recording.route.centre().points()) points.push_back(scale(point));
  return svg::Points(points);
}

void DrawRoute(Node parent, const Recording& recording, const svg::Scale& scale) {
  svg::Add(parent, "polyline",
           {{"class", "route"},
            {"points", RoutePoints(recording, scale)},
            {"fill", "none"},
            {"stroke", colour::kRoute},
            {"stroke-opacity", "0.55"},
            {"stroke-width", 1.6 * scale.pixels_per_metre},
            {"stroke-linejoin", "round"}});
}

void DrawGoal(Node parent, const Recording& recording, const svg::Scale& scale) {
  const Point goal = scale(recording.route.goal());
  const Node group = svg::Add(parent, "g", {{"class", "goal"}, {"transform", svg::Translate(goal)}});
  svg::Add(group, "circle",
           {{"r", kGoalRadius * scale.pixels_per_metre},
            {"fill", colour::kGood},
            {"fill-opacity", "0.35"},
            {"stroke", colour::kGood},
            {"stroke-width", "2"}});
  svg::Add(group, "path",
           {{"d", "M0,0V-26L17,-20L0,-14"}, {"fill", colour::kGood}, {"stroke", colour::kInk}});
  svg::AddText(group, {4, -31}, "goal", {{"class", "halo strong"}, {"fill", colour::kGood}});
}

// The line the ego has driven, uncovered as it goes.
void DrawTrail(Node parent, const Film& film, const svg::Scale& scale) {
  std::vector<Point> points;
  std::vector<double> driven;  // at each step of the episode, pixels
  double length = 0.0;
  for (const Moment& moment : film.recording().moments) {
    const Point point = scale(moment.world.ego.pose.position);
    if (!points.empty()) length += Norm(point - points.back());
    points.push_back(point);
    driven.push_back(length);
  }
  // Uncovered, not cut: a dash as long as the line, pushed back by what is still to come.
  const double dash = std::ceil(length) + 1.0;
  Track offsets;
  for (size_t i = 0; i < film.size(); ++i) {
    offsets.push_back(svg::Number(dash - driven[static_cast<size_t>(film.index(i))]));
  }
  const Node trail = svg::Add(parent, "polyline",
                              {{"class", "trail"},
                               {"points", svg::Points(points)},
                               {"fill", "none"},
                               {"stroke", colour::kEgo},
                               {"stroke-width", "3"},
                               {"stroke-dasharray", dash}});
  Animate(trail, film, "stroke-dashoffset", offsets, Motion::kSmooth);
}

// A group in world coordinates that moves so that the ego stays in the middle of the view.
Node AddCamera(Node viewport, const Film& film, const WorldView& view) {
  const svg::Scale scale{view.pixels_per_metre};
  Track track;
  for (size_t i = 0; i < film.size(); ++i) {
    const Point ego = scale(film[i].world.ego.pose.position);
    track.push_back(svg::Number(view.box.width / 2 - ego.x) + ' ' + svg::Number(view.box.height / 2 - ego.y));
  }
  const Node camera = svg::Add(viewport, "g", {{"class", "camera"}});
  AnimateTransform(camera, film, "translate", track, Motion::kSmooth);
  return camera;
}

// A line from the ego to each vehicle it looks at, as thick as the weight.
void DrawGazes(Node viewport, const Film& film, const std::vector<VehicleVisit>& visits,
               const WorldView& view) {
  const svg::Scale scale{view.pixels_per_metre};
  const Point middle{view.box.width / 2, view.box.height / 2};
  for (const VehicleVisit& visit : visits) {
    const auto attended = [](double weight) { return weight >= kAttentionShown; };
    if (std::none_of(visit.weights.begin(), visit.weights.end(), attended)) continue;
    Track x, y, width;
    std::vector<bool> visible(film.size(), false);
    for (size_t i = 0; i < visit.poses.size(); ++i) {
      const size_t moment = visit.first + i;
      const Point end =
          middle + (scale(visit.poses[i].position) - scale(film[moment].world.ego.pose.position));
      x.push_back(svg::Number(end.x));
      y.push_back(svg::Number(end.y));
      width.push_back(fmt::format("{:.1f}", 1.0 + 9.0 * visit.weights[i]));
      visible[moment] = attended(visit.weights[i]);
    }
    const Node line = svg::Add(viewport, "line",
                               {{"class", "gaze"},
                                {"x1", middle.x},
                                {"y1", middle.y},
                                {"stroke", colour::kAttention},
                                {"stroke-opacity", "0.75"},
                                {"stroke-linecap", "round"}});
    Animate(line, film, "x2", x, Motion::kSmooth, visit.first);
    Animate(line, film, "y2", y, Motion::kSmooth, visit.first);
    Animate(line, film, "stroke-width", width, Motion::kSteps, visit.first);
    AnimateVisibility(line, film, visible);
  }
}

void DrawScaleBar(Node viewport, const WorldView& view) {
  constexpr double kMetres = 10.0;
  const double y = view.box.height - 14;
  const double width = kMetres * view.pixels_per_metre;
  svg::Add(viewport, "path",
           {{"d", fmt::format("M14,{0}v8h{1}v-8", svg::Number(y - 4), svg::Number(width))},
            {"fill", "none"},
            {"stroke", colour::kInk},
            {"stroke-width", "1.5"}});
  svg::AddText(viewport, {14 + width / 2, y - 2}, "10 m",
               {{"class", "small halo"}, {"text-anchor", "middle"}});
}

void DrawSensorRange(Node viewport, const Film& film, const WorldView& view) {
  const double radius = film.recording().sensor_radius_m * view.pixels_per_metre;
  const Point middle{view.box.width / 2, view.box.height / 2};
  svg::Add(viewport, "circle",
           {{"cx", middle.x},
            {"cy", middle.y},
            {"r", radius},
            {"fill", "none"},
            {"stroke", colour::kAttention},
            {"stroke-width", "1"},
            {"stroke-dasharray", "2 6"}});
  if (!view.names) return;
  svg::AddText(viewport, {middle.x, middle.y + radius - 8},
               fmt::format("orange: how much the policy looks at each car, within {:.0f} m",
                           film.recording().sensor_radius_m),
               {{"class", "small halo"}, {"text-anchor", "middle"}});
}

bool AnyAttention(const Film& film) {
  for (size_t i = 0; i < film.size(); ++i) {
    if (!film[i].attention.empty()) return true;
  }
  return false;
}

// What ended the episode, on its last moment.
void DrawOutcome(Node viewport, const Film& film, const WorldView& view) {
  if (!film.shows_end()) return;
  const Recording& recording = film.recording();
  const std::string sentence = OutcomeSentence(recording);
  const bool success = recording.summary.outcome == Outcome::kSuccess;
  const double font = view.names ? 22 : 15;
  const double width = 0.62 * font * sentence.size() + 24;
  const svg::Box box{(view.box.width - width) / 2, 12, width, font * 1.75};
  const Node banner = svg::Add(viewport, "g", {{"class", "outcome"}});
  svg::AddBox(banner, box, {{"rx", "6"}, {"fill", success ? colour::kGood : colour::kHarm}});
  svg::AddText(
      banner, {box.centre().x, box.centre().y + font * 0.35}, sentence,
      {{"class", "strong"}, {"text-anchor", "middle"}, {"font-size", font}, {"fill", colour::kPaper}});
  std::vector<bool> visible(film.size(), false);
  visible.back() = true;
  AnimateVisibility(banner, film, visible);
}

}  // namespace

void DrawWorld(Node parent, const Film& film, const WorldView& view) {
  const svg::Scale scale{view.pixels_per_metre};
  const std::vector<VehicleVisit> visits = FindVisits(film);
  Node viewport = svg::AddViewport(parent, view.box);
  viewport.append_attribute("class") = "world";
  svg::Add(viewport, "rect", {{"width", "100%"}, {"height", "100%"}, {"fill", colour::kGround}});
  const Node ground = AddCamera(viewport, film, view);
  svg::Add(ground, "use",
           {{"href", "#road"}, {"transform", fmt::format("scale({})", svg::Number(view.pixels_per_metre))}});
  DrawRoute(ground, film.recording(), scale);
  DrawTrail(ground, film, scale);
  if (AnyAttention(film)) DrawSensorRange(viewport, film, view);
  DrawGazes(viewport, film, visits, view);
  const Node above = AddCamera(viewport, film, view);
  DrawGoal(above, film.recording(), scale);
  const CarStyle style{scale, view.names, kAttentionShown};
  for (const VehicleVisit& visit : visits) DrawCar(above, film, visit, style);
  DrawEgo(viewport, film, {view.box.width / 2, view.box.height / 2}, scale);
  const Node labels = AddCamera(viewport, film, view);
  for (const VehicleVisit& visit : visits) DrawWeight(labels, film, visit, style);
  DrawScaleBar(viewport, view);
  DrawOutcome(viewport, film, view);
}

void DrawOverview(Node parent, const Film& film, const svg::Box& box) {
  constexpr double kMargin = 8.0;
  const Extent extent = ExtentOf(film.recording().map);
  const Point size = extent.high - extent.low;
  const svg::Scale scale{std::min((box.width - 2 * kMargin) / size.x, (box.height - 2 * kMargin) / size.y)};
  const Point middle = scale(extent.low + 0.5 * size);
  Node viewport = svg::AddViewport(parent, box);
  viewport.append_attribute("class") = "overview";
  svg::Add(viewport, "rect",
           {{"width", "100%"}, {"height", "100%"}, {"fill", colour::kPaper}, {"stroke", colour::kFaint}});
  const Node map = svg::Add(
      viewport, "g", {{"transform", svg::Translate({box.width / 2 - middle.x, box.height / 2 - middle.y})}});
  svg::Add(map, "use",
           {{"href", "#road"}, {"transform", fmt::format("scale({:.4g})", scale.pixels_per_metre)}});
  svg::Add(map, "polyline",
           {{"points", RoutePoints(film.recording(), scale)},
            {"fill", "none"},
            {"stroke", colour::kRoute},
            {"stroke-width", "3"}});
  const Point goal = scale(film.recording().route.goal());
  svg::Add(map, "path",
           {{"d", "M0,0V-14L9,-10.5L0,-7"},
            {"transform", svg::Translate(goal)},
            {"fill", colour::kGood},
            {"stroke", colour::kInk},
            {"stroke-width", "0.8"}});
  Track track;
  for (size_t i = 0; i < film.size(); ++i) {
    const Point ego = scale(film[i].world.ego.pose.position);
    track.push_back(svg::Number(ego.x) + ' ' + svg::Number(ego.y));
  }
  const Node ego =
      svg::Add(map, "circle",
               {{"r", "4.5"}, {"fill", colour::kEgo}, {"stroke", colour::kPaper}, {"stroke-width", "1.5"}});
  AnimateTransform(ego, film, "translate", track, Motion::kSmooth);
}

}  // namespace dadrl
