#include "deploy/open_model/recorded_observations.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/io/npy.h"

namespace dadrl {
namespace {

constexpr uint64_t kMaxHeaderBytes = 4096;

// An array whose shape is a number of observations, then `shape`.
template <typename T>
Result<NpyArray<T>> LoadArray(const std::filesystem::path& path, const std::vector<int>& shape) {
  uint64_t one = sizeof(T);
  for (const int size : shape) one *= static_cast<uint64_t>(size);
  auto read = ReadNpy<T>(path, kMaxRecordedObservations * one + kMaxHeaderBytes);
  if (!read && read.error().code == ErrorCode::kExhausted) {
    return Fail(ErrorCode::kInvalidArgument, "{} is longer than {} observations of shape ({}): take fewer",
                path.string(), kMaxRecordedObservations, fmt::join(shape, ", "));
  }
  DADRL_ASSIGN_OR_RETURN(NpyArray<T> array, std::move(read));
  const bool fits = array.shape.size() == shape.size() + 1 &&
                    std::equal(shape.begin(), shape.end(), array.shape.begin() + 1,
                               [](int a, size_t b) { return size_t(a) == b; });
  if (!fits || array.shape.front() == 0) {
    return Fail(ErrorCode::kInvalidArgument,
                "{} has shape {}, the policy's configuration needs (N, {}) with N from 1 to {}",
                path.string(), ShapeText(array.shape), fmt::join(shape, ", "), kMaxRecordedObservations);
  }
  return array;
}

Status RequireFinite(const std::filesystem::path& path, const NpyArray<float>& array) {
  const auto bad = std::ranges::find_if_not(array.values, [](float v) { return std::isfinite(v); });
  if (bad == array.values.end()) return {};
  const size_t per_observation = array.values.size() / array.shape.front();
  return Fail(ErrorCode::kInvalidArgument, "{}: observation {} has a value that is not finite ({})",
              path.string(), static_cast<size_t>(bad - array.values.begin()) / per_observation, *bad);
}

// Zeros and ones to bits, lowest first.
Status PackBits(const std::filesystem::path& path, const NpyArray<uint8_t>& array, std::span<uint8_t> bits) {
  for (size_t i = 0; i < array.values.size(); ++i) {
    if (array.values[i] > 1) {
      return Fail(ErrorCode::kInvalidArgument,
                  "{}: observation {} has a pixel of {}, only 0 and 1 are allowed", path.string(),
                  i * array.shape.front() / array.values.size(), array.values[i]);
    }
    bits[i / 8] |= array.values[i] << (i % 8);
  }
  return {};
}

// The values of one column. The first that is loaded says how many rows `batch` has, the others must have as
// many.
Status LoadColumn(const std::filesystem::path& path, const StepSpec& spec, size_t index,
                  std::optional<Columns>& batch) {
  const auto fits = [&](size_t rows) -> Status {
    if (!batch) batch.emplace(spec, rows);
    if (std::cmp_equal(rows, batch->rows())) return {};
    return Fail(ErrorCode::kInvalidArgument,
                "{} holds {} observations, the first column {}: record them together", path.string(), rows,
                batch->rows());
  };
  const ColumnSpec& column = spec.observation[index];
  if (column.type == ElementType::kBit) {
    DADRL_ASSIGN_OR_RETURN(const auto array, LoadArray<uint8_t>(path, column.shape));
    DADRL_RETURN_IF_ERROR(fits(array.shape.front()));
    return PackBits(path, array, batch->bits(index));
  }
  DADRL_ASSIGN_OR_RETURN(const auto array, LoadArray<float>(path, column.shape));
  DADRL_RETURN_IF_ERROR(fits(array.shape.front()));
  std::ranges::copy(array.values, batch->floats(index).begin());
  return RequireFinite(path, array);
}

}  // namespace

Result<Columns> LoadRecordedObservations(const std::filesystem::path& directory, const StepSpec& spec) {
  std::optional<Columns> batch;
  for (size_t i = 0; i < spec.observation.size(); ++i) {
    DADRL_RETURN_IF_ERROR(LoadColumn(directory / (spec.observation[i].name + ".npy"), spec, i, batch));
  }
  return std::move(*batch);
}

}  // namespace dadrl
