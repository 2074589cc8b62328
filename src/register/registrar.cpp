// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/register/registrar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "judgement.h"
#include "ladar_perception/register/twist.h"

namespace ladar_perception {
namespace {

/// Pairs closer than the points' own spacing are luck.
constexpr double kLeastSpacings = 1.2;
/// Weights of the robust kernel change with every step, partners hardly, and these are dear.
constexpr int kPolishSteps = 3;
/// Of b's surface, enough to tell how much of it lies on a's.
constexpr std::size_t kOverlapPoints = 1000;
/// A point lies on a surface if it is no farther from it than these scales of the robust kernel.
constexpr double kFits = 2.0;
/// Steps below which iterations have settled, and those that are no reason to mistrust a result.
constexpr double kSettled_m = 5e-4;
constexpr double kNearlySettled_m = 0.01;

/// How another attempt differs from the first: first radius, and a turn of b about its middle.
struct Variation {
  double radius_factor = 1.0;
  double turn_deg = 0.0;
  int axis = 2;

  Eigen::Matrix3d rotation() const {
    return Eigen::AngleAxisd(turn_deg * M_PI / 180.0, Eigen::Vector3d::Unit(axis))
        .toRotationMatrix();
  }
};

constexpr double kTurn_deg = 25.0;
const std::array<Variation, 1 + RegistrationConfig::kMaxRestarts> kVariations = {
    {{1.0, 0.0, 2},
     {0.5, 0.0, 2},
     {1.0, kTurn_deg, 2},
     {1.0, -kTurn_deg, 2},
     {2.0, 0.0, 2},
     {1.0, kTurn_deg, 1},
     {1.0, -kTurn_deg, 1},
     {1.0, kTurn_deg, 0},
     {1.0, -kTurn_deg, 0}}};

/// About `count` of the points, evenly from their order: that of voxels, in a surface.
IndexedPoints someOf(const IndexedPoints& points, std::size_t count) {
  const std::size_t size = points.positions.size();
  IndexedPoints some;
  for (std::size_t i = 0; i < std::min(count, size); ++i) {
    const std::size_t at = i * size / std::min(count, size);
    some.positions.push_back(points.positions[at]);
    some.normals.push_back(points.normals[at]);
  }
  return some;
}

/// One registration, from the guess to the end.
class Descent {
 public:
  Descent(const RegistrationConfig& config, const RegistrationCloud& a, const RegistrationCloud& b,
          const Eigen::Isometry3d& T_a_b_guess, const Variation& variation)
      : config_(config),
        a_(a.parts()),
        b_(b.parts()),
        initial_radius_m_(variation.radius_factor * config.initial_radius_m) {
    matching_.target = &a_.samples;
    matching_.source = &b_.samples;
    matching_.samples = b_.samples.positions.size();
    matching_.generalized = config.cost == "generalized";
    ending_.samples = matching_.samples;
    ending_.T_a_b = T_a_b_guess;
    // Between the clouds' own origins: far from the frames' origins angles would be levers.
    ending_.T_a_b.translation() = T_a_b_guess * b.origin_m() - a.origin_m();
    ending_.T_a_b.linear() = T_a_b_guess.linear() * variation.rotation();
    double squared_m2 = 0.0;
    for (const Eigen::Vector3f& p : b_.samples.positions) squared_m2 += p.squaredNorm();
    lever_m_ = std::sqrt(squared_m2 / std::max(static_cast<double>(matching_.samples), 1.0));
  }

  void anneal() {
    matching_.index = &*a_.samples.by_normal;
    matching_.min_normal_cosine = config_.min_normal_cosine;
    const double final_m = finalRadius_m();
    const auto coarse = static_cast<std::size_t>(config_.coarse_samples);
    const std::size_t all = matching_.samples;
    for (double radius_m = initial_radius_m_; radius_m > final_m;
         radius_m *= config_.radius_factor) {
      matching_.radius_m = radius_m;
      matching_.samples = radius_m > config_.coarse_radius_m ? std::min(coarse, all) : all;
      step(1);
    }
    matching_.samples = all;
  }

  /// Against the finest points, until the steps are small.
  void polish() {
    const IndexedPoints& finest = a_.finest();
    matching_.target = &finest;
    matching_.index = &*finest.by_normal;
    matching_.robust_scale_m = config_.robust_scale_m;
    matching_.radius_m = std::max(config_.final_radius_m, kLeastSpacings * finest.spacing_m);
    iterate(kPolishSteps);
  }

  void plain() {
    matching_.index = &a_.together();
    matching_.radius_m = initial_radius_m_;
    iterate(1);
  }

  RegistrationResult result(const RegistrationCloud& a, const RegistrationCloud& b) {
    ending_.overlap = overlap();
    return judged(a, b);
  }

  /// Surface against surface, once the samples have found their place: these are few, and where
  /// they are points of the scan, each has all the noise of a single return.
  RegistrationResult finish(const RegistrationCloud& a, const RegistrationCloud& b) {
    const IndexedPoints points =
        someOf(b_.finest(), static_cast<std::size_t>(config_.finish_points));
    matching_.source = &points;
    matching_.samples = points.positions.size();
    matching_.generalized = true;
    iterate(1);
    return judged(a, b);
  }

 private:
  RegistrationResult judged(const RegistrationCloud& a, const RegistrationCloud& b) {
    FinalPairs final_pairs;
    final_pairs.pairs = findPairs(matching_, ending_.T_a_b, &memories_);
    final_pairs.sums = sumPairs(matching_, final_pairs.pairs, ending_.T_a_b, &final_pairs.details);
    ending_.targets = matching_.target->positions.size();
    return judge(config_, a, b, final_pairs, ending_);
  }

  /// Where annealing ends.
  double finalRadius_m() const {
    return std::max(config_.final_radius_m, kLeastSpacings * a_.samples.spacing_m);
  }

  /// Share of b that lies on a's surfaces, by its samples or by its surface: samples may be many
  /// where little is to be seen, as on a wall next to the sensor, and the surface is mostly ground
  /// next to it. The lesser is the honest one.
  double overlap() {
    const double of_samples = overlapOf(b_.samples, &memories_);
    if (b_.surface.positions.empty()) return of_samples;
    std::vector<SurfaceIndex::Memory> memories;
    return std::min(of_samples, overlapOf(someOf(b_.surface, kOverlapPoints), &memories));
  }

  /// Around sparse points the surface is sparse, too: partners may be as far as the samples are
  /// from each other, but not their planes.
  double overlapOf(const IndexedPoints& points, std::vector<SurfaceIndex::Memory>* memories) const {
    if (points.positions.empty()) return 0.0;
    Matching wide = matching_;
    wide.source = &points;
    wide.samples = points.positions.size();
    wide.radius_m = std::max(matching_.radius_m, finalRadius_m());
    std::size_t count = 0;
    for (const Pair& pair : findPairs(wide, ending_.T_a_b, memories)) {
      if (planeDistance(wide, pair, ending_.T_a_b) < kFits * config_.robust_scale_m) ++count;
    }
    return static_cast<double>(count) / static_cast<double>(points.positions.size());
  }

  void iterate(int steps_per_pairing) {
    memories_.clear();
    double size_m = 0.0;
    for (int i = 0; i < config_.max_iterations; ++i) {
      size_m = step(steps_per_pairing);
      if (!(size_m > kSettled_m)) break;
    }
    ending_.settled = size_m < kNearlySettled_m;
  }

  /// One pairing and some steps with it; how far these moved the samples, m.
  double step(int steps) {
    const std::vector<Pair> pairs = findPairs(matching_, ending_.T_a_b, &memories_);
    Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
    for (int i = 0; i < steps; ++i) {
      moved = expTwist(gaussNewtonStep(sumPairs(matching_, pairs, moved * ending_.T_a_b))) * moved;
    }
    ending_.T_a_b = moved * ending_.T_a_b;
    ending_.T_a_b.linear() = nearestRotation(ending_.T_a_b.linear());
    ++ending_.iterations;
    return moved.translation().norm() + lever_m_ * Eigen::AngleAxisd(moved.linear()).angle();
  }

  const RegistrationConfig& config_;
  const RegistrationCloud::Parts& a_;
  const RegistrationCloud::Parts& b_;
  double initial_radius_m_;
  Matching matching_;
  Ending ending_;
  std::vector<SurfaceIndex::Memory> memories_;
  double lever_m_ = 0.0;
};

RegistrationResult attempt(const RegistrationConfig& config, const RegistrationCloud& a,
                           const RegistrationCloud& b, const Eigen::Isometry3d& T_a_b_guess,
                           const Variation& variation) {
  Descent descent(config, a, b, T_a_b_guess, variation);
  if (config.solver == "plain") {
    descent.plain();
    return descent.result(a, b);
  }
  descent.anneal();
  descent.polish();
  RegistrationResult result = descent.result(a, b);
  if (result.verdict == Verdict::kDiverged || config.finish_points == 0) return result;
  RegistrationResult finished = descent.finish(a, b);
  return finished.verdict == Verdict::kDiverged ? result : finished;
}

/// Of two attempts the one that lays more of b on a.
bool isBetter(const RegistrationResult& one, const RegistrationResult& other) {
  const bool found = one.verdict != Verdict::kDiverged;
  if (found != (other.verdict != Verdict::kDiverged)) return found;
  return one.overlap > other.overlap;
}

}  // namespace

const char* verdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kConverged:
      return "converged";
    case Verdict::kDegenerate:
      return "degenerate";
    case Verdict::kDiverged:
      break;
  }
  return "diverged";
}

SurfaceRegistrar::SurfaceRegistrar(const RegistrationConfig& config) : config_(config) {
  std::string violations;
  for (const std::string& one : config.validate()) {
    violations += (violations.empty() ? "" : "; ") + one;
  }
  if (!violations.empty()) throw std::invalid_argument(violations);
}

RegistrationResult SurfaceRegistrar::align(const RegistrationCloud& a, const RegistrationCloud& b,
                                           const Eigen::Isometry3d& T_a_b_guess) const {
  if (!T_a_b_guess.matrix().allFinite()) {
    RegistrationResult result;
    result.reason = "the guess is not finite";
    return result;
  }
  RegistrationResult best;
  int iterations = 0;
  for (int number = 0; number <= config_.restarts; ++number) {
    RegistrationResult result =
        attempt(config_, a, b, T_a_b_guess, kVariations[static_cast<std::size_t>(number)]);
    iterations += result.iterations;
    if (number == 0 || isBetter(result, best)) best = std::move(result);
    if (best.verdict != Verdict::kDiverged && best.overlap >= config_.good_overlap) break;
  }
  best.iterations = iterations;
  return best;
}

}  // namespace ladar_perception
