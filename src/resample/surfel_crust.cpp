// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "crust_links.h"
#include "ladar_perception/resample/cell_blender.h"
#include "ladar_perception/resample/crust.h"
#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/surface_fit.h"

namespace ladar_perception {
namespace {

/// For every voxel of a level the least size of cells that its points want.
std::vector<uint8_t> liftLevels(const VoxelLevel& level, const std::vector<uint8_t>& below) {
  std::vector<uint8_t> lifted(level.grid.size(), 255);
  for (std::size_t i = 0; i < lifted.size(); ++i) {
    const std::size_t end = i + 1 < lifted.size() ? level.first_child[i + 1] : below.size();
    for (std::size_t child = level.first_child[i]; child < end; ++child) {
      lifted[i] = std::min(lifted[i], below[child]);
    }
  }
  return lifted;
}

/// Divides space into voxels whose points agree on the size of their cells, as an octree's leaves.
class Leaves {
 public:
  Leaves(const VoxelPyramid& pyramid, const std::vector<uint8_t>& cell_levels)
      : pyramid_(pyramid), least_({cell_levels}) {
    const uint8_t most = *std::max_element(cell_levels.begin(), cell_levels.end());
    top_ = std::min<int>(most, pyramid.levels() - 1);
    for (int level = 1; level <= top_; ++level) {
      least_.push_back(liftLevels(pyramid.level(level), least_.back()));
    }
  }

  int top() const { return top_; }

  std::vector<uint8_t> of(int level) const {
    const std::vector<uint64_t>& keys = pyramid_.level(level).grid.keys();
    std::vector<uint8_t> leaf(keys.size(), 0);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      leaf[i] =
          fits(level, static_cast<uint32_t>(i)) && !(level < top_ && fitsAbove(level, keys[i])) ? 1
                                                                                                : 0;
    }
    return leaf;
  }

  /// Whether a cell lies where the points want another size.
  bool foreign(int level, uint64_t key) const {
    const uint32_t here = pyramid_.level(level).grid.find(key);
    if (here != kNoIndex && !fits(level, here)) return true;
    return level < top_ && fitsAbove(level, key);
  }

 private:
  bool fits(int level, uint32_t voxel) const {
    return least_[static_cast<std::size_t>(level)][voxel] >= level;
  }
  bool fitsAbove(int level, uint64_t key) const {
    const uint32_t parent = pyramid_.level(level + 1).grid.find(key >> 3);
    return parent != kNoIndex && fits(level + 1, parent);
  }

  const VoxelPyramid& pyramid_;
  std::vector<std::vector<uint8_t>> least_;
  int top_ = 0;
};

}  // namespace

double Crust::area_m2() const {
  double cells = 0.0;
  for (std::size_t i = 0; i < size(); ++i) {
    cells += double{edge(i)} * edge(i) / normals[i].cwiseAbs().maxCoeff();
  }
  return cells * frame.cell_m * frame.cell_m;
}

Crust makeSurfelCrust(const VoxelPyramid& pyramid, const GridFrame& frame,
                      const std::vector<uint8_t>& cell_levels, const Eigen::Vector3f& sensor,
                      ThreadPool* pool, const std::vector<std::vector<uint32_t>>& unchanged,
                      CrustMemory* memory) {
  std::optional<Leaves> leaves;
  if (!cell_levels.empty()) leaves.emplace(pyramid, cell_levels);
  const auto levels = static_cast<std::size_t>(leaves ? leaves->top() + 1 : 1);
  if (memory != nullptr) {
    memory->fits.resize(levels);
    memory->blends.resize(levels);
  }
  std::vector<std::vector<Surfel>> surfels(levels);
  for (std::size_t i = 0; i < levels; ++i) {
    const auto level = static_cast<int>(i);
    const std::vector<uint8_t> wanted = leaves ? leaves->of(level) : std::vector<uint8_t>();
    BlendMemory blend;
    if (memory != nullptr) blend = std::move(memory->blends[i]);
    blendSurface(fitSurface(pyramid, level, wanted, sensor, pool, unchanged,
                            memory != nullptr ? &memory->fits[i] : nullptr),
                 level, pool, &blend);
    if (memory != nullptr) {
      surfels[i] = blend.surfels;
      memory->blends[i] = std::move(blend);
    } else {
      surfels[i] = std::move(blend.surfels);
    }
    if (!leaves) continue;
    const auto foreign = [&](const Surfel& cell) { return leaves->foreign(level, cell.key); };
    surfels[i].erase(std::remove_if(surfels[i].begin(), surfels[i].end(), foreign),
                     surfels[i].end());
  }
  dropCovered(&surfels);
  return linkCells(frame, surfels, pool);
}

}  // namespace ladar_perception
