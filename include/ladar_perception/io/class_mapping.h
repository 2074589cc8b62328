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
  std::map<uint32_t, uint8_t> truth_of_label;

  uint8_t truth(uint32_t label) const {
    const auto it = truth_of_label.find(label);
    return it == truth_of_label.end() ? uint8_t{0} : it->second;
  }
};

/// Reads `classes: [{name: surface, labels: [1200, 1203]}, ...]`. Throws std::runtime_error that
/// names file, line, what was found and what was expected: unknown or missing keys, a name or a
/// label twice, labels that are not integers.
ClassMapping loadClassMapping(const std::string& path);

/// Appends a uint8 field `truth` by the labels in `label_field`. Throws std::runtime_error if there
/// is no such field, if it has a value that is no label, or if there is a `truth` already.
void addTruth(Scan& scan, const std::string& label_field, const ClassMapping& mapping);

}  // namespace ladar_perception
