// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/slam/delayed_state_config.h"

#include <cmath>

namespace ladar_perception {
namespace {

constexpr double kRadPerDeg = M_PI / 180.0;

}  // namespace

void DelayedStateConfig::addTo(ParamTable* table) {
  table->add("drift_m_per_100_m", &drift_m_per_100_m, 0.0, 100.0, "m",
             "standard deviation of the odometry's position after 100 m");
  table->add("drift_deg_per_100_m", &drift_deg_per_100_m, 0.0, 100.0, "deg",
             "the same of its angles");
  table->add("odometry_floor_m", &odometry_floor_m, 1e-4, 1.0, "m",
             "standard deviation of the shortest step of the odometry");
  table->add("odometry_floor_deg", &odometry_floor_deg, 1e-3, 10.0, "deg",
             "the same of its angles");
  table->add("registration_floor_m", &registration_floor_m, 1e-4, 1.0, "m",
             "added to the standard deviation that a registration says it has");
  table->add("registration_floor_deg", &registration_floor_deg, 1e-3, 10.0, "deg",
             "the same of its angles");
  table->add("overlap_distance_m", &overlap_distance_m, 0.1, 500.0, "m",
             "clouds of poses this near to each other are taken to overlap");
  table->add("search_sigmas", &search_sigmas, 0.0, 10.0, "",
             "standard deviations by which poses may be nearer than they are estimated to be");
  table->add("max_candidates", &max_candidates, 0, 100, "poses",
             "earlier poses that a new one is registered to, besides the one before");
  table->add("accept_overlap", &accept_overlap, 0.0, 1.0, "",
             "registrations are refused where a smaller share of the samples found a partner");
  table->add("gate_chi2", &gate_chi2, 0.1, 1e6, "",
             "squared Mahalanobis distance from the estimate, 6 degrees of freedom, beyond which a "
             "registration is refused; 22.46 refuses one right one of a thousand");
  table->add("confirm_sigma_m", &confirm_sigma_m, 0.0, 1e6, "m",
             "where the estimate is less certain than this, the gate says little: a registration "
             "waits for another pose's that agrees");
  table->add("confirm_poses", &confirm_poses, 1, 10000, "poses", "it waits for this many more");
  table->add("robust_width", &robust_width, 0.1, 100.0, "",
             "standard deviations at which registrations pull with half their weight");
  table->add("window_poses", &window_poses, 2, 10000, "poses",
             "around a new pose that are optimised; the others move when a loop closes");
  table->add("loop_hops", &loop_hops, 2, 10000, "constraints",
             "a registration closes a loop if at least so many constraints led from pose to pose");
  table->add("full_update_m", &full_update_m, 0.0, 100.0, "m",
             "everything is optimised, too, when an earlier pose moved by more");
  table->add("threads", &threads, 1, 64, "threads",
             "that register; results are the same bits for any number");
}

std::vector<std::string> DelayedStateConfig::validate() const {
  std::vector<std::string> violations;
  if (loop_hops >= window_poses) {
    violations.push_back("loop_hops: " + std::to_string(loop_hops) +
                         ", expected less than window_poses, " + std::to_string(window_poses) +
                         ": longer loops do not fit the window");
  }
  return violations;
}

Matrix6d DelayedStateConfig::odometryCovariance(const Eigen::Isometry3d& T_step) const {
  const double share = T_step.translation().norm() / 100.0;
  const double drift_rad = drift_deg_per_100_m * kRadPerDeg;
  return diagonalCovariance(odometry_floor_m, odometry_floor_deg * kRadPerDeg) +
         diagonalCovariance(drift_m_per_100_m * std::sqrt(share), drift_rad * std::sqrt(share));
}

Matrix6d DelayedStateConfig::registrationFloor() const {
  return diagonalCovariance(registration_floor_m, registration_floor_deg * kRadPerDeg);
}

}  // namespace ladar_perception
