// A line through points, measured along its length.
#pragma once

#include <vector>

#include "actor/sim/geometry.h"

namespace dadrl {

// Immutable. At least two distinct points.
class Polyline {
 public:
  Polyline() = default;
  // Drops points closer than a millimetre to their predecessor. `elevations`: of each point, metres; empty
  // where everything is at height 0.
  explicit Polyline(const std::vector<Point>& points, const std::vector<double>& elevations = {});

  struct Projection {
    double s = 0.0;         // along the line, clamped to its ends
    double lateral = 0.0;   // signed, left positive
    double distance = 0.0;  // to the nearest point of the line
  };

  double length() const { return arc_.empty() ? 0.0 : arc_.back(); }
  const std::vector<Point>& points() const { return points_; }
  // Arc length of each point.
  const std::vector<double>& arc() const { return arc_; }

  // s outside the line continues along the first or last segment.
  Point At(double s) const;
  double HeadingAt(double s) const;
  double ElevationAt(double s) const;
  Projection Project(Point point) const;
  // The nearest point with s within [s_low, s_high]: keeps a projection from jumping where a line meets
  // itself.
  Projection Project(Point point, double s_low, double s_high) const;

 private:
  // A circle around some segments in a row: far ones need no closer look. Its centre is a point of the line.
  struct Block {
    Point centre;
    double s = 0.0;  // of the centre
    double radius = 0.0;
  };
  void BuildBlocks();

  std::vector<Point> points_;
  std::vector<double> arc_;
  std::vector<double> elevations_;  // empty: 0 everywhere
  std::vector<Block> blocks_;
};

}  // namespace dadrl
