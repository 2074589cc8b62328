// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "ladar_perception/register/registration_config.h"
#include "ladar_perception/slam/registration_function.h"

namespace ladar_perception {

/// The package's own solver (SurfaceRegistrar) as the delayed-state estimate asks for it. Its
/// `initial_radius_m` is the most: how far the guess may be wrong is known, so that most
/// registrations may start, and end, sooner. Throws std::invalid_argument as the solver does.
RegistrationFunction surfaceRegistration(const RegistrationConfig& config);

}  // namespace ladar_perception
