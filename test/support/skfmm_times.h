// SPDX-License-Identifier: BSD-3-Clause
// Reads test/data/skfmm_times.txt, which says itself how it was made and what is in it.
#pragma once

#include <cstddef>
#include <fstream>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "eikonal_oracle.h"

namespace ladar_perception::test {

/// A field of speeds on a full grid and the arrival times that scikit-fmm finds in it.
struct SkfmmField {
  RegularGrid grid;
  std::vector<std::size_t> sources;
  std::vector<double> speeds;        ///< m/s
  std::vector<double> first_order;   ///< s
  std::vector<double> second_order;  ///< s
};

/// The fields by name: plane_uniform, plane_two_sources, plane_linear (0.5 + 1.5 x), plane_waves,
/// space_uniform, space_waves. Throws std::runtime_error where the file is not as it should be.
inline std::map<std::string, SkfmmField> readSkfmmFields(const std::string& path) {
  std::ifstream file(path);
  std::string word;
  const auto expect = [&](const std::string& expected) {
    if (!(file >> word) || word != expected) {
      throw std::runtime_error(path + ": '" + word + "' stands where '" + expected + "' should");
    }
  };
  const auto readValues = [&](const RegularGrid& grid) {
    std::vector<double> values(grid.size(), std::numeric_limits<double>::quiet_NaN());
    for (double& value : values) file >> value;
    return values;
  };
  while (file >> std::ws && file.peek() == '#') std::getline(file, word);
  std::map<std::string, SkfmmField> fields;
  while (file >> word) {
    if (word != "field") throw std::runtime_error(path + ": no field begins with '" + word + "'");
    std::string name;
    file >> name;
    SkfmmField& field = fields[name];
    file >> field.grid.nx >> field.grid.ny >> field.grid.nz >> field.grid.spacing_m;
    expect("sources");
    file >> word;
    for (int n = std::stoi(word); n > 0; --n) {
      int i = 0;
      int j = 0;
      int k = 0;
      file >> i >> j >> k;
      field.sources.push_back(field.grid.index(i, j, k));
    }
    expect("speeds");
    field.speeds = readValues(field.grid);
    expect("times");
    expect("1");
    field.first_order = readValues(field.grid);
    expect("times");
    expect("2");
    field.second_order = readValues(field.grid);
  }
  if (fields.empty()) throw std::runtime_error(path + ": no fields");
  return fields;
}

}  // namespace ladar_perception::test
