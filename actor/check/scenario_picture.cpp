#include "actor/check/scenario_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <pugixml.hpp>
#include <sstream>
#include <utility>

#include "actor/check/scenario_warnings.h"
#include "actor/render/palette.h"
#include "actor/render/road_picture.h"
#include "actor/render/svg.h"

namespace dadrl {
namespace {

using svg::Node;

constexpr double kMargin = 40.0;       // metres around what matters
constexpr double kLongestSide = 1000;  // pixels
constexpr double kHeader = 56;
// A flow may come from far away; what is farther than this from the route is left out.
constexpr double kFarMetres = 300.0;

void Include(Extent& extent, Point point) {
  extent.low = {std::min(extent.low.x, point.x), std::min(extent.low.y, point.y)};
  extent.high = {std::max(extent.high.x, point.x), std::max(extent.high.y, point.y)};
}

Extent Enlarged(const Extent& extent, double by) {
  return {extent.low - Point{by, by}, extent.high + Point{by, by}};
}

bool Inside(const Extent& extent, Point point) {
  return point.x >= extent.low.x && point.x <= extent.high.x && point.y >= extent.low.y &&
         point.y <= extent.high.y;
}

Extent ShownExtent(const DrivingEnvironment& environment, const Scenario& scenario) {
  const std::vector<Point>& route = environment.route().centre().points();
  Extent extent{route.front(), route.front()};
  for (const Point point : route) Include(extent, point);
  const Extent near = Enlarged(extent, kFarMetres);
  for (const TrafficFlow& flow : scenario.flows) {
    for (const Lane* lane : LanesOfFlow(environment.map(), flow)) {
      for (const Point point : lane->centre.points()) {
        if (Inside(near, point)) Include(extent, point);
      }
    }
  }
  return Enlarged(extent, kMargin);
}

// The part of the map that is shown: drawing takes what is near, not what the network has.
RoadMap PartOf(const RoadMap& map, const Extent& extent) {
  std::vector<Lane> lanes;
  for (const Lane& lane : map.lanes()) {
    Extent box{lane.centre.points().front(), lane.centre.points().front()};
    for (const Point point : lane.centre.points()) Include(box, point);
    if (box.high.x < extent.low.x || box.low.x > extent.high.x || box.high.y < extent.low.y ||
        box.low.y > extent.high.y) {
      continue;
    }
    lanes.push_back(lane);
    lanes.back().successors.clear();
  }
  std::vector<std::vector<Point>> junctions;
  for (const auto& junction : map.junctions()) {
    if (std::ranges::any_of(junction, [&](Point point) { return Inside(extent, point); })) {
      junctions.push_back(junction);
    }
  }
  return RoadMap(std::move(lanes), std::move(junctions));
}

class Drawing {
 public:
  Drawing(Node parent, const Extent& extent, double pixels_per_metre)
      : parent_(parent), low_(extent.low), high_(extent.high), scale_{pixels_per_metre} {}

  Point At(Point world) const { return scale_({world.x - low_.x, world.y - high_.y}); }

  void Line(const Polyline& line, const char* kind, const char* colour, double width, const char* opacity) {
    std::vector<Point> points;
    for (const Point point : line.points()) points.push_back(At(point));
    svg::Add(parent_, "polyline",
             {{"class", kind},
              {"points", svg::Points(points)},
              {"fill", "none"},
              {"stroke", colour},
              {"stroke-width", width},
              {"stroke-opacity", opacity},
              {"stroke-linejoin", "round"}});
  }

  void Box(const OrientedBox& box, const char* kind, const char* colour) {
    const double length = box.length * scale_.pixels_per_metre;
    const double width = box.width * scale_.pixels_per_metre;
    const Node group =
        svg::Add(parent_, "g",
                 {{"class", kind},
                  {"transform", fmt::format("{} rotate({})", svg::Translate(At(box.pose.position)),
                                            svg::Number(svg::Degrees(box.pose.heading)))}});
    svg::AddBox(group, {-length / 2, -width / 2, length, width},
                {{"fill", colour}, {"stroke", colour::kInk}, {"stroke-width", "0.8"}});
  }

  void Mark(Point world, const char* colour, const std::string& word) {
    svg::Add(parent_, "circle",
             {{"cx", At(world).x}, {"cy", At(world).y}, {"r", "6"}, {"fill", colour}, {"stroke", "#fff"}});
    svg::AddText(parent_, At(world) + Point{9, -7}, word,
                 {{"fill", colour},
                  {"font-weight", "bold"},
                  {"stroke", "#fff"},
                  {"stroke-width", "3"},
                  {"paint-order", "stroke"}});
  }

 private:
  Node parent_;
  Point low_;
  Point high_;
  svg::Scale scale_;
};

void DrawScene(Drawing& drawing, const DrivingEnvironment& environment, const Scenario& scenario) {
  for (const TrafficFlow& flow : scenario.flows) {
    for (const Lane* lane : LanesOfFlow(environment.map(), flow)) {
      drawing.Line(lane->centre, "flow", colour::kAttention, 3, "0.7");
    }
  }
  const Route& route = environment.route();
  drawing.Line(route.centre(), "route", colour::kRoute, 5, "0.9");
  for (const SocialVehicle& vehicle : environment.world().vehicles) {
    drawing.Box(vehicle.box(), "car", colour::kCar);
  }
  const EgoState& ego = environment.world().ego;
  drawing.Box({ego.pose, kVehicleLength, kVehicleWidth}, "ego", colour::kEgo);
  drawing.Mark(ego.pose.position, colour::kEgo, "start");
  drawing.Mark(route.goal(), colour::kGood, "goal");
}

}  // namespace

std::string ScenarioPicture(const DrivingEnvironment& environment, const Scenario& scenario) {
  const Extent extent = ShownExtent(environment, scenario);
  const Point metres = extent.high - extent.low;
  const double pixels_per_metre = kLongestSide / std::max(metres.x, metres.y);
  const svg::Box box{0, kHeader, metres.x * pixels_per_metre, metres.y * pixels_per_metre};
  pugi::xml_document document;
  const Node root =
      svg::Add(document, "svg",
               {{"xmlns", "http://www.w3.org/2000/svg"},
                {"width", box.width},
                {"height", box.bottom()},
                {"font-family", "'DejaVu Sans',Verdana,sans-serif"},
                {"font-size", "13px"},
                {"fill", colour::kInk},
                {"viewBox", fmt::format("0 0 {} {}", svg::Number(box.width), svg::Number(box.bottom()))}});
  DefineRoad(svg::Add(root, "defs"), PartOf(environment.map(), extent));
  svg::AddBox(root, {0, 0, box.width, box.bottom()}, {{"fill", colour::kPaper}});
  svg::AddText(root, {12, 24}, scenario.name, {{"font-size", "18"}, {"font-weight", "bold"}});
  svg::AddText(root, {12, 44},
               fmt::format("blue: the ego's way, {:.0f} m; orange: traffic; {:.0f} m wide, north up",
                           environment.route().length(), metres.x));
  const Node view = svg::AddViewport(root, box);
  svg::AddBox(view, {0, 0, box.width, box.height}, {{"fill", colour::kGround}});
  svg::Add(view, "use",
           {{"href", "#road"},
            {"transform", fmt::format("scale({:.4f}) translate({:.2f} {:.2f})", pixels_per_metre,
                                      -extent.low.x, extent.high.y)}});
  Drawing drawing(view, extent, pixels_per_metre);
  DrawScene(drawing, environment, scenario);
  std::ostringstream stream;
  document.save(stream, "", pugi::format_raw | pugi::format_no_declaration);
  return stream.str();
}

}  // namespace dadrl
