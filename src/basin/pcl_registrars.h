// SPDX-License-Identifier: BSD-3-Clause
// PCL's registrations as Registrars, for comparison.
#pragma once

#include <memory>
#include <string>

#include "ladar_perception/register/registrar.h"

namespace ladar_perception {

/// "pcl_icp" (point to point), "pcl_gicp" or "pcl_ndt" (1 m cells) with partners at most
/// `max_distance_m` apart; nullptr for another name. They work from the samples alone, in a local
/// frame, and tell overlap and residual as SurfaceRegistrar does; covariance is zero.
std::unique_ptr<Registrar> makePclRegistrar(const std::string& name, double max_distance_m);

}  // namespace ladar_perception
