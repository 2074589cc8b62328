// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/sensors.h"

#include <stdexcept>

namespace ladar_perception::sim {
namespace {

/// What sensors on a fixed mast that turn all round have in common.
LadarConfig spinning() {
  LadarConfig config;
  config.width_deg = 360.0;
  config.rate_hz = 10.0;
  config.max_range_m = 60.0;
  config.range_sigma_m = 0.015;
  config.range_step_m = 0.002;
  config.angle_sigma_deg = 0.02;
  config.divergence_mrad = 3.0;
  config.drop_probability = 0.005;
  config.detection_threshold = 0.004;
  config.mixed_probability = 0.1;
  config.mixed_limit_m = 1.0;
  config.mount_forward_m = 0.0;
  config.tilt_down_deg = 0.0;
  config.nod_amplitude_deg = 0.0;
  config.pan_amplitude_deg = 0.0;
  return config;
}

LadarConfig vlp16() {
  LadarConfig config = spinning();
  config.columns = 1800;
  config.rows = 16;
  for (int row = 0; row < config.rows; ++row) config.row_elevations_deg.push_back(15.0 - 2.0 * row);
  config.mount_height_m = 1.2;
  return config;
}

LadarConfig hdl64() {
  LadarConfig config = spinning();
  config.columns = 1024;
  config.rows = 64;
  for (int row = 0; row < 32; ++row) config.row_elevations_deg.push_back(2.0 - row / 3.0);
  for (int row = 0; row < 32; ++row) config.row_elevations_deg.push_back(-8.83 - 0.5 * row);
  config.range_sigma_m = 0.022;  // every laser has a bias of its own as well
  config.mount_height_m = 1.73;
  return config;
}

LadarConfig os64() {
  LadarConfig config = spinning();
  config.columns = 1024;
  config.rows = 64;
  config.height_deg = 45.0;
  config.mount_height_m = 1.5;
  return config;
}

LadarConfig pushbroom() {
  LadarConfig config;
  config.columns = 5;
  config.rows = 361;
  config.width_deg = 0.0;
  config.height_deg = 180.0;
  config.heads_deg = {-90.0};
  config.rate_hz = 7.5;
  config.row_sweep_s = 0.5 / 75.0;  // the mirror turns 75 times a second, half a turn is a line
  config.max_range_m = 60.0;
  config.range_sigma_m = 0.008;
  config.range_step_m = 0.01;
  config.divergence_mrad = 11.0;
  config.rays = 5;  // a wide beam: thin wires are seen by a part of it
  config.drop_probability = 0.005;
  config.mixed_probability = 0.2;
  config.mixed_limit_m = 1.5;
  config.mount_forward_m = 0.0;
  config.mount_height_m = 1.85;
  config.tilt_down_deg = 0.0;
  config.nod_amplitude_deg = 0.0;
  config.pan_amplitude_deg = 0.0;
  return config;
}

}  // namespace

const std::vector<std::string>& sensorNames() {
  static const std::vector<std::string> names = {"xuv", "vlp16", "hdl64", "os64", "pushbroom"};
  return names;
}

LadarConfig sensorConfig(const std::string& sensor_name) {
  if (sensor_name == "xuv") return LadarConfig();
  if (sensor_name == "vlp16") return vlp16();
  if (sensor_name == "hdl64") return hdl64();
  if (sensor_name == "os64") return os64();
  if (sensor_name == "pushbroom") return pushbroom();
  std::string known;
  for (const std::string& name : sensorNames()) known += (known.empty() ? "" : ", ") + name;
  throw std::invalid_argument("sensor '" + sensor_name + "' is unknown, expected one of " + known);
}

}  // namespace ladar_perception::sim
