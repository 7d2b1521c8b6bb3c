#include "replay/storage/columns_file.h"

#include "common/io/atomic_file.h"
#include "common/io/json_text.h"
#include "common/io/read_file.h"
#include "common/step/first_format.h"
#include "common/step/step_spec_json.h"

namespace dadrl {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{1} << 20;

Result<StepSpec> Parse(const std::filesystem::path& path) {
  DADRL_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(path, kMaxBytes));
  DADRL_ASSIGN_OR_RETURN(const nlohmann::ordered_json json, ParseJson(text, path.string()));
  return StepSpecFromJson(json, path.string());
}

}  // namespace

Status WriteColumns(const std::filesystem::path& directory, const StepSpec& spec) {
  const std::filesystem::path path = directory / kColumnsFile;
  if (const Result<StepSpec> there = Parse(path); there && *there == spec) return {};
  const std::string text = StepSpecToJson(spec).dump(2) + "\n";
  return WriteFileAtomically(path, std::string_view(text));
}

Result<StepSpec> ReadColumns(const std::filesystem::path& directory, uint64_t schema) {
  const Result<StepSpec> described = Parse(directory / kColumnsFile);
  if (described && SchemaHash(*described) == schema) return described;
  if (auto first = SpecOfFirstFormat(schema)) return std::move(*first);
  return Fail(ErrorCode::kCorrupt, "{}: nothing says what its steps hold (schema {:#x}): {}",
              directory.string(), schema,
              described ? "columns.json describes others" : described.error().message);
}

}  // namespace dadrl
