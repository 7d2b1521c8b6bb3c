// Cells of comma-separated tables (RFC 4180), a row a line.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dadrl {

// `text` as a cell: in quotes where it has to be. Line breaks become spaces, so that a row stays a line.
std::string CsvCell(std::string_view text);

// A number as a cell: nine significant digits, thirteen from a million on, so that a time stamp keeps its
// milliseconds. Empty where it is not finite.
std::string CsvCell(double value);

// The cells of a row without its line break, as they are written: quotes stay.
std::vector<std::string_view> CsvCells(std::string_view row);

}  // namespace dadrl
