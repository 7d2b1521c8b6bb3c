#include "deploy/open_model/recorded_observations.h"

#include <algorithm>
#include <cmath>

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

// Pixels 0 or 1 to bits, lowest first.
Status PackBits(const std::filesystem::path& path, const std::vector<uint8_t>& pixels,
                std::vector<uint8_t>& bits) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i] > 1) {
      return Fail(ErrorCode::kInvalidArgument,
                  "{}: observation {} has a pixel of {}, only 0 and 1 are allowed", path.string(),
                  i / (size_t{8} * ObservationSpec::kContextBytes), pixels[i]);
    }
    bits[i / 8] |= static_cast<uint8_t>(pixels[i] << (i % 8));
  }
  return {};
}

}  // namespace

Result<ObservationBatch> LoadRecordedObservations(const std::filesystem::path& directory,
                                                  const ObservationSpec& spec) {
  const auto vehicles_path = directory / "vehicles.npy";
  const auto ego_path = directory / "ego.npy";
  const auto context_path = directory / "context.npy";
  constexpr int kSize = ObservationSpec::kContextSize;
  DADRL_ASSIGN_OR_RETURN(auto vehicles, LoadArray<float>(vehicles_path, {spec.vehicles, spec.history,
                                                                         ObservationSpec::kVehicleFeatures}));
  DADRL_ASSIGN_OR_RETURN(auto ego, LoadArray<float>(ego_path, {spec.history, ObservationSpec::kEgoFeatures}));
  DADRL_ASSIGN_OR_RETURN(const auto context,
                         LoadArray<uint8_t>(context_path, {ObservationSpec::kContextPlanes, kSize, kSize}));
  const size_t count = vehicles.shape.front();
  if (ego.shape.front() != count || context.shape.front() != count) {
    return Fail(ErrorCode::kInvalidArgument,
                "{}: vehicles.npy holds {} observations, ego.npy {}, context.npy {}: record them together",
                directory.string(), count, ego.shape.front(), context.shape.front());
  }
  DADRL_RETURN_IF_ERROR(RequireFinite(vehicles_path, vehicles));
  DADRL_RETURN_IF_ERROR(RequireFinite(ego_path, ego));
  ObservationBatch batch(spec, static_cast<int>(count));
  DADRL_RETURN_IF_ERROR(PackBits(context_path, context.values, batch.context));
  batch.vehicles = std::move(vehicles.values);
  batch.ego = std::move(ego.values);
  return batch;
}

}  // namespace dadrl
