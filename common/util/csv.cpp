#include "common/util/csv.h"

#include <fmt/format.h>

#include <cmath>

namespace dadrl {

std::string CsvCell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) {
    if (c == '"') cell += '"';
    cell += c == '\r' || c == '\n' ? ' ' : c;
  }
  return cell + '"';
}

std::string CsvCell(double value) {
  if (!std::isfinite(value)) return "";
  return std::abs(value) < 1e6 ? fmt::format("{:.9g}", value) : fmt::format("{:.13g}", value);
}

std::vector<std::string_view> CsvCells(std::string_view row) {
  std::vector<std::string_view> cells;
  size_t begin = 0;
  bool quoted = false;
  for (size_t i = 0; i < row.size(); ++i) {
    if (row[i] == '"') quoted = !quoted;
    if (row[i] != ',' || quoted) continue;
    cells.push_back(row.substr(begin, i - begin));
    begin = i + 1;
  }
  cells.push_back(row.substr(begin));
  return cells;
}

}  // namespace dadrl
