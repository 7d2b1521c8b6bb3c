#include "learner/csv_log.h"

#include <fcntl.h>

#include <cmath>

#include "common/io/read_file.h"

namespace dadrl {
namespace {

constexpr uint64_t kMaxTableBytes = uint64_t{4} << 30;

// Makes what is at `path` end with a whole row of these columns, or moves it away.
Status Mend(const std::filesystem::path& path, const std::string& header) {
  std::error_code failed;
  if (!std::filesystem::exists(path, failed)) return {};
  DADRL_ASSIGN_OR_RETURN(const std::string table, ReadTextFile(path, kMaxTableBytes));
  const size_t end = table.rfind('\n') + 1;  // 0 when there is none
  if (table.starts_with(header)) {
    if (end != table.size()) std::filesystem::resize_file(path, end, failed);
  } else if (!table.empty()) {
    std::filesystem::path old = path;
    old += ".old";
    std::filesystem::rename(path, old, failed);
  }
  if (failed) {
    return Fail(ErrorCode::kInternal, "cannot mend {}: {}; move it away", path.string(), failed.message());
  }
  return {};
}

}  // namespace

Result<CsvLog> CsvLog::Open(const std::filesystem::path& path, const std::vector<std::string>& columns) {
  std::error_code failed;
  std::filesystem::create_directories(path.parent_path(), failed);
  if (failed) {
    return Fail(ErrorCode::kInternal, "cannot create {}: {}; choose another run directory",
                path.parent_path().string(), failed.message());
  }
  const std::string header = fmt::format("{}\n", fmt::join(columns, ","));
  DADRL_RETURN_IF_ERROR(Mend(path, header));
  auto file = FileDescriptor::Open(path, O_WRONLY | O_CREAT | O_APPEND);
  if (!file) return tl::unexpected<Error>(std::move(file.error()));
  if (std::filesystem::file_size(path, failed) == 0) {
    DADRL_RETURN_IF_ERROR(WriteAll(*file, std::as_bytes(std::span(header)), path));
  }
  return CsvLog(path, std::move(*file));
}

Status CsvLog::Append(std::span<const double> values) {
  std::string row;
  for (size_t i = 0; i < values.size(); ++i) {
    if (i > 0) row += ',';
    if (std::isfinite(values[i])) row += fmt::format("{:.9g}", values[i]);
  }
  row += '\n';
  return AppendWhole(file_, std::as_bytes(std::span(row)), path_);
}

}  // namespace dadrl
