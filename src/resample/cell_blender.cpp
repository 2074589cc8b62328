// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/cell_blender.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"

namespace ladar_perception {
namespace {

// A piece counts in the next cell of the column, too, if its height is this near to it: the blended
// plane may lie there.
constexpr float kBorder = 0.25F;
// Planes farther than this from the middle of the cell, along the column, are the next cell's.
constexpr float kReach = 0.8F;
// Pieces count least, not nothing, at their rims.
constexpr float kRimWeight = 0.02F;

/// Weighted sums of the planes in a cell.
struct Blend {
  float trust = 0;
  float nx = 0, ny = 0, nz = 0;
  float offset = 0;  // of the plane along its normal from the cell's middle
  float weight = 0;
};

/// A cell's plane: the axis that is nearest to its normal, and where it crosses the line through the
/// cell's middle along that axis.
struct Plane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  int axis = -1;  // -1: no plane
  float height = 0;
};

/// The run of bricks that one thread fills.
struct Strip {
  std::size_t first = 0;
  std::size_t end = 0;
  uint64_t last_cell = ~uint64_t{0};  // most cells lie in the brick of the one before
  std::size_t last_brick = 0;
};

struct CellRange {
  std::array<int, 3> low{};
  std::array<int, 3> high{};
};

int cellOf(float value) { return static_cast<int>(std::floor(value)); }

class Blender {
 public:
  Blender(const std::vector<SurfaceFit>& pieces, int level, ThreadPool* pool)
      : pieces_(pieces), edge_(static_cast<float>(1 << level)), level_(level), pool_(pool) {}

  std::vector<Surfel> run() {
    allocateBricks();
    blends_.resize(64 * bricks_.bricks().size());
    const std::size_t share =
        (bricks_.bricks().size() + static_cast<std::size_t>(pool_->size()) - 1) /
        static_cast<std::size_t>(pool_->size());
    // Every thread owns a run of bricks and takes all pieces that reach it, in their order.
    pool_->run([&](int thread) {
      Strip strip;
      strip.first = share * static_cast<std::size_t>(thread);
      strip.end = std::min(strip.first + share, bricks_.bricks().size());
      if (strip.first < strip.end) blendInto(&strip);
    });
    return extract();
  }

 private:
  int originCell() const { return static_cast<int>(GridFrame::kOriginCell) >> level_; }

  /// Half of the extent of a piece along the axes, in cells.
  Eigen::Vector3f reach(const SurfaceFit& piece) const {
    const Eigen::Vector3f minor = piece.normal.cross(piece.major);
    return ((piece.semi_major * piece.major).array().square() +
            (piece.semi_minor * minor).array().square())
               .sqrt() /
           edge_;
  }

  CellRange cellsOf(const SurfaceFit& piece) const {
    CellRange range;
    const Eigen::Vector3f half = reach(piece);
    const Eigen::Vector3f center = piece.center / edge_;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<int>(axis);
      range.low[axis] = cellOf(center[a] - half[a] - kBorder) + originCell();
      range.high[axis] = cellOf(center[a] + half[a] + kBorder) + originCell();
    }
    return range;
  }

  /// Bricks that pieces may reach, those that turn out empty included.
  void allocateBricks() {
    std::vector<uint64_t> keys;
    ranges_.reserve(pieces_.size());
    std::array<uint64_t, 64> recent{};  // most pieces lie in the bricks of those before
    for (const SurfaceFit& piece : pieces_) {
      ranges_.push_back(cellsOf(piece));
      const CellRange& range = ranges_.back();
      for (int z = range.low[2] >> 2; z <= range.high[2] >> 2; ++z) {
        for (int y = range.low[1] >> 2; y <= range.high[1] >> 2; ++y) {
          for (int x = range.low[0] >> 2; x <= range.high[0] >> 2; ++x) {
            const uint64_t key = morton::encode(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                                static_cast<uint32_t>(z));
            uint64_t& slot = recent[key & 63];
            if (slot == key) continue;
            slot = key;
            keys.push_back(key);
          }
        }
      }
    }
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    // A grid whose every brick has one cell: numbers of cells are numbers of bricks.
    for (uint64_t& key : keys) key <<= 6;
    bricks_.assign(std::move(keys));
  }

  void blendInto(Strip* strip) {
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (reaches(ranges_[i], *strip)) blend(pieces_[i], ranges_[i], strip);
    }
  }

  /// Keys of a box lie between those of its corners.
  bool reaches(const CellRange& range, const Strip& strip) const {
    if (pool_->size() == 1) return true;
    const auto brickKey = [](const std::array<int, 3>& cell) {
      return morton::encode(static_cast<uint32_t>(cell[0]) >> 2, static_cast<uint32_t>(cell[1]) >> 2,
                            static_cast<uint32_t>(cell[2]) >> 2);
    };
    return brickKey(range.high) >= bricks_.bricks()[strip.first].key &&
           brickKey(range.low) <= bricks_.bricks()[strip.end - 1].key;
  }

  void blend(const SurfaceFit& piece, const CellRange& range, Strip* strip) {
    int axis = 0;
    piece.normal.cwiseAbs().maxCoeff(&axis);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const Eigen::Vector3f minor = piece.normal.cross(piece.major);
    const Eigen::Vector3f center = piece.center / edge_;
    const float by_major = edge_ / piece.semi_major;
    const float by_minor = edge_ / piece.semi_minor;
    const float slope_u = -piece.normal[u] / piece.normal[axis];
    const float slope_v = -piece.normal[v] / piece.normal[axis];
    const auto uu = static_cast<std::size_t>(u);
    const auto vv = static_cast<std::size_t>(v);
    Eigen::Vector3f r;
    std::array<int, 3> cell{};
    for (cell[vv] = range.low[vv]; cell[vv] <= range.high[vv]; ++cell[vv]) {
      r[v] = static_cast<float>(cell[vv] - originCell()) + 0.5F - center[v];
      for (cell[uu] = range.low[uu]; cell[uu] <= range.high[uu]; ++cell[uu]) {
        r[u] = static_cast<float>(cell[uu] - originCell()) + 0.5F - center[u];
        r[axis] = slope_u * r[u] + slope_v * r[v];
        const float s = r.dot(piece.major) * by_major;
        const float t = r.dot(minor) * by_minor;
        const float inside = 1.0F - (s * s + t * t);
        if (inside < 0.0F) continue;
        addToColumn(piece, axis, center[axis] + r[axis], piece.trust * (inside + kRimWeight),
                    &cell, strip);
      }
    }
  }

  void addToColumn(const SurfaceFit& piece, int axis, float height, float trust,
                   std::array<int, 3>* cell, Strip* strip) {
    const auto a = static_cast<std::size_t>(axis);
    const int low = cellOf(height - kBorder);
    const int high = cellOf(height + kBorder);
    for (int at = low; at <= high; ++at) {
      (*cell)[a] = at + originCell();
      Blend* blend = find(*cell, strip);
      if (blend == nullptr) continue;
      blend->trust += trust;
      blend->nx += trust * piece.normal.x();
      blend->ny += trust * piece.normal.y();
      blend->nz += trust * piece.normal.z();
      blend->offset +=
          trust * piece.normal[axis] * (height - (static_cast<float>(at) + 0.5F));
      blend->weight += trust * piece.weight;
    }
  }

  Blend* find(const std::array<int, 3>& cell, Strip* strip) {
    const auto x = static_cast<uint32_t>(cell[0]);
    const auto y = static_cast<uint32_t>(cell[1]);
    const auto z = static_cast<uint32_t>(cell[2]);
    const uint64_t brick_cell = (x >> 2) | uint64_t{y >> 2} << 21 | uint64_t{z >> 2} << 42;
    if (brick_cell != strip->last_cell) {
      strip->last_cell = brick_cell;
      strip->last_brick = bricks_.findBrick(morton::encode(x >> 2, y >> 2, z >> 2));
    }
    if (strip->last_brick < strip->first || strip->last_brick >= strip->end) return nullptr;
    return &blends_[64 * strip->last_brick + morton::encode(x & 3, y & 3, z & 3)];
  }

  Plane planeOf(const Blend& blend) const {
    Plane plane;
    if (blend.trust == 0.0F) return plane;
    const Eigen::Vector3f sum(blend.nx, blend.ny, blend.nz);
    const float length = sum.norm();
    // Normals that cancel are no surface.
    if (length < 0.1F * blend.trust) return plane;
    plane.normal = sum / length;
    plane.normal.cwiseAbs().maxCoeff(&plane.axis);
    plane.height = blend.offset / length / plane.normal[plane.axis];
    if (std::abs(plane.height) > kReach) plane.axis = -1;
    return plane;
  }

  std::vector<Surfel> extract() {
    const std::size_t count = bricks_.bricks().size();
    planes_.resize(64 * count);
    parallelFor(pool_, count, 512, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = 64 * begin; i < 64 * end; ++i) planes_[i] = planeOf(blends_[i]);
    });
    std::vector<Surfel> surfels;
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      if (planes_[i].axis < 0) continue;
      const uint64_t key = bricks_.bricks()[i / 64].key << 6 | (i & 63);
      if (isBehind(i, key, -1) || isBehind(i, key, 1)) continue;
      Surfel surfel;
      surfel.key = key;
      surfel.normal = planes_[i].normal;
      surfel.position = edge_ * (middle(key) + planes_[i].height * unit(planes_[i].axis));
      surfel.slowness = std::sqrt(blends_[i].weight / blends_[i].trust);
      surfels.push_back(surfel);
    }
    return surfels;
  }

  /// Whether the next cell of the column has the same surface, nearer to its middle.
  bool isBehind(std::size_t i, uint64_t key, int side) const {
    constexpr std::array<uint64_t, 3> kMasks = {morton::kAxisX, morton::kAxisY, morton::kAxisZ};
    const int axis = planes_[i].axis;
    const uint64_t next_key = morton::step(key, kMasks[static_cast<std::size_t>(axis)], side);
    const uint32_t brick =
        next_key >> 6 == key >> 6 ? static_cast<uint32_t>(i / 64) : bricks_.findBrick(next_key >> 6);
    if (brick == kNoIndex) return false;
    const Plane& next = planes_[64 * std::size_t{brick} + (next_key & 63)];
    if (next.axis != axis) return false;
    const float here = std::abs(planes_[i].height);
    const float there = std::abs(next.height);
    return there < here || (there == here && side > 0);
  }

  static Eigen::Vector3f unit(int axis) { return Eigen::Vector3f::Unit(axis); }
  Eigen::Vector3f middle(uint64_t key) const {
    const auto at = [this](uint32_t cell) {
      return static_cast<float>(static_cast<int>(cell) - originCell()) + 0.5F;
    };
    return {at(morton::x(key)), at(morton::y(key)), at(morton::z(key))};
  }

  const std::vector<SurfaceFit>& pieces_;
  float edge_;
  int level_;
  ThreadPool* pool_;
  std::vector<CellRange> ranges_;
  SparseGrid bricks_;
  std::vector<Blend> blends_;
  std::vector<Plane> planes_;
};

}  // namespace

std::vector<Surfel> blendSurface(const std::vector<SurfaceFit>& pieces, int level,
                                 ThreadPool* pool) {
  if (pieces.empty()) return {};
  return Blender(pieces, level, pool).run();
}

}  // namespace ladar_perception
