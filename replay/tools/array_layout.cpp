#include "replay/tools/array_layout.h"

namespace dadrl {

std::vector<ArrayLayout> ArrayLayouts(const StepSpec& spec) {
  std::vector<ArrayLayout> layouts;
  for (const auto* columns : {&spec.observation, &spec.decision}) {
    for (const ColumnSpec& column : *columns) {
      const bool floats = column.type == ElementType::kFloat32;
      layouts.push_back({column.name, floats ? "<f4" : "|u1", {column.shape.begin(), column.shape.end()}});
    }
  }
  for (const auto& [name, type] : {std::pair{"rewards", "<f4"},
                                   {"terminated", "|u1"},
                                   {"truncated", "|u1"},
                                   {"has_decision", "|u1"},
                                   {"policy_version", "<u4"},
                                   {"actor", "<u4"},
                                   {"incarnation", "<u8"},
                                   {"episode", "<u8"},
                                   {"step", "<u4"}}) {
    layouts.push_back({name, type, {}});
  }
  for (ArrayLayout& layout : layouts) {
    layout.row_bytes = static_cast<size_t>(layout.type.back() - '0');
    for (const size_t size : layout.row) layout.row_bytes *= size;
  }
  return layouts;
}

}  // namespace dadrl
