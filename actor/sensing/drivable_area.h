// What of the ground is road, as bitmaps around wherever somebody looks.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "actor/sensing/bit_sampler.h"
#include "actor/sim/geometry.h"
#include "actor/sim/road_map.h"
#include "actor/sim/route.h"

namespace dadrl {

// The union of lanes and junction areas in cells of 0.2 m. A network of ordinary size is one bitmap; a large
// one is cut into overlapping squares, each drawn when it is first looked at, and only the last few of them
// are kept: what it takes does not grow with the network. Roads far above or below the route are left out.
// Borrows map and route. Not thread safe.
class DrivableArea {
 public:
  static constexpr double kCellMetres = 0.2;

  // `reach`: how far a look may go from the point it is about, metres. `spacing`: of its points, in cells.
  DrivableArea(const RoadMap& map, const Route& route, double reach, double spacing);

  struct Bitmap {
    Point origin;      // world position of its corner
    BitSampler cells;  // row: north, column: east
  };
  // The bitmap that holds everything within `reach` of `point`; null when `point` is off the network by more
  // than 5 m. Valid until the next call. Allocates when a square is looked at for the first time.
  const Bitmap* Around(Point point);

 private:
  // What is rounded included.
  double Margin() const { return reach_ + 2.0 * kCellMetres; }

  using SquareIndex = std::pair<int64_t, int64_t>;  // row, column

  std::unique_ptr<Bitmap> DrawSquare(SquareIndex square) const;
  void DrawLanes(Point origin, BitGrid& grid) const;
  bool OnRouteLevel(const Lane& lane, double s) const;

  const RoadMap& map_;
  const Route& route_;
  double reach_;
  double spacing_;
  Point low_;  // of the network with what a look reaches beyond it
  Point high_;
  double stride_ = 0.0;  // from one square to the next, metres
  Point size_;           // of a square
  struct Kept {
    std::unique_ptr<Bitmap> bitmap;
    uint64_t looked_at = 0;
  };
  std::map<SquareIndex, Kept> squares_;
  uint64_t looks_ = 0;
};

}  // namespace dadrl
