#include "common/step/step_spec_json.h"

#include "common/io/json_text.h"
#include "common/step/first_format.h"
#include "common/util/enum_array.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMaxColumns = 256;
constexpr size_t kMaxDimensions = 8;
constexpr size_t kMaxWord = 64;

// In the order of their enumerations.
constexpr EnumArray<ElementType, std::string_view, 2> kTypes = {"float32", "bit"};
constexpr EnumArray<ColumnCodec, std::string_view, 4> kCodecs = {"raw", "half", "history", "bit_planes"};

template <typename Enum, size_t N>
Enum Parse(JsonFields& fields, const char* key, const EnumArray<Enum, std::string_view, N>& names) {
  const std::string word = fields.Text(key, kMaxWord);
  for (size_t i = 0; i < N; ++i) {
    if (names[i] == word) return names.At(i);
  }
  fields.Refuse(key);
  return {};
}

Json ColumnToJson(const ColumnSpec& column) {
  return {{"name", column.name},
          {"type", kTypes[column.type]},
          {"shape", column.shape},
          {"codec", kCodecs[column.codec]},
          {"bound", column.bound}};
}

Result<ColumnSpec> ColumnFromJson(const Json& json, std::string_view origin) {
  JsonFields fields(json);
  ColumnSpec column;
  column.name = fields.Text("name", kMaxWord);
  column.type = Parse(fields, "type", kTypes);
  column.codec = Parse(fields, "codec", kCodecs);
  column.bound = static_cast<float>(fields.Number("bound", 0.0, double{std::numeric_limits<float>::max()}));
  const Json* shape = fields.Find("shape");
  if (shape == nullptr || !shape->is_array() || shape->size() > kMaxDimensions) fields.Refuse("shape");
  for (size_t i = 0; fields.ok() && i < shape->size(); ++i) {
    const Json& size = (*shape)[i];
    if (!size.is_number_integer() || size < 1 || size > (1 << 24)) fields.Refuse("shape");
    if (fields.ok()) column.shape.push_back(size.get<int>());
  }
  if (fields.ok()) return column;
  return Fail(ErrorCode::kCorrupt, "{}: '{}' of a column is missing or out of range", origin, fields.bad());
}

Result<std::vector<ColumnSpec>> ColumnsFromJson(const Json& json, const char* key, std::string_view origin) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array() || found->size() > kMaxColumns) {
    return Fail(ErrorCode::kCorrupt, "{}: '{}' is no list of at most {} columns", origin, key, kMaxColumns);
  }
  std::vector<ColumnSpec> columns;
  for (const Json& one : *found) {
    DADRL_ASSIGN_OR_RETURN(ColumnSpec column, ColumnFromJson(one, origin));
    columns.push_back(std::move(column));
  }
  return columns;
}

}  // namespace

Json StepSpecToJson(const StepSpec& spec) {
  Json json = {{"observation", Json::array()}, {"decision", Json::array()}};
  for (const ColumnSpec& column : spec.observation) json["observation"].push_back(ColumnToJson(column));
  for (const ColumnSpec& column : spec.decision) json["decision"].push_back(ColumnToJson(column));
  return json;
}

Result<StepSpec> StepSpecFromJson(const Json& json, std::string_view origin) {
  if (!json.is_object()) return Fail(ErrorCode::kCorrupt, "{}: describes no columns", origin);
  StepSpec spec;
  DADRL_ASSIGN_OR_RETURN(spec.observation, ColumnsFromJson(json, "observation", origin));
  DADRL_ASSIGN_OR_RETURN(spec.decision, ColumnsFromJson(json, "decision", origin));
  if (const Status sound = CheckSpec(spec); !sound) {
    return Fail(ErrorCode::kCorrupt, "{}: {}", origin, sound.error().message);
  }
  return spec;
}

Result<StepSpec> SpecInFirstFormat(const Json& json, std::string_view origin) {
  constexpr int kMostVehicles = 64;  // as the configuration's ranges
  constexpr int kMostHistory = 50;
  JsonFields fields(json);
  const auto vehicles = fields.Whole("vehicles", kMostVehicles);
  const auto history = fields.Whole("history", kMostHistory);
  if (vehicles < 1) fields.Refuse("vehicles");
  if (history < 1) fields.Refuse("history");
  if (fields.ok()) return FirstFormatSpec(vehicles, history);
  return Fail(ErrorCode::kCorrupt, "{}: 'observation.{}' is missing or out of range", origin, fields.bad());
}

}  // namespace dadrl
