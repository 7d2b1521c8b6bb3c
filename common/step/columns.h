// The values of observation columns: one row an observation.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/step/step_spec.h"

namespace dadrl {

// `rows` observations of a spec: each column holds its rows one after the other, bits
// packed, the first in the lowest place. Owns its memory.
class Columns {
 public:
  Columns(const StepSpec& spec, int rows) : rows_(rows) {
    const auto count = static_cast<size_t>(rows);
    for (const ColumnSpec& column : spec.observation) {
      const bool floats = column.type == ElementType::kFloat32;
      columns_.push_back({std::vector<float>(floats ? count * column.elements() : 0),
                          std::vector<uint8_t>(floats ? 0 : count * column.bytes())});
    }
  }

  int rows() const { return rows_; }
  size_t columns() const { return columns_.size(); }
  std::span<float> floats(size_t column) { return columns_[column].floats; }
  std::span<const float> floats(size_t column) const { return columns_[column].floats; }
  std::span<uint8_t> bits(size_t column) { return columns_[column].bits; }
  std::span<const uint8_t> bits(size_t column) const { return columns_[column].bits; }
  bool operator==(const Columns&) const = default;

 private:
  // Of one column, by its type in one of the two.
  struct Values {
    std::vector<float> floats;
    std::vector<uint8_t> bits;
    bool operator==(const Values&) const = default;
  };
  int rows_;
  std::vector<Values> columns_;
};

// Rows [first, first + count) of columns; borrowed.
template <typename Of>
class RowsOf {
 public:
  RowsOf(Of& columns, int first, int count) : columns_(&columns), first_(first), count_(count) {}
  RowsOf(Of& columns)
      : RowsOf(columns, 0, columns.rows()) {}  // NOLINT(google-explicit-constructor): all of it

  int rows() const { return count_; }
  auto floats(size_t column) const { return Part(columns_->floats(column)); }
  auto bits(size_t column) const { return Part(columns_->bits(column)); }

 private:
  template <typename T>
  std::span<T> Part(std::span<T> values) const {
    const size_t length = values.size() / static_cast<size_t>(columns_->rows());
    return values.subspan(static_cast<size_t>(first_) * length, static_cast<size_t>(count_) * length);
  }
  Of* columns_;
  int first_;
  int count_;
};
using ColumnRows = RowsOf<const Columns>;
using MutableColumnRows = RowsOf<Columns>;

}  // namespace dadrl
