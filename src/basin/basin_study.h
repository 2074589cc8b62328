// SPDX-License-Identifier: BSD-3-Clause
// How far a registration may start from the truth and still find it.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/register/registrar.h"

namespace ladar_perception {

/// Where registrations start.
struct StartOptions {
  int random_starts = 90;
  int curve_steps = 17;  ///< of each of x, y, yaw; 0 for none
  double max_translation_m = 4.0;
  double max_rotation_deg = 40.0;
  uint64_t seed = 1;
};

struct Start {
  std::string family;   ///< "x", "y" (m), "yaw" (degrees) or "random"
  double amount = 0.0;  ///< of the perturbation, in the unit of the family; m if random
  Eigen::Isometry3d perturbation = Eigen::Isometry3d::Identity();  ///< the guess: truth * this
};

/// Curves of one coordinate at a time, evenly from -max to max; then random starts, with directions
/// even over the sphere and lengths and angles even from 0 to the greatest.
std::vector<Start> makeStarts(const StartOptions& options);

struct Outcome {
  bool success = false;      ///< within kSuccess_m and kSuccess_deg of the truth
  bool fixed_point = false;  ///< as near to where the method ends when it starts at the truth
  double error_m = 0.0;
  double error_deg = 0.0;
  double residual_m = 0.0;
  double overlap = 0.0;
  double ms = 0.0;  ///< processor time
  Verdict verdict = Verdict::kDiverged;
};

constexpr double kSuccess_m = 0.15;
constexpr double kSuccess_deg = 1.0;

struct MethodOutcomes {
  std::string method;
  std::size_t points_a = 0;
  std::size_t points_b = 0;
  double sampling_ms = 0.0;  ///< of both clouds
  double prepare_ms = 0.0;   ///< of both clouds: indices
  Outcome from_truth;
  Eigen::Isometry3d T_a_b_from_truth = Eigen::Isometry3d::Identity();
  std::vector<Outcome> outcomes;  ///< as many as starts
};

/// One registration of every start, after one from the truth.
void runStarts(const Registrar& registrar, const RegistrationCloud& a, const RegistrationCloud& b,
               const Eigen::Isometry3d& T_a_b_truth, const std::vector<Start>& starts,
               MethodOutcomes* method);

/// Everything there is to tell, as basin.json has it; see README.
struct BasinReport {
  std::string cloud_a;
  std::string cloud_b;
  std::string solver;
  std::string truth;  ///< where it is from
  int count = 0;
  Eigen::Isometry3d T_a_b_truth = Eigen::Isometry3d::Identity();
  StartOptions options;
  std::vector<Start> starts;
  std::vector<MethodOutcomes> methods;
};

std::string basinJson(const BasinReport& report);
/// One line: method, share with its interval, median time, error.
std::string describeMethod(const BasinReport& report, const MethodOutcomes& method);

}  // namespace ladar_perception
