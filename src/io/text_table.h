// SPDX-License-Identifier: BSD-3-Clause
// Lines, cells and numbers of text files, with the line numbers that error messages need.
#pragma once

#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "ladar_perception/io/scan.h"

namespace ladar_perception {

/// Throws std::runtime_error("path:line: message").
[[noreturn]] void failAtLine(const std::string& path, std::size_t line, const std::string& message);

/// Reads lines without their CR or LF, counting from 1.
class LineReader {
 public:
  /// Throws if the file cannot be opened.
  explicit LineReader(const std::string& path);
  bool next();
  const std::string& text() const { return text_; }
  std::size_t number() const { return number_; }
  /// Bytes of the line in the file, with its end.
  std::size_t rawBytes() const { return raw_bytes_; }
  [[noreturn]] void fail(const std::string& message) const { failAtLine(path_, number_, message); }

 private:
  std::string path_;
  std::ifstream stream_;
  std::string text_;
  std::size_t number_ = 0;
  std::size_t raw_bytes_ = 0;
};

/// Cells of a line: split at every ',' or ';' if it has one, else at runs of blanks and tabs.
void splitCells(std::string_view line, std::vector<std::string_view>& cells);
std::string_view trimmed(std::string_view text);
/// True and the number if the whole token is one, whatever the locale; an empty cell, as
/// spreadsheets and pandas write a missing value, is NaN.
bool parseNumber(std::string_view token, double& value);

/// Columns of a text file.
struct TextTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;  ///< one per name
  std::vector<std::size_t> line_of_row;
};

/// Reads numbers in columns. Names come from `names` ("_" skips a column), else from a header
/// line, else they are x y z c3 c4 ...
TextTable readTextTable(const std::string& path, const std::vector<std::string>& names);

/// Adds every column of the table, x y z first, with the smallest float type that keeps it.
std::vector<Column> takeColumns(TextTable&& table);

}  // namespace ladar_perception
