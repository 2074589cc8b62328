// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/cell_blender.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"

namespace ladar_perception {
namespace {

// A piece counts in the next cell of the column, too, if its height is this near to it: the blended
// plane may lie there.
constexpr float kBorder = 0.25F;
// Planes farther than this from the middle of the cell, along the column, are the next cell's.
constexpr float kReach = 0.8F;
// Cells of a column whose normals have at least this cosine are cut by the same surface.
constexpr float kSameNormal = 0.7F;
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

/// Weighted sums of the planes in a cell, later their mean.
struct alignas(32) Blend {
  /// Normal, and offset along it from the origin; the mean has the height over the cell's middle
  /// along the main axis instead, NaN where there is no plane or it is another cell's.
  Eigen::Array4f plane = Eigen::Array4f::Zero();
  /// Trust, 0 where no piece came, and weight; the others keep the sum one operation.
  Eigen::Array4f counts = Eigen::Array4f::Zero();

  float trust() const { return counts[0]; }
  float weight() const { return counts[1]; }
};

/// A tile of cells with one cell around it: what a surface touches of it stays in the cache while
/// pieces are blended.
class TileGrid {
 public:
  static constexpr int kLevel = 5;
  static constexpr int kEdge = (1 << kLevel) + 2;

  TileGrid() : blends_(kCells), touched_(kCells + 1) {}

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
    const Brush brush(*this, piece, columns);
    // All places count from the origin, not from the tile: where tiles meet, both compute the same
    // bits for a cell, and agree on which of two cells of a column stays.
    const float base_u = 0.5F - c[static_cast<int>(u)];
    const float base_v = 0.5F - c[static_cast<int>(v)];
    // Along a row of columns the ellipse is s^2 + t^2 <= 1 with s and t linear in ru.
    const float square = columns.s_u * columns.s_u + columns.t_u * columns.t_u;
    const float by_square = 1.0F / square;
    const int u_least = std::max(range.low[u], corner_[u]);
    const int u_most = std::min(range.high[u], corner_[u] + kEdge - 1);
    const int v_end = std::min(range.high[v], corner_[v] + kEdge - 1);
    for (int cv = std::max(range.low[v], corner_[v]); cv <= v_end; ++cv) {
      const float rv = static_cast<float>(cv) + base_v;
      const float s = columns.s_v * rv;
      const float t = columns.t_v * rv;
      const float middle = -(columns.s_u * s + columns.t_u * t) * by_square;
      const float half2 = middle * middle - (s * s + t * t - 1.0F) * by_square;
      if (half2 < 0.0F) continue;
      const float half = std::sqrt(half2);
      const int u_begin = std::max(-floorToInt(base_u - (middle - half)), u_least);
      const int u_end = std::min(floorToInt(middle + half - base_u), u_most);
      const float height = c[static_cast<int>(columns.axis)] + columns.height_v * rv;
      int column = (u_begin - corner_[u]) * kStrides[u] + (cv - corner_[v]) * kStrides[v];
      for (int cu = u_begin; cu <= u_end; ++cu, column += kStrides[u]) {
        const float ru = static_cast<float>(cu) + base_u;
        const float off = ru - middle;
        const float inside = (half2 - off * off) * square;
        addToColumn(brush, height + columns.height_u * ru,
                    piece.trust * (std::max(inside, 0.0F) + kRimWeight), column);
      }
    }
  }

  /// Surfels of the tile's own cells, in the order of keys; leaves the grid empty.
  void finish(uint64_t tile, float edge, std::vector<Surfel>* surfels) {
    static const TilePlaces places;
    std::array<uint64_t, kOwnCells / 64> own{};  // bit per cell, in the order of keys
    for (std::size_t i = 0; i < touched_count_; ++i) {
      const uint16_t cell = touched_[i];
      meanOf(cell);
      const uint16_t key = places.key_of_cell[cell];
      if (key != kOutside) own[key >> 6] |= uint64_t{1} << (key & 63);
    }
    for (std::size_t word = 0; word < own.size(); ++word) {
      for (uint64_t mask = own[word]; mask != 0; mask &= mask - 1) {
        const std::size_t key = word << 6 | static_cast<std::size_t>(__builtin_ctzll(mask));
        addSurfel(places.cell_of_key[key], tile << 3 * kLevel | key, edge, surfels);
      }
    }
    for (std::size_t i = 0; i < touched_count_; ++i) blends_[touched_[i]] = Blend();
    touched_count_ = 0;
  }

 private:
  static constexpr std::size_t kCells = kEdge * kEdge * kEdge;
  static constexpr std::size_t kOwnCells = std::size_t{1} << 3 * kLevel;
  static constexpr uint16_t kOutside = 0xffff;

  /// Between the places of cells in the grid and their keys in the tile.
  struct TilePlaces {
    std::vector<uint16_t> key_of_cell;
    std::vector<uint16_t> cell_of_key;
    TilePlaces() : key_of_cell(kCells, kOutside), cell_of_key(kOwnCells) {
      for (uint32_t key = 0; key < kOwnCells; ++key) {
        const uint32_t cell = (morton::x(key) + 1) + (morton::y(key) + 1) * kEdge +
                              (morton::z(key) + 1) * kEdge * kEdge;
        key_of_cell[cell] = static_cast<uint16_t>(key);
        cell_of_key[key] = static_cast<uint16_t>(cell);
      }
    }
  };
  static constexpr std::array<int, 3> kStrides = {1, kEdge, kEdge* kEdge};

  /// What a piece adds, and where its columns lie.
  struct Brush {
    Eigen::Array4f plane;
    Eigen::Array4f counts;
    int lowest;
    int highest;
    int stride;

    Brush(const TileGrid& grid, const SurfaceFit& piece, const Columns& columns)
        : plane(piece.normal.x(), piece.normal.y(), piece.normal.z(),
                piece.normal.dot(columns.center)),
          counts(1.0F, piece.weight, 0.0F, 0.0F),
          lowest(grid.corner_[columns.axis]),
          highest(lowest + kEdge - 1),
          stride(kStrides[columns.axis]) {}
  };

  void addToColumn(const Brush& brush, float height, float trust, int column) {
    const int low = std::max(floorToInt(height - kBorder), brush.lowest);
    const int high = std::min(floorToInt(height + kBorder), brush.highest);
    for (int at = low; at <= high; ++at) {
      const int cell = column + (at - brush.lowest) * brush.stride;
      Blend& blend = blends_[static_cast<std::size_t>(cell)];
      touched_[touched_count_] = static_cast<uint16_t>(cell);
      touched_count_ += blend.trust() == 0.0F ? 1 : 0;
      blend.plane += trust * brush.plane;
      blend.counts += trust * brush.counts;
    }
  }

  Eigen::Array3f middleOf(std::size_t cell) const {
    const auto n = static_cast<int>(cell);
    return {static_cast<float>(corner_[0] + n % kEdge) + 0.5F,
            static_cast<float>(corner_[1] + n / kEdge % kEdge) + 0.5F,
            static_cast<float>(corner_[2] + n / (kEdge * kEdge)) + 0.5F};
  }

  void meanOf(std::size_t cell) {
    Blend& blend = blends_[cell];
    Eigen::Array4f& plane = blend.plane;
    const float length = std::sqrt(plane[0] * plane[0] + plane[1] * plane[1] + plane[2] * plane[2]);
    const float offset = plane[3] - (plane.head<3>() * middleOf(cell)).sum();
    const float height = offset / plane[mainAxis(plane)];
    // Normals that cancel are no surface.
    const bool surface = length > 0.1F * blend.trust() && std::abs(height) <= kReach;
    plane *= 1.0F / length;
    plane[3] = surface ? height : std::numeric_limits<float>::quiet_NaN();
  }

  static int mainAxis(const Eigen::Array4f& plane) {
    const float x = std::abs(plane[0]);
    const float y = std::abs(plane[1]);
    const float z = std::abs(plane[2]);
    return x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
  }

  void addSurfel(std::size_t cell, uint64_t key, float edge, std::vector<Surfel>* surfels) const {
    const Eigen::Array4f& plane = blends_[cell].plane;
    if (std::isnan(plane[3])) return;
    const int axis = mainAxis(plane);
    if (isBehind(cell, axis, -1) || isBehind(cell, axis, 1)) return;
    Surfel surfel;
    surfel.key = key;
    surfel.normal = plane.head<3>();
    surfel.position = middleOf(cell);
    surfel.position[axis] += plane[3];
    surfel.position *= edge;
    surfel.slowness = std::sqrt(blends_[cell].weight() / blends_[cell].trust());
    surfels->push_back(surfel);
  }

  /// Whether the next cell of the column has the same surface, nearer to its middle.
  bool isBehind(std::size_t cell, int axis, int side) const {
    const auto next = static_cast<std::size_t>(static_cast<int>(cell) +
                                               side * kStrides[static_cast<std::size_t>(axis)]);
    const Blend& other = blends_[next];
    if (other.trust() == 0.0F || std::isnan(other.plane[3])) return false;
    const Eigen::Array4f& own = blends_[cell].plane;
    if (std::abs((other.plane * own).head<3>().sum()) < kSameNormal) return false;
    // Of two cells of one column both compare the same two heights, so that one of them stays.
    const int other_axis = mainAxis(other.plane);
    const float here = std::abs(own[3]);
    const float there =
        other_axis == axis ? std::abs(other.plane[3])
                           : std::abs(other.plane[3] * other.plane[other_axis] / other.plane[axis]);
    return there < here || (there == here && side > 0);
  }

  std::array<int, 3> corner_{};  // least cell, from the origin
  std::vector<Blend> blends_;
  std::vector<uint16_t> touched_;  // the first touched_count_; the next is written before it counts
  std::size_t touched_count_ = 0;
};

CellRange cellsOf(const SurfaceFit& piece, float edge) {
  CellRange range;
  const Eigen::Vector3f minor = piece.normal.cross(piece.major);
  const Eigen::Vector3f half = ((piece.semi_major * piece.major).array().square() +
                                (piece.semi_minor * minor).array().square())
                                   .sqrt() /
                               edge;
  const Eigen::Vector3f center = piece.center / edge;
  int main_axis = 0;
  piece.normal.cwiseAbs().maxCoeff(&main_axis);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<int>(axis);
    range.low[axis] = floorToInt(center[a] - half[a] - kBorder);
    range.high[axis] = floorToInt(center[a] + half[a] + kBorder);
    if (a == main_axis) continue;
    // Columns have their middles inside the ends.
    range.low[axis] = std::max(range.low[axis], -floorToInt(0.5F - piece.low[a] / edge));
    range.high[axis] = std::min(range.high[axis], floorToInt(piece.high[a] / edge - 0.5F));
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

std::vector<BlendMemory::Tile> tilesOf(const std::vector<KeyedIndex>& entries) {
  std::vector<BlendMemory::Tile> tiles;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i == 0 || entries[i].key != entries[i - 1].key) tiles.push_back({entries[i].key, i, 0});
  }
  tiles.push_back({~uint64_t{0}, entries.size(), 0});
  return tiles;
}

/// For every tile of `now` the one of `before` that the same pieces reach, or nullptr.
std::vector<const BlendMemory::Tile*> sameTiles(const BlendMemory& now, const BlendMemory& before) {
  std::vector<const BlendMemory::Tile*> same(now.tiles.size(), nullptr);
  if (before.tiles.empty()) return same;
  const BlendMemory::Tile* old = before.tiles.data();
  for (std::size_t i = 0; i + 1 < now.tiles.size(); ++i) {
    while (old->key < now.tiles[i].key) ++old;
    if (old->key != now.tiles[i].key) continue;
    const auto first = now.entries.begin() + static_cast<std::ptrdiff_t>(now.tiles[i].first_entry);
    const auto last =
        now.entries.begin() + static_cast<std::ptrdiff_t>(now.tiles[i + 1].first_entry);
    const auto old_first = before.entries.begin() + static_cast<std::ptrdiff_t>(old->first_entry);
    const auto old_last = before.entries.begin() + static_cast<std::ptrdiff_t>(old[1].first_entry);
    if (std::equal(first, last, old_first, old_last, [&](const KeyedIndex& a, const KeyedIndex& b) {
          return now.pieces[a.index] == before.pieces[b.index];
        })) {
      same[i] = old;
    }
  }
  return same;
}

}  // namespace

void blendSurface(std::vector<SurfaceFit> pieces, int level, ThreadPool* pool,
                  BlendMemory* memory) {
  const auto edge = static_cast<float>(1 << level);
  const int origin_cell = static_cast<int>(GridFrame::kOriginCell) >> level;
  const BlendMemory before = std::move(*memory);
  BlendMemory now;
  now.pieces = std::move(pieces);
  std::vector<CellRange> ranges(now.pieces.size());
  parallelFor(pool, ranges.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ranges[i] = cellsOf(now.pieces[i], edge);
  });
  now.entries = assignToTiles(ranges, origin_cell);
  now.tiles = tilesOf(now.entries);
  const std::vector<const BlendMemory::Tile*> same = sameTiles(now, before);
  // Runs of tiles give runs of surfels, whoever works on them.
  constexpr std::size_t kRun = 8;
  const std::size_t tiles = now.tiles.size() - 1;
  std::vector<std::vector<Surfel>> runs((tiles + kRun - 1) / kRun);
  parallelForWith<TileGrid>(pool, runs.size(), [&](TileGrid* grid, std::size_t run) {
    std::vector<Surfel>& surfels = runs[run];
    for (std::size_t i = run * kRun; i < std::min((run + 1) * kRun, tiles); ++i) {
      BlendMemory::Tile& tile = now.tiles[i];
      tile.first_surfel = surfels.size();  // in the run
      if (same[i] != nullptr) {
        const Surfel* from = before.surfels.data();
        surfels.insert(surfels.end(), from + same[i][0].first_surfel,
                       from + same[i][1].first_surfel);
        continue;
      }
      grid->begin(tile.key, origin_cell);
      for (std::size_t k = tile.first_entry; k < now.tiles[i + 1].first_entry; ++k) {
        const uint32_t piece = now.entries[k].index;
        grid->blend(now.pieces[piece], ranges[piece], edge);
      }
      grid->finish(tile.key, edge, &surfels);
    }
  });
  std::vector<std::size_t> firsts = {0};
  for (const std::vector<Surfel>& run : runs) firsts.push_back(firsts.back() + run.size());
  now.surfels.resize(firsts.back());
  parallelFor(pool, runs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t run = begin; run < end; ++run) {
      std::copy(runs[run].begin(), runs[run].end(), now.surfels.data() + firsts[run]);
    }
  });
  for (std::size_t i = 0; i < tiles; ++i) now.tiles[i].first_surfel += firsts[i / kRun];
  now.tiles.back().first_surfel = now.surfels.size();
  *memory = std::move(now);
}

}  // namespace ladar_perception
