// SPDX-License-Identifier: BSD-3-Clause
// From the labels of a data set to the few classes that are learned and scored.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "ladar_perception/io/scan.h"

namespace ladar_perception {

/// Truth values: 0 = ignored, else 1 + index of the class.
struct ClassMapping {
  std::vector<std::string> names;
  std::vector<uint32_t> colors;  ///< 0x00RRGGBB, one per class
  std::map<uint32_t, uint8_t> truth_of_label;

  uint8_t truth(uint32_t label) const {
    const auto it = truth_of_label.find(label);
    return it == truth_of_label.end() ? uint8_t{0} : it->second;
  }
};

/// Reads `classes: [{name: surface, labels: [1200, 1203], color: "#dc2828"}, ...]`, 2 to 16
/// classes; a class without a color gets one by `classColors`. Throws std::runtime_error that names
/// file, line, what was found and what was expected: unknown or missing keys, a name, a label or a
/// color twice, labels that are not integers, colors that are none.
ClassMapping loadClassMapping(const std::string& path);

/// Colors for the classes that have none yet (kNoColor): surface is red, scatter green and linear
/// blue; others take, in order and without repetition, those of a palette of 16 that people with
/// any color vision can tell apart.
constexpr uint32_t kNoColor = UINT32_MAX;
std::vector<uint32_t> classColors(const std::vector<std::string>& names,
                                  std::vector<uint32_t> colors);

/// Appends a uint8 field `truth` by the labels in `label_field`. Throws std::runtime_error if there
/// is no such field, if it has a value that is no label, or if there is a `truth` already.
void addTruth(Scan& scan, const std::string& label_field, const ClassMapping& mapping);

}  // namespace ladar_perception
