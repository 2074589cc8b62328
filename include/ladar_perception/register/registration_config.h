// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/params/param_table.h"

namespace ladar_perception {

/// Configuration of a SurfaceRegistrar.
struct RegistrationConfig {
  static constexpr int kMaxRestarts = 8;

  std::string solver = "annealed";
  std::string cost = "point_to_plane";
  double initial_radius_m = 10.0;
  double coarse_radius_m = 1.6;
  double final_radius_m = 0.3;
  double radius_factor = 0.9;
  int coarse_samples = 500;
  double min_normal_cosine = 0.7;
  double robust_scale_m = 0.1;
  int max_iterations = 30;
  int finish_points = 0;
  int restarts = 3;
  double min_overlap = 0.35;
  double good_overlap = 0.5;
  double min_information = 0.01;

  /// Names, ranges, units and meanings of the fields above.
  void addTo(ParamTable* table);
  /// Violations that no single range can tell.
  std::vector<std::string> validate() const;
};

}  // namespace ladar_perception
