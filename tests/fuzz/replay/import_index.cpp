// The index of an import, beside arrays of one row.
#include "common/io/npy.h"
#include "replay/tools/imported_arrays.h"
#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {
namespace {

constexpr std::string_view kGood = R"({"format": "dadrl experience", "version": 1, "rows": 1,
  "observation": {"vehicles": 6, "history": 5}, "floats": "float16", "arrays": {}})";

// Of the default observations.
bool WriteArrays() {
  for (const ArrayLayout& layout : ArrayLayouts(ObservationSpec{})) {
    std::vector<size_t> shape = layout.row;
    shape.insert(shape.begin(), 1);
    const std::string array = NpyHeader(layout.type, shape) + std::string(layout.row_bytes, '\0');
    Written("import/" + layout.name + ".npy", std::as_bytes(std::span(array)));
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
  Require(arrays->rows() == 1 && arrays->spec() == ObservationSpec{});
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds{.accepted = {AsBytes(kGood)}, .refused = BadJson()};
  for (const std::string_view rows : {"18446744073709551615", "-1", "1e30", "2", "\"1\""}) {
    std::string index(kGood);
    index.replace(index.find("1,\n"), 1, rows);
    seeds.refused.push_back(AsBytes(index));
  }
  return seeds;
}

}  // namespace dadrl::fuzz
