#include "actor/sensing/birds_eye_view.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numbers>
#include <utility>

namespace dadrl {
namespace {

constexpr int kSize = DrivingShape::kContextSize;
constexpr size_t kPlaneBytes = DrivingShape::kContextBytes / DrivingShape::kContextPlanes;
constexpr double kCellMetres = DrivableArea::kCellMetres;
// Half the diagonal of a view.
constexpr double kReach = 0.5 * kViewSide * std::numbers::sqrt2;
constexpr double kPixelCells = kPixelMetres / kCellMetres;
constexpr double kFixedOne = 65536.0;  // of GridSquare

static_assert(std::endian::native == std::endian::little, "the route's plane is copied as words");
static_assert(kSize % 32 == 0, "a row of a plane is whole words");

}  // namespace

BirdsEyeView::BirdsEyeView(const RoadMap& map, const Route& route)
    : route_(route), drivable_(map, route, kReach, kPixelCells), route_plane_(kSize, kSize) {}

void BirdsEyeView::Draw(const Pose& ego, double route_s, std::span<uint8_t> out) {
  assert(out.size() == DrivingShape::kContextBytes);
  DrawDrivable(ego, out.first(kPlaneBytes));
  DrawRoute(ego, route_s, out.last(kPlaneBytes));
}

void BirdsEyeView::DrawDrivable(const Pose& ego, std::span<uint8_t> plane) {
  const DrivableArea::Bitmap* const bitmap = drivable_.Around(ego.position);
  if (bitmap == nullptr) {
    std::ranges::fill(plane, uint8_t{0});
    return;
  }
  const Point centre = (1.0 / kCellMetres) * (ego.position - bitmap->origin);
  const Point up = kPixelCells * Forward(ego.heading);
  const Point right{up.y, -up.x};
  GridSquare square;
  square.step_x = std::lround(right.x * kFixedOne);
  square.step_y = std::lround(right.y * kFixedOne);
  for (int row = 0; row < kSize; ++row) {
    const Point start = centre + (kSize / 2.0 - row - 0.5) * up + (0.5 - kSize / 2.0) * right;
    // The nearest: they are positive.
    square.x.data()[row] = start.x * kFixedOne + 0.5;
    square.y.data()[row] = start.y * kFixedOne + 0.5;
  }
  bitmap->cells.Sample(square, plane);
}

void BirdsEyeView::DrawRoute(const Pose& ego, double route_s, std::span<uint8_t> plane) {
  const Polyline& line = route_.centre();
  const double end = std::min(route_s + kRouteAhead, line.length());
  const LocalFrame frame(ego);
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
