#include "replay/tools/imported_arrays.h"

#include <utility>

#include "common/io/json_text.h"
#include "common/io/npy.h"
#include "common/io/read_file.h"

namespace dadrl {
namespace {

constexpr uint64_t kMaxIndexBytes = 1 << 20;
constexpr uint64_t kMaxRows = uint64_t{1} << 40;
constexpr uint64_t kMaxVehicles = 64;  // as the configuration's ranges
constexpr uint64_t kMaxHistory = 50;
constexpr size_t kMaxWord = 64;

}  // namespace

Result<ImportedArrays> ImportedArrays::Open(const std::filesystem::path& folder) {
  ImportedArrays arrays;
  DADRL_RETURN_IF_ERROR(arrays.ReadIndex(folder / kArrayIndex));
  for (const ArrayLayout& layout : ArrayLayouts(arrays.spec_)) {
    const std::filesystem::path path = folder / (layout.name + ".npy");
    DADRL_ASSIGN_OR_RETURN(MappedFile file, MappedFile::Open(path, Links::kFollow));
    DADRL_ASSIGN_OR_RETURN(const NpyView view, ParseNpy(file.bytes(), layout.type, path));
    std::vector<size_t> shape = layout.row;
    shape.insert(shape.begin(), arrays.rows_);
    if (view.shape != shape) {
      return Fail(ErrorCode::kInvalidArgument, "{} has shape {}, {} says {}", path.string(),
                  ShapeText(view.shape), kArrayIndex, ShapeText(shape));
    }
    arrays.columns_.push_back({layout, view.values, std::move(file)});
  }
  return arrays;
}

Status ImportedArrays::ReadIndex(const std::filesystem::path& path) {
  DADRL_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(path, kMaxIndexBytes, Links::kFollow));
  DADRL_ASSIGN_OR_RETURN(const nlohmann::ordered_json index, ParseJson(text, path.string()));
  JsonFields fields(index);
  if (fields.Text("format", kMaxWord) != "dadrl experience" ||
      fields.Whole("version", UINT32_MAX) != kArrayFormat) {
    return Fail(ErrorCode::kCorrupt, "{} is no index of experience of version {}", path.string(),
                kArrayFormat);
  }
  rows_ = fields.Whole("rows", kMaxRows);
  const std::string floats = fields.Text("floats", kMaxWord);
  if (floats != "float32" && floats != "float16") fields.Refuse("floats");
  floats_ = floats == "float32" ? FloatCoding::kFloat32 : FloatCoding::kFloat16;
  const nlohmann::ordered_json* observation = fields.Find("observation");
  if (observation == nullptr) fields.Refuse("observation");
  if (!fields.ok()) {
    return Fail(ErrorCode::kCorrupt, "{}: '{}' is missing or out of range", path.string(), fields.bad());
  }
  JsonFields shape(*observation);
  spec_.vehicles = static_cast<int>(shape.Whole("vehicles", kMaxVehicles));
  spec_.history = static_cast<int>(shape.Whole("history", kMaxHistory));
  if (spec_.vehicles < 1) shape.Refuse("vehicles");
  if (spec_.history < 1) shape.Refuse("history");
  if (shape.ok()) return {};
  return Fail(ErrorCode::kCorrupt, "{}: 'observation.{}' is missing or out of range", path.string(),
              shape.bad());
}

}  // namespace dadrl
