// SPDX-License-Identifier: BSD-3-Clause
#include "basin_study.h"

#include <cmath>
#include <ctime>
#include <random>

namespace ladar_perception {
namespace {

constexpr double kRadians = M_PI / 180.0;

/// Random numbers that are the same for every standard library.
class StartRandom {
 public:
  explicit StartRandom(uint64_t seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  Eigen::Vector3d direction() {
    const double z = 2.0 * unit() - 1.0;
    const double angle = 2.0 * M_PI * unit();
    const double radius = std::sqrt(1.0 - z * z);
    return {radius * std::cos(angle), radius * std::sin(angle), z};
  }

 private:
  std::mt19937_64 engine_;
};

void addCurve(const std::string& family, double most, int steps, std::vector<Start>* starts) {
  for (int i = 0; i < steps; ++i) {
    Start start;
    start.family = family;
    start.amount = steps == 1 ? 0.0 : most * (2.0 * i / (steps - 1) - 1.0);
    if (family == "x") start.perturbation.translation().x() = start.amount;
    if (family == "y") start.perturbation.translation().y() = start.amount;
    if (family == "yaw") {
      start.perturbation.linear() =
          Eigen::AngleAxisd(start.amount * kRadians, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    }
    starts->push_back(start);
  }
}

double angleDeg(const Eigen::Isometry3d& motion) {
  return Eigen::AngleAxisd(motion.linear()).angle() / kRadians;
}

/// Processor time of this thread: what a registration takes on a machine that does nothing else.
double threadMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

bool isNear(const Eigen::Isometry3d& difference) {
  return difference.translation().norm() < kSuccess_m && angleDeg(difference) < kSuccess_deg;
}

}  // namespace

std::vector<Start> makeStarts(const StartOptions& options) {
  std::vector<Start> starts;
  addCurve("x", options.max_translation_m, options.curve_steps, &starts);
  addCurve("y", options.max_translation_m, options.curve_steps, &starts);
  addCurve("yaw", options.max_rotation_deg, options.curve_steps, &starts);
  StartRandom random(options.seed);
  for (int i = 0; i < options.random_starts; ++i) {
    Start start;
    start.family = "random";
    start.amount = options.max_translation_m * random.unit();
    const Eigen::Vector3d axis = random.direction();
    const double angle = options.max_rotation_deg * kRadians * random.unit();
    start.perturbation.translation() = start.amount * random.direction();
    start.perturbation.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    starts.push_back(start);
  }
  return starts;
}

void runStarts(const Registrar& registrar, const RegistrationCloud& a, const RegistrationCloud& b,
               const Eigen::Isometry3d& T_a_b_truth, const std::vector<Start>& starts,
               MethodOutcomes* method) {
  Eigen::Isometry3d own = T_a_b_truth;
  const auto outcomeOf = [&](const Start& start) {
    const double begin_ms = threadMs();
    const RegistrationResult result = registrar.align(a, b, T_a_b_truth * start.perturbation);
    const double end_ms = threadMs();
    const Eigen::Isometry3d error = T_a_b_truth.inverse() * result.T_a_b;
    if (start.family.empty()) own = result.T_a_b;
    Outcome outcome;
    outcome.success = isNear(error);
    outcome.fixed_point = isNear(own.inverse() * result.T_a_b);
    outcome.error_m = error.translation().norm();
    outcome.error_deg = angleDeg(error);
    outcome.residual_m = result.residual_m;
    outcome.overlap = result.overlap;
    outcome.ms = end_ms - begin_ms;
    outcome.verdict = result.verdict;
    if (start.family.empty()) method->T_a_b_from_truth = result.T_a_b;
    return outcome;
  };
  method->points_a = a.size();
  method->points_b = b.size();
  method->from_truth = outcomeOf(Start());
  for (const Start& start : starts) method->outcomes.push_back(outcomeOf(start));
}

}  // namespace ladar_perception
