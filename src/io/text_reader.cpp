// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/text_reader.h"

#include <cmath>
#include <limits>
#include <utility>

#include "text_table.h"

namespace ladar_perception {

Scan readTextScan(const std::string& path, const std::vector<std::string>& columns) {
  return makeScan(takeColumns(readTextTable(path, columns)));
}

Scan readOaklandScan(const std::string& path) {
  TextTable table = readTextTable(path, {"x", "y", "z", "label", "confidence"});
  constexpr std::size_t kLabel = 3;
  for (std::size_t row = 0; row < table.line_of_row.size(); ++row) {
    const double label = table.columns[kLabel][row];
    // The negated comparison also catches NaN.
    if (!(label >= 0.0 && label <= std::numeric_limits<uint16_t>::max()) ||
        label != std::floor(label)) {
      failAtLine(path, table.line_of_row[row],
                 "label " + std::to_string(label) + " is not an integer from 0 to 65535");
    }
  }
  std::vector<Column> columns = takeColumns(std::move(table));
  columns[kLabel].type = ScalarType::kUint16;
  return makeScan(columns);
}

Scan read3dtkScan(const std::string& path) {
  TextTable table = readTextTable(path, {});
  if (table.names[0] != "x" || table.names[1] != "y" || table.names[2] != "z") {
    failAtLine(path, table.line_of_row.front(), "expected the columns x y z first");
  }
  constexpr double kMetresPerCentimetre = 0.01;
  for (std::size_t row = 0; row < table.line_of_row.size(); ++row) {
    const double right_cm = table.columns[0][row];
    const double up_cm = table.columns[1][row];
    const double forward_cm = table.columns[2][row];
    table.columns[0][row] = forward_cm * kMetresPerCentimetre;
    table.columns[1][row] = -right_cm * kMetresPerCentimetre;
    table.columns[2][row] = up_cm * kMetresPerCentimetre;
  }
  return makeScan(takeColumns(std::move(table)));
}

}  // namespace ladar_perception
