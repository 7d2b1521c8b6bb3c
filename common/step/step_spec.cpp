#include "common/step/step_spec.h"

#include <algorithm>
#include <set>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/step/first_format.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

std::string_view TypeName(ElementType type) { return type == ElementType::kBit ? "bit" : "float32"; }

std::string ColumnText(const ColumnSpec& column) {
  return fmt::format("{} {} [{}]", column.name, TypeName(column.type), fmt::join(column.shape, ", "));
}

bool CodecFits(const ColumnSpec& column) {
  const bool floats = column.type == ElementType::kFloat32;
  switch (column.codec) {
    case ColumnCodec::kRaw:
      return true;
    case ColumnCodec::kHalf:
      return floats;
    case ColumnCodec::kHistory:
      return floats && (column.shape.size() == 2 || column.shape.size() == 3) &&
             column.shape[column.shape.size() - 2] <= kMaxHistoryRows;
    case ColumnCodec::kBitPlanes:
      return !floats && column.shape.size() == 3 && column.shape[1] == kBitPlaneSide &&
             column.shape[2] == kBitPlaneSide;
  }
  return false;
}

// Names become those of files.
bool IsName(std::string_view name) {
  return !name.empty() && name.size() <= 64 && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

Status CheckColumn(const ColumnSpec& column) {
  if (!IsName(column.name)) {
    return Fail(ErrorCode::kInvalidArgument, "column name '{}' is not 1 to 64 of a-z, 0-9 and _",
                Shown(column.name));
  }
  size_t elements = 1;
  for (const int size : column.shape) {
    elements =
        size < 1 || static_cast<size_t>(size) > kMaxStepElements ? 0 : elements * static_cast<size_t>(size);
    if (elements < 1 || elements > kMaxStepElements) {
      return Fail(ErrorCode::kInvalidArgument, "column '{}' does not have 1 to {} elements",
                  ColumnText(column), kMaxStepElements);
    }
  }
  if (!CodecFits(column)) {
    return Fail(ErrorCode::kInvalidArgument,
                "column '{}': its codec is for other columns (histories: floats of at most {} "
                "rows [entities, rows, features]; bit planes: bits [planes, {}, {}])",
                ColumnText(column), kMaxHistoryRows, kBitPlaneSide, kBitPlaneSide);
  }
  return {};
}

void Put(const ColumnSpec& column, ByteWriter& writer) {
  writer.PutText(column.name);
  writer.Put(static_cast<uint32_t>(column.type));
  writer.Put(static_cast<uint32_t>(column.codec));
  writer.Put<uint32_t>(column.shape.size());
  for (const int size : column.shape) writer.Put(size);
}

}  // namespace

size_t ColumnSpec::elements() const {
  size_t count = 1;
  for (const int size : shape) count *= static_cast<size_t>(size);
  return count;
}

size_t ColumnSpec::bytes() const {
  return type == ElementType::kBit ? (elements() + 7) / 8 : elements() * sizeof(float);
}

size_t StepSpec::decision_floats() const {
  size_t count = 0;
  for (const ColumnSpec& column : decision) count += column.elements();
  return count;
}

Result<size_t> FindColumn(const std::vector<ColumnSpec>& columns, std::string_view name, ElementType type,
                          size_t dimensions) {
  const auto found = std::ranges::find(columns, name, &ColumnSpec::name);
  if (found != columns.end() && found->type == type && found->shape.size() == dimensions) {
    return static_cast<size_t>(found - columns.begin());
  }
  return Fail(ErrorCode::kInvalidArgument,
              "a column '{}' of {} with {} dimensions is needed, the steps of this run have: {}", name,
              TypeName(type), dimensions, ColumnsText(columns));
}

Status CheckSpec(const StepSpec& spec) {
  std::set<std::string_view> names(kStepNames.begin(), kStepNames.end());
  size_t elements = 0;
  for (const auto* columns : {&spec.observation, &spec.decision}) {
    for (const ColumnSpec& column : *columns) {
      DADRL_RETURN_IF_ERROR(CheckColumn(column));
      if (!names.insert(column.name).second) {
        return Fail(ErrorCode::kInvalidArgument, "column name '{}' is taken", column.name);
      }
      elements += column.elements();
    }
  }
  for (const ColumnSpec& column : spec.decision) {
    if (column.type == ElementType::kFloat32 && column.codec == ColumnCodec::kRaw) continue;
    return Fail(ErrorCode::kInvalidArgument, "decision column '{}' is not of raw floats", ColumnText(column));
  }
  if (elements > kMaxStepElements) {
    return Fail(ErrorCode::kInvalidArgument, "a step of {} elements; it has at most {}: leave columns out",
                elements, kMaxStepElements);
  }
  if (const size_t floats = spec.decision_floats(); floats < 1 || floats > kMaxDecisionFloats) {
    return Fail(ErrorCode::kInvalidArgument, "a decision of {} numbers; it has 1 to {}", floats,
                kMaxDecisionFloats);
  }
  return {};
}

uint64_t SchemaHash(const StepSpec& spec) {
  if (const auto first = HashInFirstFormat(spec)) return *first;
  std::vector<std::byte> bytes;
  ByteWriter writer(bytes);
  for (const auto* columns : {&spec.observation, &spec.decision}) {
    writer.Put<uint32_t>(columns->size());
    for (const ColumnSpec& column : *columns) Put(column, writer);
  }
  return Xxh3(bytes);
}

std::string ColumnsText(const std::vector<ColumnSpec>& columns) {
  std::string text;
  for (const ColumnSpec& column : columns) text += (text.empty() ? "" : ", ") + ColumnText(column);
  return text;
}

}  // namespace dadrl
