// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/register/registration_config.h"

namespace ladar_perception {

void RegistrationConfig::addTo(ParamTable* table) {
  table->add("solver", &solver,
             "annealed, with pairs of alike normals within a radius that shrinks, or plain, with "
             "the nearest points within initial_radius_m");
  table->add("cost", &cost,
             "point_to_plane, or generalized, which takes both surfaces' normals into account");
  table->add("initial_radius_m", &initial_radius_m, 0.05, 100.0, "m",
             "pairs are at most this far apart at first; as far as the guess may be wrong");
  table->add("coarse_radius_m", &coarse_radius_m, 0.0, 100.0, "m",
             "above this radius the first coarse_samples points are enough");
  table->add("final_radius_m", &final_radius_m, 0.01, 10.0, "m",
             "the radius shrinks to this, or to 1.2 spacings of the points if that is more");
  table->add("radius_factor", &radius_factor, 0.1, 0.99, "", "of the radius, every iteration");
  table->add("coarse_samples", &coarse_samples, 10, 1000000, "samples",
             "farthest first, that take part while the radius is large");
  table->add("min_normal_cosine", &min_normal_cosine, -1.0, 1.0, "",
             "of the angle between the normals of a pair");
  table->add("robust_scale_m", &robust_scale_m, 0.001, 10.0, "m",
             "of the kernel in the last iterations; pairs farther apart count little");
  table->add("max_iterations", &max_iterations, 1, 1000, "iterations",
             "of the last stage, and of the plain solver");
  table->add(
      "finish_points", &finish_points, 0, 1000000, "points",
      "of b's surface, that are laid on a's surface at the end, where clouds come with more "
      "points than their samples; 0: samples are the last. 10000 take as long as all before, "
      "and leave half of its error");
  table->add(
      "restarts", &restarts, 0, kMaxRestarts, "restarts",
      "of a registration that diverged or whose overlap is not good: with half the first "
      "radius, then from guesses that are turned by 25 degrees (yaw, pitch, roll); twice the "
      "radius is the fourth. What lays most on the other cloud is the result");
  table->add("min_overlap", &min_overlap, 0.0, 1.0, "",
             "a lesser share of a cloud that lies on the other at the end is no registration");
  table->add("good_overlap", &good_overlap, 0.0, 1.0, "",
             "a lesser share is a reason for a restart");
  table->add("min_information", &min_information, 0.0, 1.0, "",
             "motions of which pairs see a lesser share, squared, are weak: the corridor's length");
}

std::vector<std::string> RegistrationConfig::validate() const {
  std::vector<std::string> violations;
  if (solver != "annealed" && solver != "plain") {
    violations.push_back("solver: '" + solver + "', expected annealed or plain");
  }
  if (cost != "point_to_plane" && cost != "generalized") {
    violations.push_back("cost: '" + cost + "', expected point_to_plane or generalized");
  }
  if (initial_radius_m < final_radius_m) {
    violations.push_back("initial_radius_m: " + std::to_string(initial_radius_m) +
                         ", must not be less than final_radius_m");
  }
  return violations;
}

}  // namespace ladar_perception
