// SPDX-License-Identifier: BSD-3-Clause
// The shares of points below are what brings occupied voxels, d and P to the paper's figures.
// Thick and dense things (ground, barrier) have their neighbours in the next voxel. Thinly hit
// surfaces and the inside of bushes raise d. Single points (twigs, dust, mixed pixels) lower P.
#include "synthetic_scenes.h"

#include <algorithm>
#include <cmath>

#include "cloud_maker.h"
#include "ladar_perception/sim/height_field.h"

namespace ladar_perception::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using sim::Random;
using sim::valueNoise;

constexpr double kPi = 3.141592653589793;

template <typename T>
const T& anyOf(const std::vector<T>& all, Random* random) {
  return all[static_cast<std::size_t>(random->below(static_cast<int>(all.size())))];
}

/// Distance with an exponential distribution.
double exponential(double mean_m, Random* random) {
  return -mean_m * std::log(1.0 - random->uniform());
}

/// Point of a jersey barrier along x around y = 0: 0.81 m high, foot 0.61 m wide, top 0.15 m. Most
/// hits are on the side that faces the trail.
Vector3d onBarrier(CloudMaker* maker) {
  Random& random = maker->random();
  const double x = random.uniform(0.0, 20.0);
  if (random.chance(0.1)) return {x, random.uniform(-0.075, 0.075), 0.81};
  const double z = random.uniform(0.0, 0.81);
  const double half_m = z < 0.33 ? 0.3 - 0.5 * z : 0.135 - 0.12 * (z - 0.33);
  return {x, random.chance(0.8) ? -half_m : half_m, z};
}

/// A fallen branch.
struct Log {
  Vector2d end;
  double heading, length_m, radius_m;
};

Log drawLog(CloudMaker* maker) {
  Random& random = maker->random();
  Log log;
  log.end = maker->place();
  log.heading = random.uniform(0.0, 2.0 * kPi);
  log.length_m = random.uniform(0.5, 4.0);
  log.radius_m = random.uniform(0.03, 0.2);
  return log;
}

/// Point on the upper half of a log, its height over the ground.
Vector3d onLog(const Log& log, Random* random) {
  const double along = random->uniform(0.0, log.length_m);
  const double around = random->uniform(0.0, kPi);
  const double across = log.radius_m * std::cos(around);
  return {log.end.x() + along * std::cos(log.heading) - across * std::sin(log.heading),
          log.end.y() + along * std::sin(log.heading) + across * std::cos(log.heading),
          log.radius_m * (1.0 + std::sin(around))};
}

/// Trunk that widens towards its root.
struct Trunk {
  Vector2d foot;
  double radius_m;
};

/// Centres of bushes over a height function.
template <typename Height>
std::vector<Vector3d> drawBushes(CloudMaker* maker, int count, double y_begin_m, double y_end_m,
                                 double low_m, double high_m, Height&& ground) {
  std::vector<Vector3d> bushes;
  for (int i = 0; i < count; ++i) {
    const Vector2d p = maker->placeWithin(y_begin_m, y_end_m);
    bushes.emplace_back(p.x(), p.y(), ground(p) + maker->random().uniform(low_m, high_m));
  }
  return bushes;
}

}  // namespace

Scene makeFlatGround() {
  // 2,046,123 points are named in Table II.
  CloudMaker maker("flat_ground", {200, 200, 30}, 2046123, 11);
  Random& random = maker.random();
  constexpr double kBarrier_y = 15.2;
  constexpr double kFoot_y = kBarrier_y + 0.3;
  // The trail lies in the middle of voxels of 10 and 20 cm and on a face of those of 5 cm: only so
  // can it have as many of each as in Table II.
  const auto ground = [&](const Vector2d& p) {
    const double trail = 0.65 + 0.008 * valueNoise(0.3 * p.x(), 0.3 * p.y(), 1);
    if (p.y() <= kFoot_y) return trail;
    return trail + 0.23 * (p.y() - kFoot_y) + 0.06 * valueNoise(2.0 * p.x(), 2.0 * p.y(), 2);
  };
  maker.add(0.03, [&]() -> Vector3d {
    return maker.noisy(onBarrier(&maker) + Vector3d(0.0, kBarrier_y, 0.65));
  });
  maker.add(0.004, [&]() -> Vector3d {  // concertina wire: a helix across the trail
    const double y = random.uniform(1.0, kBarrier_y - 0.3);
    const double turn = 2.0 * kPi * y / 0.3;
    return maker.noisy({12.0 + 0.42 * std::cos(turn), y, 1.1 + 0.42 * std::sin(turn)});
  });
  maker.add(0.05, [&]() -> Vector3d {  // grass on the bank
    const Vector2d p = maker.placeWithin(kFoot_y, 20.0);
    const double tall_m = 0.1 * (1.0 + valueNoise(1.5 * p.x(), 1.5 * p.y(), 3));
    return {p.x(), p.y(), ground(p) + tall_m * random.uniform()};
  });
  const auto bushes = drawBushes(&maker, 8, kFoot_y, 20.0, 0.4, 0.4, ground);
  maker.add(0.0008, [&]() -> Vector3d { return maker.inBall(anyOf(bushes, &random), 0.5); });
  maker.add(0.0006, [&]() -> Vector3d {  // stalks, dust, mixed pixels
    const Vector2d p = maker.place();
    return {p.x(), p.y(), ground(p) + exponential(0.4, &random)};
  });
  return maker.finish([&]() -> Vector3d {
    const Vector2d p = maker.groundHit(4.0);
    return {p.x(), p.y(), ground(p) + random.normal(0.0, 0.012)};
  });
}

Scene makeForest() {
  CloudMaker maker("forest", {160, 250, 40}, 1700000, 12);
  Random& random = maker.random();
  const auto ground = [&](const Vector2d& p) {
    return 0.6 + 0.25 * valueNoise(0.15 * p.x(), 0.15 * p.y(), 1) +
           0.12 * valueNoise(0.6 * p.x(), 0.6 * p.y(), 2) +
           0.04 * valueNoise(2.5 * p.x(), 2.5 * p.y(), 3);
  };
  std::vector<Trunk> trunks;
  for (int i = 0; i < 42; ++i) {
    const Vector2d foot = maker.place();
    trunks.push_back({foot, random.uniform(0.14, 0.36)});
  }
  maker.add(0.016, [&]() -> Vector3d {
    const Trunk& trunk = anyOf(trunks, &random);
    const double up = random.uniform(0.0, 4.0);
    const double radius_m = trunk.radius_m * (1.0 + 0.5 * std::exp(-4.0 * up)) - 0.01 * up;
    const double z = ground(trunk.foot) + up;
    return maker.noisy(maker.onMantle(trunk.foot, radius_m, z, z));
  });
  maker.add(0.15, [&]() -> Vector3d {  // short grass
    const Vector2d p = maker.groundHit(6.0);
    const double tall_m = 0.105 * (1.0 + valueNoise(1.2 * p.x(), 1.2 * p.y(), 4));
    return {p.x(), p.y(), ground(p) + tall_m * random.uniform()};
  });
  std::vector<Log> logs;
  for (int i = 0; i < 60; ++i) logs.push_back(drawLog(&maker));
  maker.add(0.05, [&]() -> Vector3d {
    const Vector3d p = onLog(anyOf(logs, &random), &random);
    return p + Vector3d(0.0, 0.0, ground(p.head<2>()));
  });
  const auto bushes = drawBushes(&maker, 24, 0.0, 25.0, 0.2, 2.0, ground);
  maker.add(0.004, [&]() -> Vector3d { return maker.inBall(anyOf(bushes, &random), 0.5); });
  maker.add(0.0001, [&]() -> Vector3d {  // twigs
    const Vector2d p = maker.place();
    return {p.x(), p.y(), ground(p) + exponential(0.25, &random)};
  });
  return maker.finish([&]() -> Vector3d {
    const Vector2d p = maker.groundHit(3.0);
    return {p.x(), p.y(), ground(p) + random.normal(0.0, 0.015)};
  });
}

Scene makeTallGrass() {
  CloudMaker maker("tall_grass", {200, 300, 30}, 1200000, 13);
  Random& random = maker.random();
  const auto ground = [&](const Vector2d& p) {
    return 0.1 + 0.035 * p.y() + 0.08 * valueNoise(0.3 * p.x(), 0.3 * p.y(), 1);
  };
  maker.add(0.02, [&]() -> Vector3d {  // seven poles to above the window
    const int pole = random.below(7);
    const Vector2d foot(2.0 + 2.7 * pole, 6.0 + 4.1 * ((pole * 3) % 5));
    return maker.noisy(maker.onMantle(foot, 0.15, ground(foot), 3.0));
  });
  const auto bushes = drawBushes(&maker, 30, 0.0, 30.0, 0.9, 1.3, ground);
  maker.add(0.003, [&]() -> Vector3d { return maker.inBall(anyOf(bushes, &random), 0.5); });
  return maker.finish([&]() -> Vector3d {
    // The ladar sees the tips of the grass and a little into it; where it is thin, the ground.
    const Vector2d p = maker.groundHit(7.0);
    const double tips = ground(p) + 0.75 + 0.2 * valueNoise(0.8 * p.x(), 0.8 * p.y(), 2) +
                        0.03 * valueNoise(5.0 * p.x(), 5.0 * p.y(), 3);
    return {p.x(), p.y(), std::max(tips - exponential(0.025, &random), ground(p))};
  });
}

}  // namespace ladar_perception::bench
