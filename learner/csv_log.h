// A table of numbers that grows by a row at a time and survives being killed.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/io/row_file.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe; each row is one write, visible to readers at once.
class CsvLog {
 public:
  // Appends to the table at `path`, or starts it with a line of `columns`; the folder is created. Half a row
  // that a killed process left is cut off; a table with other columns is renamed to *.old first.
  static Result<CsvLog> Open(const std::filesystem::path& path, const std::vector<std::string>& columns);

  // As many values as there are columns; one that is not finite leaves its cell empty. Nine significant
  // digits; thirteen from a million on, so that a time stamp keeps its milliseconds.
  Status Append(std::span<const double> values);

  // The first cell of the last row that was there when it was opened; 0: none, or not a number.
  double last_row_start() const;

 private:
  explicit CsvLog(RowFile rows) : rows_(std::move(rows)) {}

  RowFile rows_;
};

}  // namespace dadrl
