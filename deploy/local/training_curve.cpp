#include "deploy/local/training_curve.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "common/io/file_descriptor.h"
#include "common/util/csv.h"

namespace dadrl {
namespace {

// More than a row is long.
constexpr off_t kMostOfRow = 4096;

// So much of a file from `begin` on; less where there is none.
std::string Part(const FileDescriptor& file, off_t begin) {
  std::string text(kMostOfRow, '\0');
  const ssize_t bytes = pread(file.get(), text.data(), text.size(), begin);
  text.resize(bytes > 0 ? static_cast<size_t>(bytes) : 0);
  return text;
}

// The last whole line of a file's end; empty when there is none.
std::string_view LastLine(std::string_view tail) {
  tail = tail.substr(0, std::min(tail.rfind('\n'), tail.size()));
  const size_t before = tail.rfind('\n');
  return before == std::string_view::npos ? std::string_view() : tail.substr(before + 1);
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
  const auto file = FileDescriptor::Open(training_csv, O_RDONLY);
  struct stat info {};
  if (!file || fstat(file->get(), &info) != 0) return {};
  const std::string head = Part(*file, 0);
  const std::string tail = Part(*file, std::max<off_t>(0, info.st_size - kMostOfRow));
  const std::string_view header = std::string_view(head).substr(0, head.find('\n'));
  const std::string_view row = LastLine(tail);
  return {.updates = Value<uint64_t>(header, row, "updates"),
          .cpu_s = Value<double>(header, row, "cpu_s"),
          .weights_version = Value<uint32_t>(header, row, "weights_version")};
}

}  // namespace dadrl
