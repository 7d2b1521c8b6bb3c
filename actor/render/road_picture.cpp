#include "actor/render/road_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "actor/render/palette.h"

namespace dadrl {
namespace {

using svg::Node;

constexpr svg::Scale kMetres{1.0};
constexpr double kOverlap = 0.08;  // closes the seams between lanes and junctions
constexpr double kEdgeLine = kOverlap + 0.25;
constexpr double kArrowEvery = 18.0;
constexpr double kArrowFromEnd = 7.0;

std::vector<Point> OnPaper(const std::vector<Point>& points) {
  std::vector<Point> paper;
  paper.reserve(points.size());
  for (const Point& point : points) paper.push_back(kMetres(point));
  return paper;
}

// Parallel to the line, `left` metres to its left.
std::vector<Point> Beside(const Polyline& line, double left) {
  std::vector<Point> points;
  for (size_t i = 0; i < line.points().size(); ++i) {
    const double before = line.HeadingAt(line.arc()[i] - 1e-3);
    const double after = line.HeadingAt(line.arc()[i] + 1e-3);
    const double heading = before + WrapAngle(after - before) / 2;
    const Point normal{-std::sin(heading), std::cos(heading)};
    points.push_back(line.points()[i] + left * normal);
  }
  return points;
}

// Lanes and junctions with a border of `border` metres.
void AddArea(Node parent, const RoadMap& map, const char* colour, double border) {
  const Node area =
      svg::Add(parent, "g", {{"stroke", colour}, {"fill", colour}, {"stroke-linejoin", "round"}});
  for (const auto& junction : map.junctions()) {
    svg::Add(area, "polygon", {{"points", svg::Points(OnPaper(junction))}, {"stroke-width", 2 * border}});
  }
  for (const Lane& lane : map.lanes()) {
    svg::Add(area, "polyline",
             {{"points", svg::Points(OnPaper(lane.centre.points()))},
              {"fill", "none"},
              {"stroke-width", lane.width + 2 * border}});
  }
}

bool HasLeftNeighbour(const RoadMap& map, const Lane& lane) {
  return std::any_of(map.lanes().begin(), map.lanes().end(), [&](const Lane& other) {
    return other.edge == lane.edge && other.index == lane.index + 1;
  });
}

// Whether traffic runs the other way right beside the lane.
bool OncomingBeside(const RoadMap& map, const Lane& lane) {
  const double middle = lane.centre.length() / 2;
  const double heading = lane.centre.HeadingAt(middle);
  const Point normal{-std::sin(heading), std::cos(heading)};
  const Point beside = lane.centre.At(middle) + lane.width * normal;
  const auto found = map.NearestLane(beside, heading, lane.width / 2);
  return found && std::cos(found->heading - heading) < -0.7;
}

void AddLeftBorder(Node parent, const RoadMap& map, const Lane& lane) {
  const std::string points = svg::Points(OnPaper(Beside(lane.centre, lane.width / 2)));
  if (HasLeftNeighbour(map, lane)) {
    svg::Add(parent, "polyline",
             {{"points", points}, {"stroke", colour::kMarking}, {"stroke-dasharray", "3 4.5"}});
  } else if (OncomingBeside(map, lane)) {
    svg::Add(parent, "polyline", {{"points", points}, {"stroke", colour::kCentreLine}});
  }
}

void AddArrows(Node parent, const Lane& lane) {
  for (double s = lane.centre.length() - kArrowFromEnd; s > kArrowFromEnd / 2; s -= kArrowEvery) {
    const Point at = kMetres(lane.centre.At(s));
    svg::Add(parent, "path",
             {{"d", "M-2,0H.6M-.3,-.7L.8,0L-.3,.7"},
              {"transform", fmt::format("{} rotate({})", svg::Translate(at),
                                        svg::Number(svg::Degrees(lane.centre.HeadingAt(s))))}});
  }
}

}  // namespace

void DefineRoad(Node defs, const RoadMap& map) {
  const Node road = svg::Add(defs, "g", {{"id", "road"}, {"stroke-linecap", "butt"}});
  AddArea(road, map, colour::kMarking, kEdgeLine);
  AddArea(road, map, colour::kAsphalt, kOverlap);
  const Node markings = svg::Add(road, "g", {{"fill", "none"}, {"stroke-width", 0.18}});
  const Node arrows = svg::Add(
      road, "g",
      {{"fill", "none"}, {"stroke", colour::kMarking}, {"stroke-width", 0.22}, {"stroke-opacity", "0.55"}});
  for (const Lane& lane : map.lanes()) {
    if (lane.internal) continue;
    AddLeftBorder(markings, map, lane);
    AddArrows(arrows, lane);
  }
}

Extent ExtentOf(const RoadMap& map) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Extent extent{{kFar, kFar}, {-kFar, -kFar}};
  for (const Lane& lane : map.lanes()) {
    for (const Point& point : lane.centre.points()) {
      extent.low = {std::min(extent.low.x, point.x), std::min(extent.low.y, point.y)};
      extent.high = {std::max(extent.high.x, point.x), std::max(extent.high.y, point.y)};
    }
  }
  return extent;
}

}  // namespace dadrl
