// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/cell_blender.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"
#include "ladar_perception/resample/radix_sort.h"

namespace ladar_perception {
namespace {

// A piece counts in the next cell of the column, too, if its height is this near to it: the blended
// plane may lie there.
constexpr float kBorder = 0.25F;
// Planes farther than this from the middle of the cell, along the column, are the next cell's.
constexpr float kReach = 0.8F;
// Pieces count least, not nothing, at their rims.
constexpr float kRimWeight = 0.02F;

/// Cells from low to high along the three axes, counted from the origin.
struct CellRange {
  std::array<int, 3> low{};
  std::array<int, 3> high{};
};

/// A piece as a function of the place in the column plane (u, v): height and place in the ellipse.
struct Columns {
  std::size_t axis, u, v;
  Eigen::Vector3f center;  // in cells
  float height_u, height_v;
  float s_u, s_v, t_u, t_v;

  Columns(const SurfaceFit& piece, float edge) : center(piece.center / edge) {
    int main_axis = 0;
    piece.normal.cwiseAbs().maxCoeff(&main_axis);
    const int iu = (main_axis + 1) % 3;
    const int iv = (main_axis + 2) % 3;
    axis = static_cast<std::size_t>(main_axis);
    u = static_cast<std::size_t>(iu);
    v = static_cast<std::size_t>(iv);
    height_u = -piece.normal[iu] / piece.normal[main_axis];
    height_v = -piece.normal[iv] / piece.normal[main_axis];
    const Eigen::Vector3f major = piece.major * (edge / piece.semi_major);
    const Eigen::Vector3f minor = piece.normal.cross(piece.major) * (edge / piece.semi_minor);
    s_u = major[iu] + height_u * major[main_axis];
    s_v = major[iv] + height_v * major[main_axis];
    t_u = minor[iu] + height_u * minor[main_axis];
    t_v = minor[iv] + height_v * minor[main_axis];
  }
};

/// A tile of cells with one cell around it: small enough to stay in the cache while pieces are
/// blended.
class TileGrid {
 public:
  static constexpr int kLevel = 4;
  static constexpr int kEdge = (1 << kLevel) + 2;

  TileGrid() : planes_(kCells, Eigen::Array4f::Zero()), weights_(kCells), trusts_(kCells) {}

  /// `origin_cell` is the cell at the origin; `tile` the tile's key.
  void begin(uint64_t tile, int origin_cell) {
    corner_ = {static_cast<int>(morton::x(tile) << kLevel) - origin_cell - 1,
               static_cast<int>(morton::y(tile) << kLevel) - origin_cell - 1,
               static_cast<int>(morton::z(tile) << kLevel) - origin_cell - 1};
  }

  void blend(const SurfaceFit& piece, const CellRange& range, float edge) {
    const Columns columns(piece, edge);
    const std::size_t u = columns.u;
    const std::size_t v = columns.v;
    const Eigen::Vector3f& c = columns.center;
    const Eigen::Array4f plane(piece.normal.x(), piece.normal.y(), piece.normal.z(), 0.0F);
    const int u_end = std::min(range.high[u] - corner_[u], kEdge - 1);
    const int v_end = std::min(range.high[v] - corner_[v], kEdge - 1);
    for (int iv = std::max(range.low[v] - corner_[v], 0); iv <= v_end; ++iv) {
      const float rv = static_cast<float>(iv + corner_[v]) + 0.5F - c[static_cast<int>(v)];
      for (int iu = std::max(range.low[u] - corner_[u], 0); iu <= u_end; ++iu) {
        const float ru = static_cast<float>(iu + corner_[u]) + 0.5F - c[static_cast<int>(u)];
        const float s = columns.s_u * ru + columns.s_v * rv;
        const float t = columns.t_u * ru + columns.t_v * rv;
        const float inside = 1.0F - (s * s + t * t);
        if (inside < 0.0F) continue;
        const float height = c[static_cast<int>(columns.axis)] + columns.height_u * ru +
                             columns.height_v * rv - static_cast<float>(corner_[columns.axis]);
        addToColumn(piece, plane, columns.axis, height, piece.trust * (inside + kRimWeight),
                    iu * kStrides[u] + iv * kStrides[v]);
      }
    }
  }

  /// Surfels of the tile's own cells, in the order of keys; leaves the grid empty.
  void finish(uint64_t tile, float edge, std::vector<Surfel>* surfels) {
    std::array<uint64_t, 64> own{};  // bit per cell, in the order of keys
    for (const uint16_t cell : touched_) {
      meanOf(cell);
      const int x = cell % kEdge - 1;
      const int y = cell / kEdge % kEdge - 1;
      const int z = cell / (kEdge * kEdge) - 1;
      if (std::min({x, y, z}) < 0 || std::max({x, y, z}) >= 1 << kLevel) continue;
      const uint64_t key = morton::encode(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                          static_cast<uint32_t>(z));
      own[key >> 6] |= uint64_t{1} << (key & 63);
    }
    for (uint64_t word = 0; word < own.size(); ++word) {
      for (uint64_t mask = own[word]; mask != 0; mask &= mask - 1) {
        const uint64_t key = word << 6 | static_cast<uint64_t>(__builtin_ctzll(mask));
        addSurfel(key, tile, edge, surfels);
      }
    }
    for (const uint16_t cell : touched_) {
      planes_[cell].setZero();
      weights_[cell] = 0.0F;
      trusts_[cell] = 0.0F;
    }
    touched_.clear();
  }

 private:
  static constexpr std::size_t kCells = kEdge * kEdge * kEdge;
  static constexpr std::array<int, 3> kStrides = {1, kEdge, kEdge* kEdge};

  void addToColumn(const SurfaceFit& piece, const Eigen::Array4f& plane, std::size_t axis,
                   float height, float trust, int column) {
    const int low = std::max(floorToInt(height - kBorder), 0);
    const int high = std::min(floorToInt(height + kBorder), kEdge - 1);
    for (int at = low; at <= high; ++at) {
      const auto cell = static_cast<std::size_t>(column + at * kStrides[axis]);
      if (trusts_[cell] == 0.0F) touched_.push_back(static_cast<uint16_t>(cell));
      Eigen::Array4f shifted = plane;
      shifted[3] = plane[static_cast<int>(axis)] * (height - (static_cast<float>(at) + 0.5F));
      planes_[cell] += trust * shifted;
      weights_[cell] += trust * piece.weight;
      trusts_[cell] += trust;
    }
  }

  /// From sums to the mean plane: unit normal, and height over the cell's middle along the main
  /// axis; NaN where normals cancel or the plane is another cell's.
  void meanOf(std::size_t cell) {
    Eigen::Array4f& plane = planes_[cell];
    const float length = plane.head<3>().matrix().norm();
    const float height = plane[3] / plane[mainAxis(plane)];
    const bool surface = length > 0.1F * trusts_[cell] && std::abs(height) <= kReach;
    plane /= length;
    plane[3] = surface ? height : std::numeric_limits<float>::quiet_NaN();
  }

  static int mainAxis(const Eigen::Array4f& plane) {
    int axis = 0;
    plane.head<3>().abs().maxCoeff(&axis);
    return axis;
  }

  void addSurfel(uint64_t key, uint64_t tile, float edge, std::vector<Surfel>* surfels) const {
    const std::array<int, 3> at = {static_cast<int>(morton::x(key)) + 1,
                                   static_cast<int>(morton::y(key)) + 1,
                                   static_cast<int>(morton::z(key)) + 1};
    const auto cell = static_cast<std::size_t>(at[0] + at[1] * kStrides[1] + at[2] * kStrides[2]);
    const Eigen::Array4f& plane = planes_[cell];
    if (std::isnan(plane[3])) return;
    const int axis = mainAxis(plane);
    if (isBehind(cell, axis, -1) || isBehind(cell, axis, 1)) return;
    Surfel surfel;
    surfel.key = tile << 3 * kLevel | key;
    surfel.normal = plane.head<3>();
    for (std::size_t i = 0; i < 3; ++i) {
      surfel.position[static_cast<int>(i)] = static_cast<float>(corner_[i] + at[i]) + 0.5F;
    }
    surfel.position[axis] += plane[3];
    surfel.position *= edge;
    surfel.slowness = std::sqrt(weights_[cell] / trusts_[cell]);
    surfels->push_back(surfel);
  }

  /// Whether the next cell of the column has the same surface, nearer to its middle.
  bool isBehind(std::size_t cell, int axis, int side) const {
    const auto next = static_cast<std::size_t>(static_cast<int>(cell) +
                                               side * kStrides[static_cast<std::size_t>(axis)]);
    const Eigen::Array4f& plane = planes_[next];
    if (trusts_[next] == 0.0F || std::isnan(plane[3]) || mainAxis(plane) != axis) return false;
    const float here = std::abs(planes_[cell][3]);
    const float there = std::abs(plane[3]);
    return there < here || (there == here && side > 0);
  }

  std::array<int, 3> corner_{};         // least cell, from the origin
  std::vector<Eigen::Array4f> planes_;  // weighted sums of normals and offsets from cells' middles
  std::vector<float> weights_;
  std::vector<float> trusts_;  // 0 where no piece came
  std::vector<uint16_t> touched_;
};

CellRange cellsOf(const SurfaceFit& piece, float edge) {
  CellRange range;
  const Eigen::Vector3f minor = piece.normal.cross(piece.major);
  const Eigen::Vector3f half = ((piece.semi_major * piece.major).array().square() +
                                (piece.semi_minor * minor).array().square())
                                   .sqrt() /
                               edge;
  const Eigen::Vector3f center = piece.center / edge;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<int>(axis);
    range.low[axis] = floorToInt(center[a] - half[a] - kBorder);
    range.high[axis] = floorToInt(center[a] + half[a] + kBorder);
  }
  return range;
}

/// Which pieces reach which tiles, or the cells around them, in the order of tiles.
std::vector<KeyedIndex> assignToTiles(const std::vector<CellRange>& ranges, int origin_cell) {
  std::vector<KeyedIndex> entries;
  entries.reserve(ranges.size() * 3 / 2);
  const auto tileOf = [&](int cell) {
    return static_cast<uint32_t>(cell + origin_cell) >> TileGrid::kLevel;
  };
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const CellRange& range = ranges[i];
    for (uint32_t z = tileOf(range.low[2] - 1); z <= tileOf(range.high[2] + 1); ++z) {
      for (uint32_t y = tileOf(range.low[1] - 1); y <= tileOf(range.high[1] + 1); ++y) {
        for (uint32_t x = tileOf(range.low[0] - 1); x <= tileOf(range.high[0] + 1); ++x) {
          entries.push_back({morton::encode(x, y, z), static_cast<uint32_t>(i)});
        }
      }
    }
  }
  radixSort(&entries);
  return entries;
}

}  // namespace

std::vector<Surfel> blendSurface(const std::vector<SurfaceFit>& pieces, int level,
                                 ThreadPool* pool) {
  const auto edge = static_cast<float>(1 << level);
  const int origin_cell = static_cast<int>(GridFrame::kOriginCell) >> level;
  std::vector<CellRange> ranges(pieces.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) ranges[i] = cellsOf(pieces[i], edge);
  const std::vector<KeyedIndex> entries = assignToTiles(ranges, origin_cell);
  std::vector<std::size_t> firsts;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i == 0 || entries[i].key != entries[i - 1].key) firsts.push_back(i);
  }
  firsts.push_back(entries.size());
  // Runs of tiles give runs of surfels, whoever works on them.
  constexpr std::size_t kRun = 32;
  const std::size_t tiles = firsts.size() - 1;
  std::vector<std::vector<Surfel>> runs((tiles + kRun - 1) / kRun);
  parallelFor(pool, runs.size(), 1, [&](std::size_t begin, std::size_t end) {
    TileGrid grid;
    for (std::size_t tile = begin * kRun; tile < std::min(end * kRun, tiles); ++tile) {
      const uint64_t key = entries[firsts[tile]].key;
      grid.begin(key, origin_cell);
      for (std::size_t i = firsts[tile]; i < firsts[tile + 1]; ++i) {
        grid.blend(pieces[entries[i].index], ranges[entries[i].index], edge);
      }
      grid.finish(key, edge, &runs[tile / kRun]);
    }
  });
  std::vector<Surfel> surfels;
  for (const std::vector<Surfel>& run : runs) surfels.insert(surfels.end(), run.begin(), run.end());
  return surfels;
}

}  // namespace ladar_perception
