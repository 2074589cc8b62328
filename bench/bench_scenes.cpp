// SPDX-License-Identifier: BSD-3-Clause
#include "bench_scenes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>

#include "ladar_perception/sim/random.h"
#include "ladar_perception/util/dispatch.h"
#include "real_scenes.h"
#include "synthetic_scenes.h"

namespace ladar_perception::bench {
namespace {

constexpr int kLargestRadius_voxels = 6;  // k = 13

std::string dataFolder() {
  const char* folder = std::getenv("LADAR_DATA");
  return folder != nullptr ? folder : LADAR_SOURCE_DIR "/../shared/data";
}

std::unique_ptr<Scene> make(const std::string& name) {
  if (name == "flat_ground") return std::make_unique<Scene>(makeFlatGround());
  if (name == "forest") return std::make_unique<Scene>(makeForest());
  if (name == "tall_grass") return std::make_unique<Scene>(makeTallGrass());
  try {
    if (name == "oakland") return std::make_unique<Scene>(makeOakland(dataFolder()));
    if (name == "kitti") return std::make_unique<Scene>(makeKitti(dataFolder()));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scene %s is left out: %s\n", name.c_str(), error.what());
    return nullptr;
  }
  std::fprintf(stderr, "there is no scene %s\n", name.c_str());
  return nullptr;
}

int scaled(int voxels, double factor) {
  return static_cast<int>(std::ceil(voxels * factor - 1e-9));
}

}  // namespace

const std::vector<std::string>& sceneNames() {
  static const std::vector<std::string> names = {"flat_ground", "forest", "tall_grass", "oakland",
                                                 "kitti"};
  return names;
}

std::vector<std::string> presentSceneNames() {
  std::vector<std::string> present;
  for (const std::string& name : sceneNames()) {
    const bool is_real = name == "oakland" || name == "kitti";
    const std::string folder = dataFolder() + (name == "oakland" ? "/oakland/tiles" : "/kitti00");
    if (!is_real || std::filesystem::is_directory(folder)) {
      present.push_back(name);
    } else {
      std::fprintf(stderr, "scene %s is left out: no folder %s\n", name.c_str(), folder.c_str());
    }
  }
  return present;
}

const Scene* findScene(const std::string& name) {
  static std::map<std::string, std::unique_ptr<Scene>> made;
  const auto it = made.find(name);
  if (it != made.end()) return it->second.get();
  return made.emplace(name, make(name)).first->second.get();
}

Scene withVoxelSize(const Scene& scene, double voxel_size_m) {
  Scene result = scene;
  const double factor = scene.voxel_size_m / voxel_size_m;
  result.voxel_size_m = voxel_size_m;
  result.shape = {scaled(scene.shape.nx, factor), scaled(scene.shape.ny, factor),
                  scaled(scene.shape.nz, factor)};
  const auto corner = [&](int32_t index) {
    return static_cast<int32_t>(std::floor(index * factor + 1e-9));
  };
  result.min_corner = {corner(scene.min_corner.x), corner(scene.min_corner.y),
                       corner(scene.min_corner.z)};
  return result;
}

Scene thinned(const Scene& scene, std::size_t step) {
  Scene result;
  result.name = scene.name;
  result.voxel_size_m = scene.voxel_size_m;
  result.shape = scene.shape;
  result.min_corner = scene.min_corner;
  for (std::size_t i = 0; i < scene.points.size(); i += step) {
    result.points.push_back(scene.points[i]);
  }
  return result;
}

Scene uniformScene(const MapShape& shape, double density, uint64_t seed) {
  Scene scene;
  scene.name = "uniform";
  scene.shape = shape;
  sim::Random random(seed);
  std::vector<uint8_t> taken(static_cast<std::size_t>(shape.nx) * shape.ny * shape.nz, 0);
  const auto count = static_cast<std::size_t>(density * static_cast<double>(taken.size()));
  while (scene.points.size() < count) {
    const int x = random.below(shape.nx);
    const int y = random.below(shape.ny);
    const int z = random.below(shape.nz);
    uint8_t& voxel = taken[(static_cast<std::size_t>(z) * shape.ny + y) * shape.nx + x];
    if (voxel != 0) continue;
    voxel = 1;
    scene.points.push_back(scene.voxel_size_m * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5));
  }
  return scene;
}

VoxelMap emptyMap(const Scene& scene) {
  VoxelMap map(scene.shape, maxPointsPerVoxel(kLargestRadius_voxels));
  map.scrollTo(scene.min_corner);
  return map;
}

std::size_t insertAll(const Scene& scene, VoxelMap* map) {
  constexpr std::size_t kBlock = 256;
  constexpr std::size_t kAhead = 12;  // points whose records are on their way from memory
  const double steps_per_m = static_cast<double>(kStepsPerVoxel) / scene.voxel_size_m;
  const std::vector<Eigen::Vector3d>& points = scene.points;
  std::size_t inserted = 0;
  dispatch([&]() LADAR_INLINE_LAMBDA {
    FixedPoint q[kBlock];
    CellId cells[kBlock];
    for (std::size_t first = 0; first < points.size(); first += kBlock) {
      const std::size_t count = std::min(kBlock, points.size() - first);
      for (std::size_t i = 0; i < count; ++i) {
        q[i] = toFixedPoint(points[first + i], steps_per_m);
        cells[i] = map->cellOf(q[i]);
        if (cells[i] != kNoCell) map->prefetchColumn(cells[i]);
      }
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t later = i + kAhead;
        if (later < count && cells[later] != kNoCell) map->prefetchRecord(cells[later]);
        if (cells[i] == kNoCell) continue;
        inserted += map->insertAt(cells[i], q[i]) == InsertResult::kInserted ? 1 : 0;
      }
    }
  });
  return inserted;
}

std::size_t insertOneByOne(const Scene& scene, VoxelMap* map) {
  const double steps_per_m = static_cast<double>(kStepsPerVoxel) / scene.voxel_size_m;
  std::size_t inserted = 0;
  CellId cell = kNoCell;
  for (const Eigen::Vector3d& p_map : scene.points) {
    const auto result = map->insert(toFixedPoint(p_map, steps_per_m), &cell);
    inserted += result == InsertResult::kInserted ? 1 : 0;
  }
  return inserted;
}

VoxelMap filledMap(const Scene& scene) {
  VoxelMap map = emptyMap(scene);
  insertAll(scene, &map);
  return map;
}

}  // namespace ladar_perception::bench
