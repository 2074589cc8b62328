// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/params/param_table.h"

namespace ladar_perception {

/// Configuration of a CloudResampler. Samples are added until the first of count, radius_m and
/// time_budget_s that is set is reached; at least one must be.
struct ResampleConfig {
  std::string engine = "fast_marching";
  std::string crust = "surfels";
  int count = 0;
  double radius_m = 0.0;
  double time_budget_s = 0.0;
  double cell_size_m = 0.0;
  int min_component_points = 5;
  bool nearest_original = false;
  int threads = 1;

  /// Names, ranges, units and meanings of the fields above.
  void addTo(ParamTable* table);
  /// Violations that no single range can tell.
  std::vector<std::string> validate() const;
};

}  // namespace ladar_perception
