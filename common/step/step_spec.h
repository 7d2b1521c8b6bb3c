// What one step of an episode holds, as data: columns with a name, a type and a shape. Sensors fill them, the
// replay moves them unread, networks ask for them by name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

enum class ElementType : uint8_t { kFloat32, kBit };

// How a column of an observation is written (proto/payload_codec.h).
enum class ColumnCodec : uint8_t {
  kRaw,      // as it is in memory
  kHalf,     // floats, rounded to fp16
  kHistory,  // floats [entities, history, features] or [history, features], each row against the one after it
  kBitPlanes,  // bits [planes, 128, 128], by the edges of their rows
};
constexpr int kMaxHistoryRows = 64;
constexpr int kBitPlaneSide = 128;
constexpr size_t kMaxStepElements = size_t{1} << 24;  // of all columns of a step
constexpr size_t kMaxDecisionFloats = 1024;

struct ColumnSpec {
  std::string name;
  ElementType type = ElementType::kFloat32;
  std::vector<int> shape;  // of one step; empty: a single number
  ColumnCodec codec = ColumnCodec::kRaw;
  // Of a float's absolute value: what is beyond it is refused where it enters.
  float bound = std::numeric_limits<float>::max();

  size_t elements() const;
  // In memory: four a float, eight bits a byte.
  size_t bytes() const;
  bool operator==(const ColumnSpec&) const = default;
};

struct StepSpec {
  std::vector<ColumnSpec> observation;
  // What was decided on the observation: the action first, then whatever a method records beside it. Floats,
  // never compressed.
  std::vector<ColumnSpec> decision;

  size_t decision_floats() const;
  bool operator==(const StepSpec&) const = default;
};

// The place of the column `name` in `columns`. kInvalidArgument lists what is there when it is not, or when
// it has another type or number of dimensions.
Result<size_t> FindColumn(const std::vector<ColumnSpec>& columns, std::string_view name, ElementType type,
                          size_t dimensions);

// What every step has beside its columns, whose names are others: exports have an array of each.
constexpr std::array<std::string_view, 10> kStepNames = {
    "rewards", "terminated",  "truncated", "has_decision", "policy_version",
    "actor",   "incarnation", "episode",   "step",         "success"};

// kInvalidArgument: a name twice, none or of kStepNames, a shape with nothing in it, a codec that does not
// fit the column, no decision or one beyond kMaxDecisionFloats, more than kMaxStepElements.
Status CheckSpec(const StepSpec& spec);

// Names the columns, their types, shapes and codecs: who has another schema has other experience. Bounds are
// no part of it. Specs that the first format of stored experience knew keep the hash that they had there.
uint64_t SchemaHash(const StepSpec& spec);

// "vehicles float32 [6, 5, 7], ego float32 [5, 20]".
std::string ColumnsText(const std::vector<ColumnSpec>& columns);

}  // namespace dadrl
