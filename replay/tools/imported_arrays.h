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
#include "common/step/step_spec.h"
#include "common/util/result.h"
#include "replay/tools/array_layout.h"

namespace dadrl {

// Mapped: only the rows that are read are resident. Movable; thread safe once open.
class ImportedArrays {
 public:
  // kCorrupt, kInvalidArgument: an index or an array that is none, of another shape, type or length than the
  // index says. What the numbers are is not looked at.
  static Result<ImportedArrays> Open(const std::filesystem::path& folder);

  // Of array `index` of ArrayLayouts; `row` < rows().
  std::span<const std::byte> Row(size_t index, uint64_t row) const {
    const auto& [layout, values, file] = arrays_[index];
    return values.subspan(row * layout.row_bytes, layout.row_bytes);
  }
  // Zero where this format has no such array.
  template <typename T>
  T Value(StepArray array, uint64_t row) const {
    T value{};
    if (!IsIn(array, format_)) return value;
    std::memcpy(&value, Row(IndexOf(spec_, array), row).data(), sizeof(T));
    return value;
  }
  const std::string& Name(size_t index) const { return arrays_[index].layout.name; }
  uint64_t rows() const { return rows_; }
  const StepSpec& spec() const { return spec_; }
  FloatCoding floats() const { return floats_; }

 private:
  struct Mapped {
    ArrayLayout layout;
    std::span<const std::byte> values;
    MappedFile file;
  };
  Status ReadIndex(const std::filesystem::path& path);
  std::filesystem::path FileOf(const std::filesystem::path& folder, const ArrayLayout& layout) const;

  uint64_t format_ = 0;
  uint64_t rows_ = 0;
  StepSpec spec_;
  FloatCoding floats_ = FloatCoding::kFloat16;
  std::vector<Mapped> arrays_;
};

}  // namespace dadrl
