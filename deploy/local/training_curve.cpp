#include "deploy/local/training_curve.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <string>
#include <string_view>

#include "common/util/csv.h"

namespace dadrl {
namespace {

// More than a row is long.
constexpr std::streamoff kTail = 4096;

// The last whole line of a file; empty when there is none.
std::string LastLine(std::ifstream& file) {
  file.seekg(0, std::ios::end);
  const std::streamoff size = file.tellg();
  std::string tail(static_cast<size_t>(std::clamp<std::streamoff>(size, 0, kTail)), '\0');
  file.seekg(-static_cast<std::streamoff>(tail.size()), std::ios::end);
  file.read(tail.data(), static_cast<std::streamsize>(tail.size()));
  tail.resize(tail.rfind('\n') == std::string::npos ? 0 : tail.rfind('\n'));
  const size_t before = tail.rfind('\n');
  return before == std::string::npos ? "" : tail.substr(before + 1);
}

// The number under `column`; 0 when there is none.
template <typename Number>
Number Value(std::string_view header, std::string_view row, std::string_view column) {
  const auto names = CsvCells(header);
  const auto cells = CsvCells(row);
  const auto place = static_cast<size_t>(std::find(names.begin(), names.end(), column) - names.begin());
  Number value = 0;
  if (place < names.size() && place < cells.size())
    std::from_chars(cells[place].data(), cells[place].data() + cells[place].size(), value);
  return value;
}

}  // namespace

TrainedSoFar LastOfTraining(const std::filesystem::path& training_csv) {
  std::ifstream file(training_csv);
  std::string header;
  if (!std::getline(file, header)) return {};
  const std::string row = LastLine(file);
  return {.updates = Value<uint64_t>(header, row, "updates"),
          .weights_version = Value<uint32_t>(header, row, "weights_version")};
}

}  // namespace dadrl
