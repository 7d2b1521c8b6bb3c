#include "actor/sim/polyline.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace dadrl {
namespace {

constexpr double kMinSpacing = 1e-3;
constexpr size_t kBlockSegments = 16;

// First index i such that arc[i + 1] >= s, kept a valid segment.
size_t SegmentAt(const std::vector<double>& arc, double s) {
  const auto next = std::lower_bound(arc.begin() + 1, arc.end() - 1, s);
  return static_cast<size_t>(next - arc.begin()) - 1;
}

}  // namespace

Polyline::Polyline(const std::vector<Point>& points, const std::vector<double>& elevations) {
  const bool flat = std::ranges::all_of(elevations, [](double elevation) { return elevation == 0.0; });
  points_.reserve(points.size());
  arc_.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const double spacing = points_.empty() ? 0.0 : Norm(points[i] - points_.back());
    if (!points_.empty() && spacing < kMinSpacing) continue;
    arc_.push_back(arc_.empty() ? 0.0 : arc_.back() + spacing);
    points_.push_back(points[i]);
    if (!flat) elevations_.push_back(elevations[i]);
  }
  assert(points_.size() >= 2);
  BuildBlocks();
}

void Polyline::BuildBlocks() {
  for (size_t first = 0; first + 1 < points_.size(); first += kBlockSegments) {
    const size_t last = std::min(first + kBlockSegments, points_.size() - 1);
    Block block{points_[(first + last) / 2], arc_[(first + last) / 2], 0.0};
    for (size_t i = first; i <= last; ++i)
      block.radius = std::max(block.radius, Norm(points_[i] - block.centre));
    blocks_.push_back(block);
  }
}

Point Polyline::At(double s) const {
  const size_t i = SegmentAt(arc_, s);
  const double t = (s - arc_[i]) / (arc_[i + 1] - arc_[i]);
  return points_[i] + t * (points_[i + 1] - points_[i]);
}

double Polyline::HeadingAt(double s) const {
  const size_t i = SegmentAt(arc_, s);
  const Point d = points_[i + 1] - points_[i];
  return std::atan2(d.y, d.x);
}

double Polyline::ElevationAt(double s) const {
  if (elevations_.empty()) return 0.0;
  const size_t i = SegmentAt(arc_, s);
  const double t = std::clamp((s - arc_[i]) / (arc_[i + 1] - arc_[i]), 0.0, 1.0);
  return elevations_[i] + t * (elevations_[i + 1] - elevations_[i]);
}

Polyline::Projection Polyline::Project(Point point) const { return Project(point, 0.0, length()); }

Polyline::Projection Polyline::Project(Point point, double s_low, double s_high) const {
  s_low = std::clamp(s_low, 0.0, length());
  s_high = std::clamp(s_high, s_low, length());
  Projection best;
  best.distance = std::numeric_limits<double>::infinity();
  const auto look_at = [&](size_t i) {
    const Point direction = points_[i + 1] - points_[i];
    const double span = arc_[i + 1] - arc_[i];
    const Point offset = point - points_[i];
    const double along = std::clamp(Dot(offset, direction) / span, std::max(0.0, s_low - arc_[i]),
                                    std::min(span, s_high - arc_[i]));
    const Point away = offset - (along / span) * direction;
    const double squared = Dot(away, away);
    if (squared >= best.distance * best.distance) return;
    best.distance = std::sqrt(squared);
    best.s = arc_[i] + along;
    best.lateral = std::copysign(best.distance, Cross(direction, offset));
  };
  const size_t first = SegmentAt(arc_, s_low);
  const size_t last = SegmentAt(arc_, s_high);
  // The nearest centre bounds the distance from above: most blocks are out of the question at once.
  double bound = best.distance;
  for (size_t block = first / kBlockSegments; block <= last / kBlockSegments; ++block) {
    if (blocks_[block].s < s_low || blocks_[block].s > s_high) continue;
    const Point away = point - blocks_[block].centre;
    bound = std::min(bound, Dot(away, away));
  }
  bound = std::sqrt(bound) + kMinSpacing;
  for (size_t block = first / kBlockSegments; block <= last / kBlockSegments; ++block) {
    const Point away = point - blocks_[block].centre;
    const double reach = std::min(bound, best.distance) + blocks_[block].radius;
    if (Dot(away, away) > reach * reach) continue;
    const size_t begin = std::max(first, block * kBlockSegments);
    const size_t end = std::min(last + 1, (block + 1) * kBlockSegments);
    for (size_t i = begin; i < end; ++i) look_at(i);
  }
  return best;
}

}  // namespace dadrl
