#include "replay/tools/array_layout.h"

namespace dadrl {
namespace {

// NumPy's, of kStepNames.
constexpr std::array<std::string_view, kStepNames.size()> kStepTypes = {"<f4", "|u1", "|u1", "|u1", "<u4",
                                                                        "<u4", "<u8", "<u8", "<u4", "|u1"};

}  // namespace

std::vector<ArrayLayout> ArrayLayouts(const StepSpec& spec) {
  std::vector<ArrayLayout> layouts;
  for (const auto* columns : {&spec.observation, &spec.decision}) {
    for (const ColumnSpec& column : *columns) {
      const bool floats = column.type == ElementType::kFloat32;
      layouts.push_back({column.name, floats ? "<f4" : "|u1", {column.shape.begin(), column.shape.end()}});
    }
  }
  for (size_t i = 0; i < kStepNames.size(); ++i) {
    layouts.push_back({std::string(kStepNames[i]), std::string(kStepTypes[i]), {}});
  }
  for (ArrayLayout& layout : layouts) {
    layout.row_bytes = static_cast<size_t>(layout.type.back() - '0');
    for (const size_t size : layout.row) layout.row_bytes *= size;
  }
  return layouts;
}

}  // namespace dadrl
