// SPDX-License-Identifier: BSD-3-Clause
// Parts that the reports share.
#pragma once

#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ladar_perception/classify/gaussian_mixture.h"

namespace ladar_perception {

/// "#rrggbb".
inline std::string colorText(uint32_t rgb) {
  char text[16];
  std::snprintf(text, sizeof(text), "#%06x", rgb & 0xffffffU);
  return text;
}

/// A list of components with weight, mean and covariance.
inline nlohmann::ordered_json mixtureJson(const std::vector<GaussianComponent>& mixture) {
  auto list = nlohmann::ordered_json::array();
  for (const GaussianComponent& component : mixture) {
    nlohmann::ordered_json part = {{"weight", component.weight}};
    part["mean"] = std::vector<double>(component.mean.begin(), component.mean.end());
    for (Eigen::Index i = 0; i < component.covariance.rows(); ++i) {
      const Eigen::VectorXd row = component.covariance.row(i);
      part["covariance"].push_back(std::vector<double>(row.begin(), row.end()));
    }
    list.push_back(part);
  }
  return list;
}

}  // namespace ladar_perception
