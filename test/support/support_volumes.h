// SPDX-License-Identifier: BSD-3-Clause
// Support volumes of every kind, degenerate ones among them.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "ladar_perception/map/moments.h"
#include "test_random.h"

namespace ladar_perception::test {

/// The sum of the points in a support volume of radius 4, and the voxel in its middle.
struct SupportVolume {
  VoxelIndex voxel;
  Moments sum;
};

enum class VolumeKind {
  kEmpty,
  kOnePoint,
  kTwoPoints,
  kAllEqual,
  kAlongAnAxis,
  kCollinear,
  kCoplanar,
  kThreePoints,
  kNoisyPlane,
  kNoisyWire,
  kBall,
  kFull,       // as many points as exact sums allow
  kFullSlice,  // the same, on one side only
};
constexpr int kVolumeKinds = 13;

/// Makes support volumes at the origin or a million metres (of 0.1 m voxels) away from it.
class VolumeMaker {
 public:
  explicit VolumeMaker(TestRandom* random) : random_(*random) {}

  SupportVolume make(VolumeKind kind) {
    volume_ = {};
    if (random_.integer(0, 1) == 0) {
      const auto x = static_cast<int32_t>(random_.integer(-10000000, 10000000));
      const auto y = static_cast<int32_t>(random_.integer(-10000000, 10000000));
      volume_.voxel = {x, y, static_cast<int32_t>(random_.integer(-100000, 100000))};
    }
    fill(kind);
    return volume_;
  }
  std::vector<SupportVolume> makeMany(int count) {
    std::vector<SupportVolume> volumes;
    for (int i = 0; i < count; ++i) {
      volumes.push_back(make(static_cast<VolumeKind>(random_.integer(0, kVolumeKinds - 1))));
    }
    return volumes;
  }

 private:
  static constexpr int kRadius = 4;
  static constexpr int64_t kReach = kStepsPerVoxel * kRadius + kStepsPerVoxel / 2;

  void add(int64_t x, int64_t y, int64_t z) {
    const FixedPoint center = centerOf(volume_.voxel);
    volume_.sum.add({center.x + x, center.y + y, center.z + z});
  }
  void add(const Eigen::Vector3d& p) {
    add(std::llround(p.x()), std::llround(p.y()), std::llround(p.z()));
  }
  int64_t step(int64_t reach = kReach - 1) { return random_.integer(-reach, reach); }
  Eigen::Vector3d somewhere(double reach) {
    const double x = random_.real(-reach, reach);
    const double y = random_.real(-reach, reach);
    return {x, y, random_.real(-reach, reach)};
  }
  void addOne() {
    const int64_t x = step();
    const int64_t y = step();
    add(x, y, step());
  }

  void fill(VolumeKind kind) {
    const int64_t count = random_.integer(3, 300);
    switch (kind) {
      case VolumeKind::kEmpty:
        return;
      case VolumeKind::kOnePoint:
        return addOne();
      case VolumeKind::kTwoPoints:
        addOne();
        return addOne();
      case VolumeKind::kAllEqual:
        addOne();
        volume_.sum *= static_cast<uint32_t>(count);
        return;
      case VolumeKind::kThreePoints:
        for (int i = 0; i < 3; ++i) addOne();
        return;
      case VolumeKind::kAlongAnAxis:
      case VolumeKind::kCollinear:
      case VolumeKind::kCoplanar:
        return fillLattice(kind, count);
      case VolumeKind::kNoisyPlane:
      case VolumeKind::kNoisyWire:
      case VolumeKind::kBall:
        return fillNoisy(kind, count);
      case VolumeKind::kFull:
      case VolumeKind::kFullSlice:
        return fillToTheBrim(kind == VolumeKind::kFull ? kRadius : -1);
    }
  }
  /// Whole multiples of whole steps: exactly on a line or plane.
  void fillLattice(VolumeKind kind, int64_t count) {
    const int64_t axis = random_.integer(0, 2);
    const auto direction = [&](int i) {
      if (kind == VolumeKind::kAlongAnAxis) return int64_t{axis == i ? 1 : 0};
      return step(10);
    };
    const int64_t u[3] = {direction(0), direction(1), direction(2)};
    const int64_t v[3] = {step(10), step(10), step(10)};
    for (int64_t i = 0; i < count; ++i) {
      const int64_t a = step(50);
      const int64_t b = kind == VolumeKind::kCoplanar ? step(50) : 0;
      add(a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2]);
    }
  }
  void fillNoisy(VolumeKind kind, int64_t count) {
    const Eigen::Vector3d u = random_.normal3().normalized();
    const Eigen::Vector3d v = random_.normal3().normalized();
    const double noise = std::exp(random_.real(-1.0, 5.0));
    for (int64_t i = 0; i < count; ++i) {
      Eigen::Vector3d p = noise * somewhere(1.0);
      p += random_.real(-600, 600) * u;
      if (kind == VolumeKind::kNoisyPlane) p += random_.real(-300, 300) * v;
      if (kind == VolumeKind::kBall) p = somewhere(600);
      add(p);
    }
  }
  /// Every voxel up to `last_x` along x holds all it may.
  void fillToTheBrim(int last_x) {
    for (int x = -kRadius; x <= last_x; ++x) {
      for (int y = -kRadius; y <= kRadius; ++y) {
        for (int z = -kRadius; z <= kRadius; ++z) {
          const int64_t px = x * kStepsPerVoxel + step(127);
          const int64_t py = y * kStepsPerVoxel + step(127);
          add(px, py, z * kStepsPerVoxel + step(127));
        }
      }
    }
    volume_.sum *= maxPointsPerVoxel(kRadius);
  }

  TestRandom& random_;
  SupportVolume volume_;
};

}  // namespace ladar_perception::test
