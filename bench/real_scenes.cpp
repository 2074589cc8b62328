// SPDX-License-Identifier: BSD-3-Clause
#include "real_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "ladar_perception/io/kitti_reader.h"
#include "ladar_perception/io/pose_file.h"
#include "ladar_perception/io/text_reader.h"

namespace ladar_perception::bench {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> positionsOf(const Scan& scan) {
  const auto x = readColumn(scan, "x");
  const auto y = readColumn(scan, "y");
  const auto z = readColumn(scan, "z");
  std::vector<Vector3d> points;
  points.reserve(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) points.emplace_back(x[i], y[i], z[i]);
  return points;
}

Vector3d lowCornerOf(const Scene& scene) {
  return scene.voxel_size_m * Vector3d(scene.min_corner.x, scene.min_corner.y, scene.min_corner.z);
}

Vector3d sizeOf(const Scene& scene) {
  return scene.voxel_size_m * Vector3d(scene.shape.nx, scene.shape.ny, scene.shape.nz);
}

/// Keeps the points in the scene's window.
void crop(Scene* scene) {
  const Vector3d low = lowCornerOf(*scene);
  const Vector3d high = low + sizeOf(*scene);
  const auto outside = [&](const Vector3d& p) {
    return !((p.array() >= low.array()).all() && (p.array() < high.array()).all());
  };
  auto& points = scene->points;
  points.erase(std::remove_if(points.begin(), points.end(), outside), points.end());
}

/// Moves the window, in steps, to where it holds most of the points.
void moveToDensest(Scene* scene) {
  const auto& points = scene->points;
  Vector3d low = points.front();
  Vector3d high = points.front();
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vector3d step_m(4.0, 4.0, 1.6);
  const Vector3d size = sizeOf(*scene);
  std::size_t best = 0;
  Vector3d best_corner = low;
  Vector3d corner;
  for (corner.x() = low.x(); corner.x() < high.x(); corner.x() += step_m.x()) {
    for (corner.y() = low.y(); corner.y() < high.y(); corner.y() += step_m.y()) {
      for (corner.z() = low.z(); corner.z() < high.z(); corner.z() += step_m.z()) {
        const Vector3d end = corner + size;
        const auto inside = static_cast<std::size_t>(
            std::count_if(points.begin(), points.end(), [&](const Vector3d& p) {
              return (p.array() >= corner.array()).all() && (p.array() < end.array()).all();
            }));
        if (inside <= best) continue;
        best = inside;
        best_corner = corner;
      }
    }
  }
  const Vector3d voxel = best_corner / scene->voxel_size_m;
  scene->min_corner = {static_cast<int32_t>(std::floor(voxel.x())),
                       static_cast<int32_t>(std::floor(voxel.y())),
                       static_cast<int32_t>(std::floor(voxel.z()))};
}

}  // namespace

Scene makeOakland(const std::string& data_folder) {
  Scene scene;
  scene.name = "oakland";
  scene.shape = {400, 400, 64};
  const std::string tile = data_folder + "/oakland/tiles/oakland_part2_ah.xyz_label_conf";
  scene.points = positionsOf(readOaklandScan(tile));
  moveToDensest(&scene);
  crop(&scene);
  return scene;
}

Scene makeKitti(const std::string& data_folder) {
  Scene scene;
  scene.name = "kitti";
  scene.shape = {400, 400, 40};
  // The sensor stands 1.73 m above the ground.
  scene.min_corner = {-200, -200, -25};
  const std::string folder = data_folder + "/kitti00/";
  const Poses poses = readPoses(folder + "icp_reference_T_lidar0_lidari.txt", PoseFormat::kKitti);
  constexpr std::array<const char*, 6> kScans = {"000000.bin", "000001.bin", "000002.bin",
                                                 "000003.bin", "000004.bin", "000005.bin"};
  for (std::size_t i = 0; i < kScans.size(); ++i) {
    for (const Vector3d& p : positionsOf(readKittiScan(folder + kScans[i]))) {
      scene.points.push_back(poses.T_map_lidar.at(i) * p);
    }
  }
  crop(&scene);
  return scene;
}

}  // namespace ladar_perception::bench
