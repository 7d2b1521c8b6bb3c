// The arrays of an exported folder, as whoever wrote them left them.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/io/mapped_file.h"
#include "common/model/observation.h"
#include "common/util/result.h"
#include "replay/tools/array_layout.h"

namespace dadrl {

// Mapped: only the rows that are read are resident. Movable; thread safe once open.
class ImportedArrays {
 public:
  // kCorrupt, kInvalidArgument: an index or an array that is none, of another shape, type or length than the
  // index says. What the numbers are is not looked at.
  static Result<ImportedArrays> Open(const std::filesystem::path& folder);

  // `row` < rows().
  std::span<const std::byte> Row(Column column, uint64_t row) const {
    const auto& [layout, values, file] = columns_[static_cast<size_t>(column)];
    return values.subspan(row * layout.row_bytes, layout.row_bytes);
  }
  template <typename T>
  T Value(Column column, uint64_t row) const {
    T value;
    std::memcpy(&value, Row(column, row).data(), sizeof(T));
    return value;
  }
  const std::string& Name(Column column) const { return columns_[static_cast<size_t>(column)].layout.name; }
  uint64_t rows() const { return rows_; }
  const ObservationSpec& spec() const { return spec_; }
  FloatCoding floats() const { return floats_; }

 private:
  struct Mapped {
    ArrayLayout layout;
    std::span<const std::byte> values;
    MappedFile file;
  };
  Status ReadIndex(const std::filesystem::path& path);

  uint64_t rows_ = 0;
  ObservationSpec spec_;
  FloatCoding floats_ = FloatCoding::kFloat16;
  std::vector<Mapped> columns_;
};

}  // namespace dadrl
