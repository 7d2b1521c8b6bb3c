#include "actor/ego/smooth_line.h"

#include <algorithm>
#include <cmath>

namespace dadrl {
namespace {

constexpr double kSpacing = 0.5;
// A straight longer than twice this keeps its middle: a point is set this far from each of its ends.
constexpr double kRounding = 4.0;

std::vector<Point> HoldStraights(const Polyline& line) {
  std::vector<Point> points;
  for (size_t i = 0; i + 1 < line.points().size(); ++i) {
    const double low = line.arc()[i];
    const double high = line.arc()[i + 1];
    points.push_back(line.points()[i]);
    if (high - low <= 2.0 * kRounding) continue;
    points.push_back(line.At(low + kRounding));
    points.push_back(line.At(high - kRounding));
  }
  points.push_back(line.points().back());
  return points;
}

Point Blend(Point a, Point b, double ta, double tb, double t) {
  return ((tb - t) / (tb - ta)) * a + ((t - ta) / (tb - ta)) * b;
}

// The curve between p[1] and p[2], by Barry and Goldman's pyramid.
Point CatmullRom(const Point p[4], const double knots[4], double t) {
  const Point a1 = Blend(p[0], p[1], knots[0], knots[1], t);
  const Point a2 = Blend(p[1], p[2], knots[1], knots[2], t);
  const Point a3 = Blend(p[2], p[3], knots[2], knots[3], t);
  const Point b1 = Blend(a1, a2, knots[0], knots[2], t);
  const Point b2 = Blend(a2, a3, knots[1], knots[3], t);
  return Blend(b1, b2, knots[1], knots[2], t);
}

}  // namespace

Polyline SmoothLine(const Polyline& line) {
  std::vector<Point> points = HoldStraights(line);
  // The ends continue straight.
  points.insert(points.begin(), 2.0 * points[0] - points[1]);
  points.push_back(2.0 * points.back() - points[points.size() - 2]);
  std::vector<Point> smooth;
  for (size_t i = 1; i + 2 < points.size(); ++i) {
    const Point* p = &points[i - 1];
    double knots[4] = {};
    for (int k = 0; k < 3; ++k) knots[k + 1] = knots[k] + std::sqrt(Norm(p[k + 1] - p[k]));
    const int steps = std::max<int>(1, std::lround(Norm(p[2] - p[1]) / kSpacing));
    for (int step = 0; step < steps; ++step) {
      const double t = knots[1] + (knots[2] - knots[1]) * step / steps;
      smooth.push_back(CatmullRom(p, knots, t));
    }
  }
  smooth.push_back(line.points().back());
  return Polyline(smooth);
}

}  // namespace dadrl
