// SPDX-License-Identifier: BSD-3-Clause
// Legacy VTK: a header of four lines, then keywords that each say how many numbers follow.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "ladar_perception/io/text_reader.h"
#include "text_table.h"

namespace ladar_perception {
namespace {

class VtkParser {
 public:
  explicit VtkParser(const std::string& path) : lines_(path) {}

  std::vector<Column> parse() {
    parseHeader();
    std::string keyword;
    while (nextToken(keyword)) parseSection(keyword);
    if (columns_.empty()) lines_.fail("the file ends before POINTS");
    return std::move(columns_);
  }

 private:
  void parseHeader() {
    if (!lines_.next() || lines_.text().rfind("# vtk DataFile", 0) != 0) {
      lines_.fail("expected '# vtk DataFile Version ...'");
    }
    lines_.next();  // title
    expectLine("ASCII");
    expectLine("DATASET POLYDATA");
  }

  void expectLine(const std::string& expected) {
    const bool found = lines_.next() && trimmed(lines_.text()) == expected;
    if (!found) lines_.fail("found '" + lines_.text() + "', expected '" + expected + "'");
  }

  bool nextToken(std::string& token) {
    while (next_cell_ == cells_.size()) {
      if (!lines_.next()) return false;
      splitCells(lines_.text(), cells_);
      next_cell_ = 0;
    }
    token = cells_[next_cell_++];
    return true;
  }

  std::string expectToken(const std::string& what) {
    std::string token;
    if (!nextToken(token)) lines_.fail("the file ends here, expected " + what);
    return token;
  }

  double expectNumber(const std::string& what) {
    const std::string token = expectToken(what);
    double value = 0.0;
    if (!parseNumber(token, value))
      lines_.fail("'" + token + "' is not a number, expected " + what);
    return value;
  }

  std::size_t expectCount(const std::string& what) {
    constexpr double kMaxCount = 4e9;
    const double value = expectNumber(what);
    if (!(value >= 0.0 && value <= kMaxCount)) lines_.fail("expected " + what);
    return static_cast<std::size_t>(value);
  }

  void parseSection(const std::string& keyword) {
    if (keyword == "POINTS") return parsePoints();
    if (keyword == "VERTICES" || keyword == "LINES" || keyword == "POLYGONS" ||
        keyword == "TRIANGLE_STRIPS") {
      expectCount("the number of cells");
      return skipNumbers(expectCount("the number of indices"), keyword);
    }
    if (keyword == "POINT_DATA") return parsePointData();
    if (keyword == "CELL_DATA") return parseCellData();
    if (keyword == "METADATA") return skipMetadata();
    if (keyword == "SCALARS") return parseScalars();
    if (keyword == "NORMALS") return parseVectors({"normal_x", "normal_y", "normal_z"});
    if (keyword == "VECTORS") return parseVectors({});
    if (keyword == "COLOR_SCALARS") {
      const std::string name = expectToken("the name of the colours");
      return parseArray(name, expectCount("the number of components"), rows_);
    }
    if (keyword == "FIELD") return parseFields();
    lines_.fail("unknown keyword '" + keyword +
                "', expected POINTS, VERTICES, LINES, POLYGONS, POINT_DATA, SCALARS, NORMALS, "
                "VECTORS, COLOR_SCALARS or FIELD");
  }

  void parsePoints() {
    points_ = expectCount("the number of points");
    rows_ = points_;
    expectToken("the type of the coordinates");
    readInterleaved({"x", "y", "z"}, points_, "a coordinate");
    const ScalarType type =
        positionType(columns_[0].values, columns_[1].values, columns_[2].values);
    for (Column& column : columns_) column.type = type;
  }

  void parsePointData() {
    rows_ = expectCount("the number of points");
    if (rows_ != points_ || columns_.empty()) {
      lines_.fail("POINT_DATA for " + std::to_string(rows_) + " points, expected " +
                  std::to_string(points_));
    }
    of_points_ = true;
  }

  void parseCellData() {
    rows_ = expectCount("the number of cells");
    of_points_ = false;
  }

  void parseScalars() {
    const std::string name = expectToken("the name of the scalars");
    expectToken("the type of the scalars");
    std::size_t components = 1;
    std::string token = expectToken("LOOKUP_TABLE");
    if (token != "LOOKUP_TABLE") {
      double value = 0.0;
      if (!parseNumber(token, value) || value < 1 || value > 4) {
        lines_.fail("'" + token + "', expected 1 to 4 components or LOOKUP_TABLE");
      }
      components = static_cast<std::size_t>(value);
      token = expectToken("LOOKUP_TABLE");
    }
    if (token != "LOOKUP_TABLE") lines_.fail("'" + token + "', expected LOOKUP_TABLE");
    expectToken("the name of the lookup table");
    parseArray(name, components, rows_);
  }

  void parseVectors(std::vector<std::string> names) {
    const std::string name = expectToken("the name of the vectors");
    expectToken("the type of the vectors");
    if (names.empty()) names = {name + "_x", name + "_y", name + "_z"};
    readInterleaved(names, rows_, "a component of '" + name + "'");
  }

  void parseFields() {
    expectToken("the name of the field data");
    const std::size_t arrays = expectCount("the number of arrays");
    for (std::size_t i = 0; i < arrays; ++i) {
      const std::string name = expectToken("the name of an array");
      const std::size_t components = expectCount("the number of components");
      const std::size_t rows = expectCount("the number of tuples");
      expectToken("the type of the array");
      if (rows != rows_ || columns_.empty()) {
        skipNumbers(rows * components, name);  // belongs to the file, not to its points
      } else {
        parseArray(name, components, rows);
      }
    }
  }

  void parseArray(const std::string& name, std::size_t components, std::size_t rows) {
    std::vector<std::string> names;
    if (components == 1) names.push_back(name);
    for (std::size_t c = 0; components > 1 && c < components; ++c) {
      names.push_back(name + "_" + std::to_string(c));
    }
    readInterleaved(names, rows, "a value of '" + name + "'");
  }

  void readInterleaved(const std::vector<std::string>& names, std::size_t rows,
                       const std::string& what) {
    std::vector<Column> read(names.size());
    for (std::size_t row = 0; row < rows; ++row) {
      for (Column& column : read) column.values.push_back(expectNumber(what));
    }
    if (!of_points_) return;
    for (std::size_t c = 0; c < read.size(); ++c) {
      read[c].name = names[c];
      read[c].type = attributeType(read[c].values);
      for (const Column& column : columns_) {
        if (column.name == names[c]) lines_.fail("a second array is named '" + names[c] + "'");
      }
      columns_.push_back(std::move(read[c]));
    }
  }

  void skipNumbers(std::size_t count, const std::string& what) {
    for (std::size_t i = 0; i < count; ++i) expectToken("a value of " + what);
  }

  void skipMetadata() {
    next_cell_ = cells_.size();
    while (lines_.next() && !trimmed(lines_.text()).empty()) {
    }
  }

  LineReader lines_;
  std::vector<std::string_view> cells_;
  std::size_t next_cell_ = 0;
  std::size_t points_ = 0;
  std::size_t rows_ = 0;   ///< of the arrays that follow
  bool of_points_ = true;  ///< as opposed to cells
  std::vector<Column> columns_;
};

}  // namespace

Scan readVtkScan(const std::string& path) { return makeScan(VtkParser(path).parse()); }

}  // namespace ladar_perception
