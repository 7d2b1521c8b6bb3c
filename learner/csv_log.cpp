#include "learner/csv_log.h"

#include <charconv>
#include <cmath>

namespace dadrl {
namespace {

std::string Cell(double value) {
  if (!std::isfinite(value)) return "";
  return std::abs(value) < 1e6 ? fmt::format("{:.9g}", value) : fmt::format("{:.13g}", value);
}

}  // namespace

Result<CsvLog> CsvLog::Open(const std::filesystem::path& path, const std::vector<std::string>& columns) {
  DADRL_ASSIGN_OR_RETURN(RowFile rows, RowFile::Open(path, fmt::format("{}", fmt::join(columns, ","))));
  return CsvLog(std::move(rows));
}

double CsvLog::last_row_start() const {
  const std::string& row = rows_.last_row();
  double value = 0.0;
  std::from_chars(row.data(), row.data() + row.size(), value);
  return std::isfinite(value) ? value : 0.0;
}

Status CsvLog::Append(std::span<const double> values) {
  std::string row;
  for (size_t i = 0; i < values.size(); ++i) {
    if (i > 0) row += ',';
    row += Cell(values[i]);
  }
  row += '\n';
  return rows_.Append(row);
}

}  // namespace dadrl
