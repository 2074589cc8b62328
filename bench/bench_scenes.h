// SPDX-License-Identifier: BSD-3-Clause
// Point clouds to measure on: synthetic ones made like the three scenes of Lalonde, Vandapel and
// Hebert 2005, and real ones where they are present.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ladar_perception/map/voxel_map.h"

namespace ladar_perception::bench {

/// A cloud and the map it goes into.
struct Scene {
  std::string name;
  double voxel_size_m = 0.1;
  MapShape shape;
  VoxelIndex min_corner;
  std::vector<Eigen::Vector3d> points;  ///< p_map in metres, scan line after scan line
};

/// flat_ground, forest, tall_grass, then the real ones: oakland, kitti.
const std::vector<std::string>& sceneNames();
/// Those of them whose data are present; the others are named on standard error.
std::vector<std::string> presentSceneNames();
/// Scene of that name, made on first use and kept, or nullptr (said once on standard error) where
/// its data are not present or there is none of that name. Real data are looked for in
/// $LADAR_DATA, else in `../shared/data` beside the repository.
const Scene* findScene(const std::string& name);

/// The same points in a map of other voxels that covers the same space.
Scene withVoxelSize(const Scene& scene, double voxel_size_m);
/// Every `step`-th point of the scene.
Scene thinned(const Scene& scene, std::size_t step);
/// One point in each of `density` * n voxels drawn at random, without any structure (figure 6).
Scene uniformScene(const MapShape& shape, double density, uint64_t seed);

/// A map without points for the scene. Voxels take enough points that none of a synthetic scene is
/// refused, and few enough that sums are exact for all k <= 13 (see `maxPointsPerVoxel`).
VoxelMap emptyMap(const Scene& scene);
/// Adds the scene's points, positions in metres turned into fixed point, in blocks as
/// `TerrainPipeline` does. Returns how many were in the window and not refused.
std::size_t insertAll(const Scene& scene, VoxelMap* map);
/// The same, one call of `VoxelMap::insert` per point.
std::size_t insertOneByOne(const Scene& scene, VoxelMap* map);
VoxelMap filledMap(const Scene& scene);

}  // namespace ladar_perception::bench
