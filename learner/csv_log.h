// A table that grows by a row at a time and survives being killed.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe; each row is one write, visible to readers at once.
class CsvLog {
 public:
  // Appends to the table at `path`, or starts it with a line of `columns`; the folder is created. Half a row
  // that a killed process left is cut off; a table with other columns is renamed to *.old first.
  static Result<CsvLog> Open(const std::filesystem::path& path, const std::vector<std::string>& columns);

  // As many values as there are columns; one that is not finite leaves its cell empty.
  Status Append(std::span<const double> values);

 private:
  CsvLog(std::filesystem::path path, FileDescriptor file) : path_(std::move(path)), file_(std::move(file)) {}

  std::filesystem::path path_;
  FileDescriptor file_;
};

}  // namespace dadrl
