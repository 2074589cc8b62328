// SPDX-License-Identifier: BSD-3-Clause
#include "text_table.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

namespace ladar_perception {
namespace {

using Cells = std::vector<std::string_view>;

std::string lowered(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

/// "X" and "x" are the same axis; other names stay as they are.
std::vector<std::string> headerNames(const Cells& cells) {
  std::vector<std::string> names;
  for (std::string_view cell : cells) {
    if (cell.size() > 1 && cell.front() == '"' && cell.back() == '"') {
      cell = cell.substr(1, cell.size() - 2);
    }
    const std::string lower = lowered(cell);
    names.push_back(lower == "x" || lower == "y" || lower == "z" ? lower : std::string(cell));
  }
  return names;
}

/// Names of "# x y z ..." or "//X Y Z ...", as some programs write their header, else none.
std::vector<std::string> commentNames(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of("#/ \t"), line.size()));
  Cells cells;
  splitCells(line, cells);
  std::vector<std::string> names = headerNames(cells);
  const bool is_header = names.size() >= 3 && names[0] == "x" && names[1] == "y" && names[2] == "z";
  return is_header ? names : std::vector<std::string>{};
}

bool isComment(std::string_view line) {
  return line.substr(0, 1) == "#" || line.substr(0, 2) == "//";
}

bool isHeader(const Cells& cells) {
  double ignored = 0.0;
  return std::none_of(cells.begin(), cells.end(), [&](std::string_view cell) {
    return !cell.empty() && parseNumber(cell, ignored);
  });
}

void checkNames(const LineReader& lines, const std::vector<std::string>& names) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.empty()) lines.fail("a column has an empty name");
    if (name != "_" && !seen.insert(name).second)
      lines.fail("two columns are named '" + name + "'");
  }
  std::string found;
  for (const std::string& name : names) found += (found.empty() ? "" : ",") + name;
  for (const char* axis : {"x", "y", "z"}) {
    if (seen.count(axis) != 0) continue;
    lines.fail(std::string("no column is named '") + axis + "' (names of the columns: " + found +
               ")");
  }
}

/// Fills a TextTable line by line; knows what the lines before have said about the columns.
class TableBuilder {
 public:
  TableBuilder(const LineReader& lines, std::vector<std::string> names)
      : lines_(lines), names_(std::move(names)), names_given_(!names_.empty()) {}

  void addLine() {
    const std::string_view line = trimmed(lines_.text());
    if (line.empty()) return;
    if (isComment(line)) {
      if (comment_names_.empty()) comment_names_ = commentNames(line);
      return;
    }
    splitCells(line, cells_);
    dropTrailingEmptyCell();
    if (!table_started_ && !header_seen_ && isHeader(cells_)) return takeHeader();
    if (!table_started_) start();
    addRow();
  }

  TextTable take() { return std::move(table_); }
  bool started() const { return table_started_; }

 private:
  // Lines that end in ',' have one cell less than it seems.
  void dropTrailingEmptyCell() {
    const bool extra = names_.empty() || cells_.size() == names_.size() + 1;
    if (extra && cells_.size() > 1 && cells_.back().empty()) cells_.pop_back();
  }

  void takeHeader() {
    header_seen_ = true;
    if (!names_given_) names_ = headerNames(cells_);
  }

  void start() {
    table_started_ = true;
    if (names_.empty() && comment_names_.size() == cells_.size()) names_ = comment_names_;
    if (names_.empty()) {
      if (cells_.size() < 3) {
        lines_.fail("found " + std::to_string(cells_.size()) + " columns, expected at least x y z");
      }
      names_ = {"x", "y", "z"};
      for (std::size_t c = 3; c < cells_.size(); ++c) names_.push_back("c" + std::to_string(c));
    }
    checkNames(lines_, names_);
    for (std::size_t c = 0; c < names_.size(); ++c) {
      if (names_[c] == "_") continue;
      source_cell_.push_back(c);
      table_.names.push_back(names_[c]);
    }
    table_.columns.resize(table_.names.size());
  }

  void addRow() {
    if (cells_.size() != names_.size()) {
      lines_.fail("found " + std::to_string(cells_.size()) + " columns, expected " +
                  std::to_string(names_.size()));
    }
    for (std::size_t c = 0; c < source_cell_.size(); ++c) {
      const std::string_view token = cells_[source_cell_[c]];
      double value = 0.0;
      if (!parseNumber(token, value)) {
        lines_.fail("'" + std::string(token) + "' in column '" + table_.names[c] +
                    "' is not a number");
      }
      table_.columns[c].push_back(value);
    }
    table_.line_of_row.push_back(lines_.number());
  }

  const LineReader& lines_;
  std::vector<std::string> names_;  ///< one per cell of a line
  bool names_given_;
  bool header_seen_ = false;
  bool table_started_ = false;
  std::vector<std::string> comment_names_;
  std::vector<std::size_t> source_cell_;  ///< cell of each column of the table
  Cells cells_;
  TextTable table_;
};

}  // namespace

void failAtLine(const std::string& path, std::size_t line, const std::string& message) {
  throw std::runtime_error(path + ":" + std::to_string(line) + ": " + message);
}

LineReader::LineReader(const std::string& path) : path_(path), stream_(path, std::ios::binary) {
  if (!stream_) throw std::runtime_error(path + ": cannot be opened for reading");
}

bool LineReader::next() {
  if (!std::getline(stream_, text_)) return false;
  raw_bytes_ = text_.size() + (stream_.eof() ? 0 : 1);
  while (!text_.empty() && text_.back() == '\r') text_.pop_back();
  // Editors on Windows put a byte order mark before the first line.
  if (++number_ == 1 && text_.compare(0, 3, "\xEF\xBB\xBF") == 0) text_.erase(0, 3);
  return true;
}

std::string_view trimmed(std::string_view text) {
  const char* blanks = " \t\r\n\v\f";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

void splitCells(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  const char* separators = line.find_first_of(",;") != std::string_view::npos ? ",;" : " \t";
  const bool keeps_empty = separators[0] == ',';
  std::size_t begin = 0;
  while (begin <= line.size()) {
    const std::size_t end = std::min(line.find_first_of(separators, begin), line.size());
    const std::string_view cell = trimmed(line.substr(begin, end - begin));
    if (keeps_empty || !cell.empty()) cells.push_back(cell);
    begin = end + 1;
  }
}

bool parseNumber(std::string_view token, double& value) {
  if (token.empty()) {
    value = std::nan("");
    return true;
  }
  if (token.front() == '+') token.remove_prefix(1);
  const char* end = token.data() + token.size();
  const auto result = std::from_chars(token.data(), end, value);
  if (result.ptr != end) return false;
  if (result.ec == std::errc::result_out_of_range) {
    // 1e-320 is as good as 0; 1e999 is no number that a cloud can hold.
    const std::size_t exponent = token.find_first_of("eE");
    value = 0.0;
    return exponent != std::string_view::npos && token.substr(exponent + 1, 1) == "-";
  }
  return result.ec == std::errc();
}

TextTable readTextTable(const std::string& path, const std::vector<std::string>& names) {
  LineReader lines(path);
  TableBuilder builder(lines, names);
  while (lines.next()) builder.addLine();
  if (!builder.started()) throw std::runtime_error(path + ": has no points");
  return builder.take();
}

std::vector<Column> takeColumns(TextTable&& table) {
  const auto indexOf = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(table.names.begin(), table.names.end(), name) -
                                    table.names.begin());
  };
  const std::size_t axes[] = {indexOf("x"), indexOf("y"), indexOf("z")};
  const ScalarType position =
      positionType(table.columns[axes[0]], table.columns[axes[1]], table.columns[axes[2]]);
  std::vector<Column> columns;
  for (const std::size_t c : axes) {
    columns.push_back({table.names[c], position, std::move(table.columns[c])});
  }
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    if (std::count(std::begin(axes), std::end(axes), c) != 0) continue;
    const ScalarType type = attributeType(table.columns[c]);
    columns.push_back({table.names[c], type, std::move(table.columns[c])});
  }
  return columns;
}

}  // namespace ladar_perception
