#include "actor/sensing/birds_eye_view.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <utility>

namespace dadrl {
namespace {

constexpr int kSize = ObservationSpec::kContextSize;
constexpr size_t kPlaneBytes = ObservationSpec::kContextBytes / ObservationSpec::kContextPlanes;
constexpr double kCellMetres = 0.2;
// Half the diagonal of a view, and how far off the network's bounds the ego's centre may be (off-road ends an
// episode long before).
constexpr double kPadding = 0.5 * kViewSide * std::numbers::sqrt2 + 5.0;
constexpr double kPixelCells = kPixelMetres / kCellMetres;
constexpr double kFixedOne = 65536.0;  // of GridSquare

static_assert(std::endian::native == std::endian::little, "the route's plane is copied as words");
static_assert(kSize % 32 == 0, "a row of a plane is whole words");

struct Bounds {
  Point low{std::numeric_limits<double>::max(), std::numeric_limits<double>::max()};
  Point high{std::numeric_limits<double>::lowest(), std::numeric_limits<double>::lowest()};

  void Add(Point p, double margin) {
    low = {std::min(low.x, p.x - margin), std::min(low.y, p.y - margin)};
    high = {std::max(high.x, p.x + margin), std::max(high.y, p.y + margin)};
  }
};

Bounds BoundsOf(const RoadMap& map) {
  Bounds bounds;
  for (const Lane& lane : map.lanes()) {
    for (const Point p : lane.centre.points()) bounds.Add(p, lane.width / 2);
  }
  for (const auto& junction : map.junctions()) {
    for (const Point p : junction) bounds.Add(p, 0.0);
  }
  return bounds;
}

BitGrid EmptyGrid(const Bounds& bounds) {
  const Point size = bounds.high - bounds.low;
  return {static_cast<int>(std::ceil((size.x + 2 * kPadding) / kCellMetres)),
          static_cast<int>(std::ceil((size.y + 2 * kPadding) / kCellMetres))};
}

void FillLane(const Lane& lane, Point origin, BitGrid& grid) {
  const std::vector<Point>& points = lane.centre.points();
  const auto cell = [&](size_t i) { return (1.0 / kCellMetres) * (points[i] - origin); };
  const double half_width = lane.width / 2 / kCellMetres;
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    grid.FillStrip(cell(i), cell(i + 1), half_width, BitGrid::Ends::kSquare);
    // The wedge that two rectangles leave open on the outside of a bend.
    if (i > 0) grid.FillStrip(cell(i), cell(i), half_width, BitGrid::Ends::kRound);
  }
}

BitGrid DrivableGrid(const RoadMap& map, Point origin) {
  BitGrid grid = EmptyGrid(BoundsOf(map));
  for (const Lane& lane : map.lanes()) FillLane(lane, origin, grid);
  std::vector<Point> polygon;
  for (const auto& junction : map.junctions()) {
    polygon.clear();
    for (const Point p : junction) polygon.push_back((1.0 / kCellMetres) * (p - origin));
    grid.FillPolygon(polygon);
  }
  return grid;
}

}  // namespace

BirdsEyeView::BirdsEyeView(const RoadMap& map, const Route& route)
    : route_(route),
      origin_(BoundsOf(map).low - Point{kPadding, kPadding}),
      drivable_(DrivableGrid(map, origin_), kPixelCells),
      route_plane_(kSize, kSize) {}

void BirdsEyeView::Draw(const Pose& ego, double route_s, std::span<uint8_t> out) {
  assert(out.size() == ObservationSpec::kContextBytes);
  DrawDrivable(ego, out.first(kPlaneBytes));
  DrawRoute(ego, route_s, out.last(kPlaneBytes));
}

void BirdsEyeView::DrawDrivable(const Pose& ego, std::span<uint8_t> plane) const {
  const Point centre = (1.0 / kCellMetres) * (ego.position - origin_);
  const double reach = 0.5 * kViewSide * std::numbers::sqrt2 / kCellMetres + 2.0;
  const BitGrid& grid = drivable_.grid();
  if (!(centre.x >= reach && centre.y >= reach && centre.x <= grid.width() - reach &&
        centre.y <= grid.height() - reach)) {
    std::ranges::fill(plane, uint8_t{0});
    return;
  }
  const Point up = kPixelCells * Forward(ego.heading);
  const Point right{up.y, -up.x};
  GridSquare square;
  square.step_x = static_cast<int32_t>(std::lround(right.x * kFixedOne));
  square.step_y = static_cast<int32_t>(std::lround(right.y * kFixedOne));
  for (int row = 0; row < kSize; ++row) {
    const Point start = centre + (kSize / 2.0 - row - 0.5) * up + (0.5 - kSize / 2.0) * right;
    // The nearest: they are positive.
    square.x[static_cast<size_t>(row)] = static_cast<int32_t>(start.x * kFixedOne + 0.5);
    square.y[static_cast<size_t>(row)] = static_cast<int32_t>(start.y * kFixedOne + 0.5);
  }
  drivable_.Sample(square, plane);
}

void BirdsEyeView::DrawRoute(const Pose& ego, double route_s, std::span<uint8_t> plane) {
  const Polyline& line = route_.centre();
  const double end = std::min(route_s + kRouteAhead, line.length());
  const Frame frame(ego);
  const auto pixel = [&](Point world) {
    const Point local = frame.ToLocal(world);
    return Point{(kViewSide / 2 - local.y) / kPixelMetres, (kViewSide / 2 - local.x) / kPixelMetres};
  };
  route_plane_.Clear();
  Point from = pixel(line.At(route_s));
  const auto& arc = line.arc();
  for (auto next = std::ranges::upper_bound(arc, route_s); next != arc.end() && *next < end; ++next) {
    const Point to = pixel(line.points()[static_cast<size_t>(next - arc.begin())]);
    route_plane_.FillStrip(from, to, kRouteHalfWidth / kPixelMetres, BitGrid::Ends::kRound);
    from = to;
  }
  route_plane_.FillStrip(from, pixel(line.At(end)), kRouteHalfWidth / kPixelMetres, BitGrid::Ends::kRound);
  std::memcpy(plane.data(), route_plane_.words().data(), plane.size());
}

}  // namespace dadrl
