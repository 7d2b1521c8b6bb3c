// The index of an import, beside arrays of one row.
#include "common/io/npy.h"
#include "common/step/driving_shape.h"
#include "common/step/first_format.h"
#include "common/step/step_spec_json.h"
#include "replay/tools/imported_arrays.h"
#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {
namespace {

constexpr std::string_view kGood = R"({"format": "dadrl experience", "version": 1, "rows": 1,
  "observation": {"vehicles": 6, "history": 5}, "floats": "float16", "arrays": {}})";

// Of the default observations.
bool WriteArrays() {
  for (const ArrayLayout& layout : ArrayLayouts(DrivingShape{})) {
    std::vector<size_t> shape = layout.row;
    shape.insert(shape.begin(), 1);
    const std::string array = NpyHeader(layout.type, shape) + std::string(layout.row_bytes, '\0');
    Written("import/" + layout.name + ".npy", std::as_bytes(std::span(array)));
    Written(fmt::format("import/{}.npy", ArrayNameInFirstFormat(layout.name)),
            std::as_bytes(std::span(array)));
  }
  return true;
}

}  // namespace

const int kMutants = 10000;

bool Check(std::span<std::byte> input) {
  [[maybe_unused]] static const bool written = WriteArrays();
  Written("import/index.json", input);
  const auto arrays = ImportedArrays::Open(Folder() / "import");
  if (!Accepted(arrays)) return false;
  Require(arrays->rows() == 1 && CheckSpec(arrays->spec()));
  return true;
}

Seeds MakeSeeds() {
  const std::string columns = StepSpecToJson(DrivingShape{}).dump();
  const std::string described = fmt::format(
      R"({{"format": "dadrl experience", "version": 2, "rows": 1, "columns": {}, "floats": "float16"}})",
      columns);
  Seeds seeds{.accepted = {AsBytes(kGood), AsBytes(described)}, .refused = BadJson()};
  for (const auto& [from, to] : {std::pair{"\"ego\"", "\"../ego\""},
                                 {"[5,20]", "[5,1e30]"},
                                 {"[5,20]", "[0]"},
                                 {"history", "zip"},
                                 {"\"action\"", "\"ego\""}}) {
    std::string index = described;
    index.replace(index.find(from), std::string_view(from).size(), to);
    seeds.refused.push_back(AsBytes(index));
  }
  for (const std::string_view rows : {"18446744073709551615", "-1", "1e30", "2", "\"1\""}) {
    std::string index(kGood);
    index.replace(index.find("1,\n"), 1, rows);
    seeds.refused.push_back(AsBytes(index));
  }
  return seeds;
}

}  // namespace dadrl::fuzz
