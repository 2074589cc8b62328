// SPDX-License-Identifier: BSD-3-Clause
// Configuration of the terrain nodelet and of classify_bag.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/classify/classifier_model.h"
#include "ladar_perception/params/param_table.h"
#include "ladar_perception/terrain/terrain_config.h"
#include "param_reader.h"

namespace ladar_perception {

struct TerrainNodeConfig {
  TerrainConfig pipeline;
  std::string model = "package://ladar_perception/config/models/starter.yaml";
  std::string map_frame = "odom";
  std::string vehicle_frame = "base_link";
  bool motion_compensation = true;
  double tf_timeout_s = 0.2;
  int queue_size = 4;
  double map_rate_hz = 1.0;
  double map_radius_m = 15.0;
  double statistics_rate_hz = 1.0;

  /// The table that feeds the strict readers, config/terrain.yaml and the documentation.
  ParamTable table();
  /// Violations that no single range can tell.
  std::vector<std::string> validate() const;
};

/// Loads the model `config.model` names (a path or package://<package>/<path>) and checks that it
/// fits the configuration. Throws std::runtime_error that names the file.
ClassifierModel loadFittingModel(const TerrainNodeConfig& config);

}  // namespace ladar_perception
