// SPDX-License-Identifier: BSD-3-Clause
#include "pose_resampler_node_config.h"

#include <stdexcept>

#include "ladar_perception/classify/classifier_model.h"
#include "package_path.h"

namespace ladar_perception {
namespace {

std::vector<std::string> split(const std::string& text, const char* separators) {
  std::vector<std::string> parts;
  std::size_t begin = text.find_first_not_of(separators);
  while (begin != std::string::npos) {
    const std::size_t end = text.find_first_of(separators, begin);
    parts.push_back(text.substr(begin, end == std::string::npos ? end : end - begin));
    begin = end == std::string::npos ? end : text.find_first_not_of(separators, end);
  }
  return parts;
}

std::vector<std::string> classNames(const PoseResamplerNodeConfig& config) {
  if (config.model.empty()) return split(config.class_names, " ");
  std::vector<std::string> names;
  try {
    const ClassifierModel model = loadClassifierModel(resolvePackagePath(config.model));
    for (const ModelClass& model_class : model.classes) names.push_back(model_class.name);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("model: ") + error.what());
  }
  return names;
}

}  // namespace

ResampleConfig PoseResamplerNodeConfig::defaultResampling() {
  ResampleConfig config;
  config.count = 5000;
  return config;
}

ParamTable PoseResamplerNodeConfig::table() {
  ParamTable table;
  table.add("odom_frame", &odom_frame, "frame of the poses; it must not jump");
  table.add("vehicle_frame", &vehicle_frame,
            "frame whose poses are kept and that clouds are in; empty for the cloud's own frame");
  keeper.addTo(&table);
  table.add("gather_timeout_s", &gather_timeout_s, 0.1, 3600.0, "s",
            "until_next: a cloud is complete when no scan came for this time of the wall");
  table.add("motion_compensation", &motion_compensation,
            "place every point by the pose at its own time, where the cloud has a time field");
  resampler.addTo(&table);
  table.add("policies", &policies, "what gets more samples: policies, separated by spaces or ;");
  table.add("class_names", &class_names,
            "names of the labels 1, 2, ... for the label policy, separated by spaces");
  table.add(
      "model", &model,
      "classifier model, a path or package://<package>/<path>, that names the labels instead");
  table.add("tf_timeout_s", &tf_timeout_s, 0.0, 10.0, "s",
            "how long a scan waits for its transforms before it is dropped");
  table.add("odometry_tolerance_s", &odometry_tolerance_s, 0.0, 10.0, "s",
            "a pose takes its covariance from the odometry nearest in time, not farther than this");
  table.add("queue_size", &queue_size, 1, 1000, "scans",
            "scans that may wait; the oldest is dropped when one more comes");
  table.add("pose_queue_size", &pose_queue_size, 1, 10000, "poses",
            "poses that may wait; scans wait for room, poses are never dropped for want of it");
  table.add("statistics_rate_hz", &statistics_rate_hz, 0.1, 100.0, "Hz",
            "how often statistics are published");
  return table;
}

std::vector<std::string> PoseResamplerNodeConfig::validate() const {
  std::vector<std::string> violations = keeper.validate();
  append(resampler.validate(), &violations);
  checkFrame("odom_frame", odom_frame, false, &violations);
  checkFrame("vehicle_frame", vehicle_frame, true, &violations);
  try {
    loadPolicies(*this);
  } catch (const std::runtime_error& error) {
    violations.emplace_back(error.what());
  }
  return violations;
}

Policies loadPolicies(const PoseResamplerNodeConfig& config) {
  const std::vector<std::string> names = classNames(config);
  Policies policies;
  for (const std::string& specification : split(config.policies, " ;\t\n")) {
    try {
      policies.push_back(makePolicy(specification, names));
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(std::string("policies: ") + error.what());
    }
  }
  return policies;
}

}  // namespace ladar_perception
