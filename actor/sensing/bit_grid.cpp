#include "actor/sensing/bit_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dadrl {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// An interval of x, empty when low > high.
struct Interval {
  double low = -kInfinity;
  double high = kInfinity;

  // Keeps the x with bound_low <= slope * x + offset <= bound_high.
  void Clip(double slope, double offset, double bound_low, double bound_high) {
    if (slope == 0.0) {
      if (offset < bound_low || offset > bound_high) *this = {kInfinity, -kInfinity};
      return;
    }
    const double a = (bound_low - offset) / slope;
    const double b = (bound_high - offset) / slope;
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }
  // The smallest interval that holds both; exact for the parts of a convex shape.
  void Join(Interval other) {
    if (other.low > other.high) return;
    const bool empty = low > high;
    low = empty ? other.low : std::min(low, other.low);
    high = empty ? other.high : std::max(high, other.high);
  }
};

// Where the line at height y crosses the disc.
Interval DiscAt(Point centre, double radius, double y) {
  const double squared = radius * radius - (y - centre.y) * (y - centre.y);
  if (squared < 0.0) return {kInfinity, -kInfinity};
  const double half = std::sqrt(squared);
  return {centre.x - half, centre.x + half};
}

int FirstCell(double low) { return static_cast<int>(std::ceil(low - 0.5)); }
int LastCell(double high) { return static_cast<int>(std::floor(high - 0.5)); }

}  // namespace

BitGrid::BitGrid(int width, int height)
    : width_(width),
      height_(height),
      stride_((width + 31) / 32),
      words_(static_cast<size_t>(stride_ * height)) {}

void BitGrid::Clear() { std::ranges::fill(words_, uint32_t{0}); }

void BitGrid::FillSpan(int row, double left, double right) {
  const double width = width_;
  const int first = FirstCell(std::clamp(left, 0.0, width));
  const int last = LastCell(std::clamp(right, 0.0, width));
  if (first > last) return;
  uint32_t* const first_word = &words_[Index(row, first)];
  uint32_t* const last_word = &words_[Index(row, last)];
  const uint32_t first_mask = ~uint32_t{0} << (first % 32);
  const uint32_t last_mask = ~uint32_t{0} >> (31 - last % 32);
  if (first_word == last_word) {
    *first_word |= first_mask & last_mask;
    return;
  }
  *first_word |= first_mask;
  std::fill(first_word + 1, last_word, ~uint32_t{0});
  *last_word |= last_mask;
}

void BitGrid::FillStrip(Point a, Point b, double half_width, Ends ends) {
  const Point along = b - a;
  const double length = Norm(along);
  if (length == 0.0 && ends == Ends::kSquare) return;
  const Point u = length > 0.0 ? (1.0 / length) * along : Point{1.0, 0.0};
  // Enough for both kinds of ends.
  const double low = std::clamp<double>(std::min(a.y, b.y) - half_width, 0.0, height_);
  const double high = std::clamp<double>(std::max(a.y, b.y) + half_width, 0.0, height_);
  for (int row = FirstCell(low); row <= LastCell(high); ++row) {
    const double y = row + 0.5;
    Interval span;
    span.Clip(u.y, -u.y * a.x - u.x * (y - a.y), -half_width, half_width);
    span.Clip(u.x, -u.x * a.x + u.y * (y - a.y), 0.0, length);
    if (ends == Ends::kRound) {
      span.Join(DiscAt(a, half_width, y));
      span.Join(DiscAt(b, half_width, y));
    }
    FillSpan(row, span.low, span.high);
  }
}

void BitGrid::FillPolygon(std::span<const Point> polygon) {
  if (polygon.size() < 3) return;
  const auto [lowest, highest] = std::ranges::minmax(polygon, {}, &Point::y);
  const double low = std::clamp<double>(lowest.y, 0.0, height_);
  const double high = std::clamp<double>(highest.y, 0.0, height_);
  std::vector<double> crossings;
  for (int row = FirstCell(low); row <= LastCell(high); ++row) {
    const double y = row + 0.5;
    crossings.clear();
    for (size_t i = 0; i < polygon.size(); ++i) {
      const Point p = polygon[i];
      const Point q = polygon[(i + 1) % polygon.size()];
      if ((p.y <= y) != (q.y <= y)) crossings.push_back(p.x + (y - p.y) / (q.y - p.y) * (q.x - p.x));
    }
    std::ranges::sort(crossings);
    for (size_t i = 0; i + 1 < crossings.size(); i += 2) FillSpan(row, crossings[i], crossings[i + 1]);
  }
}

}  // namespace dadrl
