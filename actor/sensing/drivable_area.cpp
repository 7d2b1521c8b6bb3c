#include "actor/sensing/drivable_area.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace dadrl {
namespace {

// How far off the network's bounds the ego's centre may be (off-road ends an episode long before).
constexpr double kOffNetwork = 5.0;
// A network up to this size is one bitmap; larger ones are cut into squares so far from each other.
constexpr double kWholeMetres = 800.0;
constexpr double kStrideMetres = 128.0;
constexpr size_t kSquaresKept = 32;

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

// Whether a strip of `half_width` from a to b can touch the rectangle.
bool MayTouch(Point a, Point b, double half_width, Point low, Point high) {
  return std::max(a.x, b.x) + half_width >= low.x && std::min(a.x, b.x) - half_width <= high.x &&
         std::max(a.y, b.y) + half_width >= low.y && std::min(a.y, b.y) - half_width <= high.y;
}

int Cells(double metres) { return static_cast<int>(std::ceil(metres / DrivableArea::kCellMetres)); }

}  // namespace

DrivableArea::DrivableArea(const RoadMap& map, const Route& route, double reach, double spacing)
    : map_(map), route_(route), reach_(reach), spacing_(spacing) {
  const Bounds bounds = BoundsOf(map);
  const double padding = reach + kOffNetwork;
  low_ = bounds.low - Point{padding, padding};
  high_ = bounds.high + Point{padding, padding};
  const Point extent = high_ - low_;
  if (std::max(extent.x, extent.y) <= kWholeMetres) {
    stride_ = kWholeMetres;
    size_ = extent;
    Around(bounds.low);
  } else {
    stride_ = kStrideMetres;
    size_ = {kStrideMetres + 2 * padding, kStrideMetres + 2 * padding};
  }
}

const DrivableArea::Bitmap* DrivableArea::Around(Point point) {
  const double margin = Margin();
  if (!(point.x - margin >= low_.x && point.y - margin >= low_.y && point.x + margin <= high_.x &&
        point.y + margin <= high_.y)) {
    return nullptr;
  }
  // The squares begin where the first that can be looked from begins.
  const Point inside = point - low_ - Point{margin, margin};
  const SquareIndex square{static_cast<int64_t>(inside.y / stride_),
                           static_cast<int64_t>(inside.x / stride_)};
  auto found = squares_.find(square);
  if (found == squares_.end()) {
    if (squares_.size() == kSquaresKept) {
      squares_.erase(
          std::ranges::min_element(squares_, {}, [](const auto& entry) { return entry.second.looked_at; }));
    }
    found = squares_.emplace(square, Kept{DrawSquare(square)}).first;
  }
  found->second.looked_at = ++looks_;
  return found->second.bitmap.get();
}

std::unique_ptr<DrivableArea::Bitmap> DrivableArea::DrawSquare(SquareIndex square) const {
  const Point origin = low_ + Point{square.second * stride_, square.first * stride_};
  BitGrid grid(Cells(size_.x), Cells(size_.y));
  DrawLanes(origin, grid);
  std::vector<Point> polygon;
  for (const auto& junction : map_.junctions()) {
    polygon.clear();
    for (const Point p : junction) polygon.push_back((1.0 / kCellMetres) * (p - origin));
    grid.FillPolygon(polygon);
  }
  return std::make_unique<Bitmap>(Bitmap{origin, BitSampler(std::move(grid), spacing_)});
}

void DrivableArea::DrawLanes(Point origin, BitGrid& grid) const {
  for (const Lane& lane : map_.lanes()) {
    const std::vector<Point>& points = lane.centre.points();
    const std::vector<double>& arc = lane.centre.arc();
    const auto cell = [&](size_t i) { return (1.0 / kCellMetres) * (points[i] - origin); };
    const double half_width = lane.width / 2 / kCellMetres;
    for (size_t i = 0; i + 1 < points.size(); ++i) {
      if (!MayTouch(points[i], points[i + 1], lane.width / 2, origin, origin + size_)) continue;
      if (!OnRouteLevel(lane, (arc[i] + arc[i + 1]) / 2)) continue;
      grid.FillStrip(cell(i), cell(i + 1), half_width, BitGrid::Ends::kSquare);
      // The wedge that two rectangles leave open on the outside of a bend.
      if (i > 0) grid.FillStrip(cell(i), cell(i), half_width, BitGrid::Ends::kRound);
    }
  }
}

bool DrivableArea::OnRouteLevel(const Lane& lane, double s) const {
  if (!map_.has_levels()) return true;
  const Polyline::Projection nearest = route_.centre().Project(lane.centre.At(s));
  return OnOneLevel(lane.centre.ElevationAt(s) - route_.centre().ElevationAt(nearest.s), nearest.distance);
}

}  // namespace dadrl
