// SPDX-License-Identifier: BSD-3-Clause
#include "ply_header.h"

#include <map>
#include <string>

namespace ladar_perception {
namespace {

using Cells = std::vector<std::string_view>;

std::size_t plyTypeBytes(const LineReader& lines, std::string_view type) {
  static const std::map<std::string_view, std::size_t> kBytes = {
      {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto it = kBytes.find(type);
  if (it == kBytes.end()) {
    lines.fail("unknown property type '" + std::string(type) +
               "', expected char, uchar, short, ushort, int, uint, float or double");
  }
  return it->second;
}

void readElement(const LineReader& lines, const Cells& cells, bool is_first, PlyHeader& header) {
  double count = -1.0;
  if (cells.size() != 3 || !parseNumber(cells[2], count) || count < 0.0 || count > 4e9) {
    lines.fail("expected 'element NAME COUNT'");
  }
  if (is_first && cells[1] != "vertex") {
    lines.fail("the first element is '" + std::string(cells[1]) + "', expected 'vertex'");
  }
  if (is_first) header.vertices = static_cast<std::size_t>(count);
}

void readProperty(const LineReader& lines, const Cells& cells, PlyHeader& header) {
  if (cells.size() != 3) lines.fail("expected 'property TYPE NAME' for a vertex (no list)");
  header.vertex_bytes += plyTypeBytes(lines, cells[1]);
  ++header.properties;
}

}  // namespace

PlyHeader readPlyHeader(LineReader& lines) {
  if (!lines.next() || lines.text() != "ply") lines.fail("expected 'ply'");
  PlyHeader header;
  header.bytes = lines.rawBytes();
  int elements = 0;
  Cells cells;
  while (lines.next()) {
    header.bytes += lines.rawBytes();
    splitCells(lines.text(), cells);
    if (cells.empty() || cells[0] == "comment" || cells[0] == "obj_info") continue;
    if (cells[0] == "end_header") {
      if (elements == 0) lines.fail("the header has no 'element vertex COUNT'");
      return header;
    }
    if (cells[0] == "format") header.ascii = cells.size() > 1 && cells[1] == "ascii";
    if (cells[0] == "element") readElement(lines, cells, ++elements == 1, header);
    if (cells[0] == "property" && elements == 1) readProperty(lines, cells, header);
  }
  lines.fail("the file ends before 'end_header'");
}

}  // namespace ladar_perception
