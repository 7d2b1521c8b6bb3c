#include "replay/tools/imported_arrays.h"

#include <utility>

#include "common/io/json_text.h"
#include "common/io/npy.h"
#include "common/io/read_file.h"
#include "common/step/first_format.h"
#include "common/step/step_spec_json.h"

namespace dadrl {
namespace {

constexpr uint64_t kMaxIndexBytes = 1 << 20;
constexpr uint64_t kMaxRows = uint64_t{1} << 40;
constexpr size_t kMaxWord = 64;

}  // namespace

Result<ImportedArrays> ImportedArrays::Open(const std::filesystem::path& folder) {
  ImportedArrays arrays;
  DADRL_RETURN_IF_ERROR(arrays.ReadIndex(folder / kArrayIndex));
  const size_t successes = IndexOf(arrays.spec_, StepArray::kSuccess);
  for (const ArrayLayout& layout : ArrayLayouts(arrays.spec_)) {
    if (arrays.arrays_.size() == successes && !IsIn(StepArray::kSuccess, arrays.format_)) break;
    const std::filesystem::path path = arrays.FileOf(folder, layout);
    DADRL_ASSIGN_OR_RETURN(MappedFile file, MappedFile::Open(path, Links::kFollow));
    DADRL_ASSIGN_OR_RETURN(const NpyView view, ParseNpy(file.bytes(), layout.type, path));
    std::vector<size_t> shape = layout.row;
    shape.insert(shape.begin(), arrays.rows_);
    if (view.shape != shape) {
      return Fail(ErrorCode::kInvalidArgument, "{} has shape {}, {} says {}", path.string(),
                  ShapeText(view.shape), kArrayIndex, ShapeText(shape));
    }
    arrays.arrays_.push_back({layout, view.values, std::move(file)});
  }
  return arrays;
}

Status ImportedArrays::ReadIndex(const std::filesystem::path& path) {
  DADRL_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(path, kMaxIndexBytes, Links::kFollow));
  DADRL_ASSIGN_OR_RETURN(const nlohmann::ordered_json index, ParseJson(text, path.string()));
  JsonFields fields(index);
  const std::string name = fields.Text("format", kMaxWord);
  format_ = fields.Whole("version", UINT32_MAX);
  if (name != "dadrl experience" || format_ < 1 || format_ > kArrayFormat) {
    return Fail(ErrorCode::kCorrupt, "{} is no index of experience of version 1 to {}", path.string(),
                kArrayFormat);
  }
  rows_ = fields.Whole("rows", kMaxRows);
  const std::string floats = fields.Text("floats", kMaxWord);
  if (floats != "float32" && floats != "float16") fields.Refuse("floats");
  floats_ = floats == "float32" ? FloatCoding::kFloat32 : FloatCoding::kFloat16;
  const char* const key = format_ == 1 ? "observation" : "columns";
  if (!fields.Has(key)) fields.Refuse(key);
  if (!fields.ok()) {
    return Fail(ErrorCode::kCorrupt, "{}: '{}' is missing or out of range", path.string(), fields.bad());
  }
  const nlohmann::ordered_json& columns = *fields.Find(key);
  DADRL_ASSIGN_OR_RETURN(spec_, format_ == 1 ? SpecInFirstFormat(columns, path.string())
                                             : StepSpecFromJson(columns, path.string()));
  return {};
}

std::filesystem::path ImportedArrays::FileOf(const std::filesystem::path& folder,
                                             const ArrayLayout& layout) const {
  const std::string_view name = format_ == 1 ? ArrayNameInFirstFormat(layout.name) : layout.name;
  return folder / fmt::format("{}.npy", name);
}

}  // namespace dadrl
