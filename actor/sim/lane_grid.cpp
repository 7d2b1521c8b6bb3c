#include "actor/sim/lane_grid.h"

#include <limits>
#include <numeric>

namespace dadrl {
namespace {

constexpr double kRounding = 1e-6;  // metres

}  // namespace

void LaneGrid::Add(const Polyline& centre, int lane) {
  const std::vector<Point>& points = centre.points();
  const std::vector<double>& arc = centre.arc();
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const double span = arc[i + 1] - arc[i];
    const double elevation = centre.ElevationAt(arc[i]);
    const double slope = (centre.ElevationAt(arc[i + 1]) - elevation) / span;
    segments_.push_back(
        {points[i], (1.0 / span) * (points[i + 1] - points[i]), span, arc[i], elevation, slope, lane});
  }
}

void LaneGrid::Bin() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Point low{kInfinity, kInfinity};
  Point high{-kInfinity, -kInfinity};
  for (const Segment& segment : segments_) {
    for (const Point& p : {segment.from, segment.from + segment.span * segment.direction}) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  if (segments_.empty()) low = high = Point{};
  origin_ = low;
  columns_ = static_cast<int64_t>((high.x - low.x) / kCellSize) + 1;
  rows_ = static_cast<int64_t>((high.y - low.y) / kCellSize) + 1;
  Binned binned;
  for (size_t i = 0; i < segments_.size(); ++i) BinSegment(static_cast<int32_t>(i), binned);
  for (auto& [key, pairs] : binned) {
    std::ranges::sort(pairs);
    Block& block = blocks_[key];
    for (const auto& [cell, segment] : pairs) {
      ++block.first[cell + 1];
      block.entries.push_back(segment);
    }
    std::partial_sum(block.first.begin(), block.first.end(), block.first.begin());
  }
}

void LaneGrid::BinSegment(int32_t index, Binned& binned) const {
  const Segment& segment = segments_[static_cast<size_t>(index)];
  const Point a = segment.from;
  const Point b = a + segment.span * segment.direction;
  for (int64_t row = Row(std::min(a.y, b.y)); row <= Row(std::max(a.y, b.y)); ++row) {
    // The part of the segment that lies in this row of cells, a little more for what is rounded.
    double low = 0.0;
    double high = segment.span;
    if (std::abs(segment.direction.y) > kRounding) {
      const double bottom = origin_.y + row * kCellSize;
      const double enters = (bottom - kRounding - a.y) / segment.direction.y;
      const double leaves = (bottom + kCellSize + kRounding - a.y) / segment.direction.y;
      low = std::clamp(std::min(enters, leaves), 0.0, segment.span);
      high = std::clamp(std::max(enters, leaves), 0.0, segment.span);
    }
    const double x = a.x + low * segment.direction.x;
    const double other_x = a.x + high * segment.direction.x;
    const int64_t last = Column(std::max(x, other_x) + kRounding);
    for (int64_t column = Column(std::min(x, other_x) - kRounding); column <= last; ++column) {
      binned[BlockKey(row, column)].emplace_back(CellOfBlock(row, column), index);
    }
  }
}

}  // namespace dadrl
