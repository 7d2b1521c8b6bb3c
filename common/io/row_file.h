// A text table that grows by whole rows and survives being killed at any point.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe; each Append is one write, visible to readers at once.
class RowFile {
 public:
  // Goes on behind the last whole row at `path`, or starts the table with the line `header` (without its line
  // break); the folder is created. Half a row that a killed process left is cut off; a table with another
  // header is renamed to *.old first.
  static Result<RowFile> Open(const std::filesystem::path& path, std::string_view header);

  // Whole rows, each with its line break: all of them or, on an error, none.
  Status Append(std::string_view rows);

  // The last row that was there when it was opened, without its line break; empty when there was none.
  const std::string& last_row() const { return last_row_; }

 private:
  RowFile(std::filesystem::path path, FileDescriptor file, std::string last_row)
      : path_(std::move(path)), file_(std::move(file)), last_row_(std::move(last_row)) {}

  std::filesystem::path path_;
  FileDescriptor file_;
  std::string last_row_;
};

}  // namespace dadrl
