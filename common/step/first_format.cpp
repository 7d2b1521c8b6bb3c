#include "common/step/first_format.h"

#include <algorithm>
#include <array>

#include "common/io/checksum.h"

namespace dadrl {
namespace {

// The sizes went into the hash behind the format's version, 1.
uint64_t Hash(int vehicles, int history) {
  const std::array<int, 8> values = {1, vehicles, history, 7, 20, 2, 128, 2};
  return Xxh3(std::as_bytes(std::span(values)));
}

bool SameColumns(const std::vector<ColumnSpec>& a, const std::vector<ColumnSpec>& b) {
  return std::ranges::equal(a, b, [](const ColumnSpec& x, const ColumnSpec& y) {
    return x.name == y.name && x.type == y.type && x.shape == y.shape && x.codec == y.codec;
  });
}

}  // namespace

std::optional<uint64_t> HashInFirstFormat(const StepSpec& spec) {
  if (spec.observation.empty() || spec.observation.front().shape.size() != 3) return std::nullopt;
  const std::vector<int>& vehicles = spec.observation.front().shape;
  const StepSpec first = FirstFormatSpec(vehicles[0], vehicles[1]);
  if (!SameColumns(spec.observation, first.observation) || !SameColumns(spec.decision, first.decision)) {
    return std::nullopt;
  }
  return Hash(vehicles[0], vehicles[1]);
}

// As they were, for ever: what DrivingStepSpec comes to have is none of it.
StepSpec FirstFormatSpec(int vehicles, int history) {
  return {.observation =
              {{"vehicles", ElementType::kFloat32, {vehicles, history, 7}, ColumnCodec::kHistory, 5.0f},
               {"ego", ElementType::kFloat32, {history, 20}, ColumnCodec::kHistory, 5.0f},
               {"context", ElementType::kBit, {2, 128, 128}, ColumnCodec::kBitPlanes}},
          .decision = {{"action", ElementType::kFloat32, {2}, ColumnCodec::kRaw, 1.0f}}};
}

std::optional<StepSpec> SpecOfFirstFormat(uint64_t schema) {
  constexpr int kMost = 64;  // the ranges of observation.vehicles and observation.history are within
  for (int vehicles = 1; vehicles <= kMost; ++vehicles) {
    for (int history = 1; history <= kMost; ++history) {
      if (Hash(vehicles, history) == schema) return FirstFormatSpec(vehicles, history);
    }
  }
  return std::nullopt;
}

std::string_view ArrayNameInFirstFormat(std::string_view name) {
  if (name == "action") return "actions";
  if (name == "has_decision") return "has_action";
  return name;
}

}  // namespace dadrl
