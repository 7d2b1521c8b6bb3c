// Which lanes are near a point: a uniform grid over the segments of their centre lines.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "actor/sim/geometry.h"
#include "actor/sim/polyline.h"

namespace dadrl {

// Each cell lists the segments that pass through it. Cells are kept in blocks, and only where there is a
// road: what it takes follows the roads, not the extent. Immutable once binned; any thread may read it.
class LaneGrid {
 public:
  struct Segment {
    Point from;
    Point direction;  // unit
    double span = 0.0;
    double s = 0.0;          // arc length at `from`
    double elevation = 0.0;  // at `from`
    double slope = 0.0;      // metres of height a metre
    int lane = 0;

    double ElevationAt(double along) const { return elevation + along * slope; }
  };

  void Add(const Polyline& centre, int lane);
  // After the last Add.
  void Bin();

  std::span<const Segment> segments() const { return segments_; }

  // Calls visit(segment, along, distance) for each segment within `radius`; a segment may come twice.
  template <typename Visit>
  void ForEachNear(Point point, double radius, Visit visit) const;

 private:
  static constexpr double kCellSize = 4.0;
  static constexpr int64_t kBlockCells = 32;  // a side of a block

  struct Block {
    // Segments of cell i: entries first[i] to first[i + 1].
    std::array<uint32_t, kBlockCells * kBlockCells + 1> first{};
    std::vector<int32_t> entries;
  };
  // (cell of its block, segment), by block.
  using Binned = std::unordered_map<int64_t, std::vector<std::pair<size_t, int32_t>>>;

  // Clamped to the network's cells.
  int64_t Column(double x) const { return CellIndex(x - origin_.x, columns_); }
  int64_t Row(double y) const { return CellIndex(y - origin_.y, rows_); }
  static int64_t CellIndex(double offset, int64_t count) {
    return static_cast<int64_t>(std::clamp<double>(std::floor(offset / kCellSize), 0.0, count - 1));
  }
  int64_t BlockKey(int64_t row, int64_t column) const {
    return (row / kBlockCells) * (columns_ / kBlockCells + 1) + column / kBlockCells;
  }
  static size_t CellOfBlock(int64_t row, int64_t column) {
    return static_cast<size_t>((row % kBlockCells) * kBlockCells + column % kBlockCells);
  }
  void BinSegment(int32_t index, Binned& binned) const;

  std::vector<Segment> segments_;
  Point origin_;
  int64_t columns_ = 0;
  int64_t rows_ = 0;
  std::unordered_map<int64_t, Block> blocks_;
};

template <typename Visit>
void LaneGrid::ForEachNear(Point point, double radius, Visit visit) const {
  int64_t key = -1;
  const Block* block = nullptr;
  const int64_t last_row = Row(point.y + radius);
  const int64_t last_column = Column(point.x + radius);
  for (int64_t row = Row(point.y - radius); row <= last_row; ++row) {
    for (int64_t column = Column(point.x - radius); column <= last_column; ++column) {
      if (const int64_t here = BlockKey(row, column); here != key) {
        key = here;
        const auto found = blocks_.find(key);
        block = found == blocks_.end() ? nullptr : &found->second;
      }
      if (block == nullptr) continue;
      const size_t cell = CellOfBlock(row, column);
      for (uint32_t entry = block->first[cell]; entry < block->first[cell + 1]; ++entry) {
        const Segment& segment = segments_[static_cast<size_t>(block->entries[entry])];
        const Point offset = point - segment.from;
        const double along = std::clamp(Dot(offset, segment.direction), 0.0, segment.span);
        const Point away = offset - along * segment.direction;
        const double squared = Dot(away, away);
        if (squared <= radius * radius) visit(segment, along, std::sqrt(squared));
      }
    }
  }
}

}  // namespace dadrl
