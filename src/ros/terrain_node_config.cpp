// SPDX-License-Identifier: BSD-3-Clause
#include "terrain_node_config.h"

#include <stdexcept>

#include "package_path.h"

namespace ladar_perception {

ParamTable TerrainNodeConfig::table() {
  ParamTable table;
  table.add("model", &model, "classifier model, a path or package://<package>/<path>");
  table.add("map_frame", &map_frame, "frame the map is kept in; it must not jump");
  table.add("vehicle_frame", &vehicle_frame,
            "frame the map is centred on; empty for the cloud's own frame");
  pipeline.addTo(&table);
  table.add("motion_compensation", &motion_compensation,
            "place every point by the pose at its own time, where the cloud has a time field");
  table.add("tf_timeout_s", &tf_timeout_s, 0.0, 10.0, "s",
            "how long a scan waits for its transforms before it is dropped");
  table.add("queue_size", &queue_size, 1, 1000, "scans",
            "scans that may wait; the oldest is dropped when one more comes");
  table.add("map_rate_hz", &map_rate_hz, 0.0, 100.0, "Hz",
            "how often labeled_map is published, by the scans' stamps; 0 for never");
  table.add("map_radius_m", &map_radius_m, 0.0, 1000.0, "m",
            "labeled_map holds the voxels within this distance of the vehicle");
  table.add("statistics_rate_hz", &statistics_rate_hz, 0.1, 100.0, "Hz",
            "how often statistics are published");
  return table;
}

std::vector<std::string> TerrainNodeConfig::validate() const {
  std::vector<std::string> violations = pipeline.validate();
  checkFrame("map_frame", map_frame, false, &violations);
  checkFrame("vehicle_frame", vehicle_frame, true, &violations);
  if (model.empty()) violations.emplace_back("model: must not be empty");
  return violations;
}

ClassifierModel loadFittingModel(const TerrainNodeConfig& config) {
  const std::string path = resolvePackagePath(config.model);
  ClassifierModel model = loadClassifierModel(path);
  const std::string misfit =
      modelMisfit(model, config.pipeline.voxel_size_m, config.pipeline.support_radius_voxels,
                  config.pipeline.support_kernel);
  if (!misfit.empty()) {
    throw std::runtime_error(path + ": the model does not fit the configuration: " + misfit);
  }
  return model;
}

}  // namespace ladar_perception
