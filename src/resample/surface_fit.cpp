// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/surface_fit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "ladar_perception/resample/column_mask.h"
#include "ladar_perception/resample/morton.h"
#include "ladar_perception/resample/parallel.h"
#include "ladar_perception/saliency/eigen_symmetric3.h"

namespace ladar_perception {
namespace {

// Lengths of semi-axes, in standard deviations, and the largest, in voxels: a uniform sampling of
// the three voxels has a standard deviation of 0.87 of them. Pieces of the base level end a little
// beyond their points: with less, gaps between scan lines stay open that no voxel looks across.
// Those of coarser levels are large, and end where their points end.
constexpr float kSemiAxisPerDeviation = 2.0F;
constexpr float kLargestSemiAxis = 1.5F;
constexpr float kCoarseSemiAxisPerDeviation = 1.5F;
constexpr float kLargestCoarseSemiAxis = 1.15F;
// Coarse pieces end so much of a voxel beyond the own one where the next has a piece.
constexpr float kOverlap = 0.1F;
// Narrower pieces could slip through between the centres of cells.
constexpr float kLeastSemiAxis = 0.75F;
// Points are on a line if the second eigenvalue is below this part of the first.
constexpr float kLineRatio = 0.1F;
// Points are planar if the third eigenvalue is below this part of the second, and their standard
// deviation from the plane is below this part of a cell: a coarse piece over a wall and the panes
// of its windows would run beside both.
constexpr float kPlanarRatio = 0.05F;
constexpr float kPlanarCells = 0.3F;
// The plane of so many points is as true as what it leaves out of the surface's shape.
constexpr float kTrustedPoints = 64.0F;

// What is wanted of a voxel: a piece of surface, or another one, as that of a finer level may end
// at a gap: of three scan lines it has seen two.
constexpr uint8_t kPiece = 1;
constexpr uint8_t kSecondPiece = 2;

using Fate = VoxelFate;

Eigen::Vector3f towards(const Eigen::Vector3f& sensor, const Eigen::Vector3f& from,
                        const Eigen::Vector3f& normal) {
  return normal.dot(sensor - from) < 0.0F ? Eigen::Vector3f(-normal) : normal;
}

/// `voxel` and `base`: edges of the voxels that were fitted and of the base level.
float semiAxis(float eigenvalue, float voxel, float base) {
  const bool coarse = voxel > base;
  const float deviation = std::sqrt(std::max(eigenvalue, 0.0F));
  const float length = (coarse ? kCoarseSemiAxisPerDeviation : kSemiAxisPerDeviation) * deviation;
  const float most = (coarse ? kLargestCoarseSemiAxis : kLargestSemiAxis) * voxel;
  return std::clamp(length, kLeastSemiAxis * base, most);
}

/// The part of the direction to the sensor across `along` (zero: any), unit length.
Eigen::Vector3f facing(const Eigen::Vector3f& sensor, const Eigen::Vector3f& from,
                       const Eigen::Vector3f& along) {
  const Eigen::Vector3f ray = sensor - from;
  const Eigen::Vector3f across = ray - ray.dot(along) * along;
  // What is left of a ray along the line is rounding.
  if (across.norm() > 1e-3F * ray.norm()) return across.normalized();
  return along.isZero() ? Eigen::Vector3f::UnitZ() : Eigen::Vector3f(along.unitOrthogonal());
}

/// A normal for points in a line, which fit many planes. Lines that lie are most likely a scan on
/// the ground, and are taken for a strip of it; others face the sensor.
Eigen::Vector3f normalOfLine(const Eigen::Vector3f& sensor, const Eigen::Vector3f& center,
                             const Eigen::Vector3f& along) {
  constexpr float kLying = 0.7F;
  if (std::abs(along.z()) > kLying) return facing(sensor, center, along);
  const Eigen::Vector3f up = Eigen::Vector3f::UnitZ() - along.z() * along;
  return towards(sensor, center, up.normalized());
}

class Fitter {
 public:
  /// `before` as far as bricks are `unchanged`.
  Fitter(const VoxelPyramid& pyramid, int level, const Eigen::Vector3f& sensor, ThreadPool* pool,
         const std::vector<std::vector<uint32_t>>& unchanged, const FitMemory& before)
      : pyramid_(pyramid),
        base_(level),
        sensor_(sensor),
        pool_(pool),
        unchanged_(unchanged),
        before_(before) {}

  std::vector<SurfaceFit> run(const std::vector<uint8_t>& wanted) {
    std::vector<uint8_t> asked = wanted;
    if (asked.empty()) asked.assign(pyramid_.level(base_).grid.size(), kPiece);
    for (int level = base_; level < pyramid_.levels() && level <= base_ + kBridgeLevels; ++level) {
      fitLevel(level, std::move(asked));
      if (level + 1 < pyramid_.levels()) asked = parentsOfUnfinished(level);
    }
    addLeftOver();
    return std::move(fits_);
  }

  FitMemory takeMemory() { return std::move(now_); }

 private:
  /// Pieces of the base level overlap so much that some of the wanted voxels are left out.
  void fitLevel(int level, std::vector<uint8_t> asked) {
    const VoxelLevel& voxels = pyramid_.level(level);
    const std::vector<uint32_t> known = knownBricks(level, asked);
    now_.levels.emplace_back();
    FitMemory::Level& now = now_.levels.back();
    now.wanted = asked;
    now.asked = std::move(asked);
    now.fits.resize(voxels.grid.size());
    now.fates.resize(voxels.grid.size(), Fate::kNotWanted);
    const std::vector<PointSums> sums =
        sumNeighborhoods(voxels, level, level == base_, &now.wanted, pool_, known);
    parallelFor(pool_, voxels.grid.bricks().size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t brick = begin; brick < end; ++brick) {
        if (!known.empty() && known[brick] != kNoIndex) {
          copyBrick(level, brick, known[brick], &now);
        } else {
          fitBrick(level, brick, sums, &now);
        }
      }
    });
    if (level > base_) boundPieces(voxels.grid, level, now.fates, &now.fits);
    for (uint32_t i = 0; i < now.fits.size(); ++i) {
      if (!isPiece(now.fates[i])) continue;
      if (level < base_ + kBridgeLevels) {
        fits_.push_back(now.fits[i]);
      } else {
        addClosed(now.fits[i], i, level);
      }
    }
  }

  void fitBrick(int level, std::size_t brick, const std::vector<PointSums>& sums,
                FitMemory::Level* now) const {
    const VoxelLevel& voxels = pyramid_.level(level);
    const Eigen::Vector3f center = brickCenter(voxels.grid.bricks()[brick].key, level);
    const uint32_t last = voxels.grid.brickEnd(brick);
    for (uint32_t i = voxels.grid.bricks()[brick].first; i < last; ++i) {
      const uint8_t wanted = now->wanted[i];
      if (wanted == 0) continue;
      const Fate fate = fit(sums[i], center, level, &now->fits[i]);
      now->fates[i] = wanted != kSecondPiece  ? fate
                      : fate == Fate::kBridge ? Fate::kSurface
                                              : Fate::kNotWanted;
      now->fits[i].weight = voxels.sums[i].weight / voxels.sums[i].count;
    }
  }

  void copyBrick(int level, std::size_t brick, uint32_t from, FitMemory::Level* now) const {
    const FitMemory::Level& before = before_.levels[static_cast<std::size_t>(level - base_)];
    const uint32_t first = pyramid_.level(level).grid.bricks()[brick].first;
    const uint32_t count = pyramid_.level(level).grid.brickEnd(brick) - first;
    std::copy_n(before.wanted.begin() + from, count, now->wanted.begin() + first);
    std::copy_n(before.fits.begin() + from, count, now->fits.begin() + first);
    std::copy_n(before.fates.begin() + from, count, now->fates.begin() + first);
  }

  /// For every brick where its first voxel is in the memory, if all that its voxels depend on is as
  /// it was: points and what is asked, in it and in those around it. Empty if there is no memory.
  std::vector<uint32_t> knownBricks(int level, const std::vector<uint8_t>& asked) const {
    const auto at = static_cast<std::size_t>(level - base_);
    if (static_cast<std::size_t>(level) >= unchanged_.size() || at >= before_.levels.size()) {
      return {};
    }
    const std::vector<uint8_t>& asked_before = before_.levels[at].asked;
    const SparseGrid& grid = pyramid_.level(level).grid;
    std::vector<uint32_t> unchanged = unchanged_[static_cast<std::size_t>(level)];
    for (std::size_t brick = 0; brick < unchanged.size(); ++brick) {
      if (unchanged[brick] == kNoIndex) continue;
      const auto first = asked.begin() + grid.bricks()[brick].first;
      if (!std::equal(first, asked.begin() + grid.brickEnd(brick),
                      asked_before.begin() + unchanged[brick])) {
        unchanged[brick] = kNoIndex;
      }
    }
    std::vector<uint32_t> known = unchanged;
    for (std::size_t brick = 0; brick < known.size(); ++brick) {
      for (uint32_t direction = 0; direction < 27 && known[brick] != kNoIndex; ++direction) {
        const uint32_t near = grid.brickAround(brick, direction);
        if (near != kNoIndex && unchanged[near] == kNoIndex) known[brick] = kNoIndex;
      }
    }
    return known;
  }

  /// Adds the parts of a piece that gaps are closed in, in rectangles.
  void addClosed(const SurfaceFit& piece, uint32_t voxel, int level) {
    int main_axis = 0;
    piece.normal.cwiseAbs().maxCoeff(&main_axis);
    const int u = (main_axis + 1) % 3;
    const int v = (main_axis + 2) % 3;
    const ColumnMask mask = closeGaps(columnsWithPoints(pyramid_, level, voxel, u, v));
    const auto width = static_cast<float>(1 << (level - 2));
    const Eigen::Vector3f corner =
        cubeCenter(pyramid_.level(level).grid.keys()[voxel], level).array() -
        0.5F * width * static_cast<float>(kMaskEdge);
    // Beyond the mask nothing is known, and the piece stays as it is.
    const auto cut = [&](int axis, int begin, int end, SurfaceFit* part) {
      const float low = corner[axis] + width * static_cast<float>(begin);
      const float high = corner[axis] + width * static_cast<float>(end);
      if (begin > 0) part->low[axis] = std::max(part->low[axis], low);
      if (end < kMaskEdge) part->high[axis] = std::min(part->high[axis], high);
      return part->low[axis] < part->high[axis];
    };
    for (int row = 0, row_end = 0; row < kMaskEdge; row = row_end) {
      const uint32_t bits = mask[static_cast<std::size_t>(row)];
      do ++row_end;
      while (row_end < kMaskEdge && mask[static_cast<std::size_t>(row_end)] == bits);
      for (uint32_t rest = bits; rest != 0;) {
        const int first = __builtin_ctz(rest);
        const int end = first + __builtin_ctz(~(rest >> first));
        SurfaceFit part = piece;
        if (cut(u, first, end, &part) && cut(v, row, row_end, &part)) fits_.push_back(part);
        rest &= ~((uint32_t{1} << end) - 1);
      }
    }
  }

  static bool isPiece(Fate fate) { return fate == Fate::kSurface || fate == Fate::kBridge; }

  /// Ends pieces where the next voxel has one.
  void boundPieces(const SparseGrid& grid, int level, const std::vector<Fate>& fates,
                   std::vector<SurfaceFit>* fits) const {
    parallelFor(pool_, grid.bricks().size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t brick = begin; brick < end; ++brick) {
        uint32_t voxel = grid.bricks()[brick].first;
        for (uint64_t mask = grid.bricks()[brick].mask; mask != 0; mask &= mask - 1, ++voxel) {
          if (!isPiece(fates[voxel])) continue;
          const int bit = __builtin_ctzll(mask);
          uint32_t met = 0;
          grid.visitNear<1>(brick, bit, [&](uint32_t other, uint32_t direction, int other_bit) {
            if (isPiece(fates[other])) met |= uint32_t{1} << stepBetween(bit, direction, other_bit);
          });
          const float edge = static_cast<float>(1 << level);
          boundPiece(cubeCenter(grid.keys()[voxel], level), (0.5F + kOverlap) * edge, met,
                     &(*fits)[voxel]);
        }
      }
    });
  }

  /// `met`: the steps to voxels around that have pieces.
  static void boundPiece(const Eigen::Vector3f& middle, float half, uint32_t met,
                         SurfaceFit* piece) {
    // Of the 27 steps those to the voxels on one side, in the middle across but at any height.
    constexpr std::array<int, 3> kStride = {1, 3, 9};
    int main_axis = 0;
    piece->normal.cwiseAbs().maxCoeff(&main_axis);
    const uint32_t column =
        uint32_t{1} | uint32_t{1} << kStride[main_axis] | uint32_t{1} << 2 * kStride[main_axis];
    for (int axis = 0; axis < 3; ++axis) {
      piece->low[axis] = -SurfaceFit::kUnbounded;
      piece->high[axis] = SurfaceFit::kUnbounded;
      if (axis == main_axis) continue;
      const int across = 3 - axis - main_axis;
      const uint32_t low = column << kStride[across];
      const uint32_t high = low << 2 * kStride[axis];
      if ((met & low) != 0) piece->low[axis] = middle[axis] - half;
      if ((met & high) != 0) piece->high[axis] = middle[axis] + half;
    }
  }

  Fate fit(const PointSums& sums, const Eigen::Vector3f& brick_center, int level,
           SurfaceFit* piece) const {
    if (sums.count < kPlanePoints) return Fate::kOpen;
    const PlaneFit plane = fitPlane(sums);
    const bool line = plane.l1 < kLineRatio * plane.l2;
    const auto edge = static_cast<float>(1 << level);
    const auto base = static_cast<float>(1 << base_);
    const float flat = std::min(kPlanarRatio * plane.l1, std::pow(kPlanarCells * base, 2.0F));
    if (level > base_ && !line && plane.l0 > flat) return Fate::kOpen;
    piece->center = brick_center + plane.mean;
    piece->normal = line ? normalOfLine(sensor_, piece->center, plane.major)
                         : towards(sensor_, piece->center, plane.normal);
    piece->major = plane.major;
    piece->semi_major = semiAxis(plane.l2, edge, base);
    piece->semi_minor = semiAxis(plane.l1, edge, base);
    piece->trust =
        std::min(sums.count, kTrustedPoints) / static_cast<float>(1 << 2 * (level - base_));
    piece->level = static_cast<uint8_t>(level);
    if (line) return Fate::kLine;
    return level > base_ ? Fate::kBridge : Fate::kSurface;
  }

  std::vector<uint8_t> parentsOfUnfinished(int level) const {
    const std::vector<Fate>& fates = now_.levels.back().fates;
    const VoxelLevel& above = pyramid_.level(level + 1);
    std::vector<uint8_t> wanted(above.grid.size(), 0);
    for (std::size_t parent = 0; parent < wanted.size(); ++parent) {
      const std::size_t end =
          parent + 1 < wanted.size() ? above.first_child[parent + 1] : fates.size();
      for (std::size_t child = above.first_child[parent]; child < end; ++child) {
        if (fates[child] == Fate::kOpen || fates[child] == Fate::kLine) wanted[parent] = kPiece;
        if (fates[child] == Fate::kBridge && wanted[parent] == 0) wanted[parent] = kSecondPiece;
      }
    }
    return wanted;
  }

  /// A piece of its own, or of the line it is on, for every voxel that no level found a surface
  /// for.
  void addLeftOver() {
    const VoxelLevel& voxels = pyramid_.level(base_);
    const std::vector<FitMemory::Level>& levels = now_.levels;
    const auto edge = static_cast<float>(1 << base_);
    for (std::size_t i = 0; i < voxels.grid.size(); ++i) {
      const Fate fate = levels[0].fates[i];
      if (fate != Fate::kOpen && fate != Fate::kLine) continue;
      uint64_t key = voxels.grid.keys()[i];
      const PointSums& sums = voxels.sums[i];
      bool found = false;
      Eigen::Vector3f normal = Eigen::Vector3f::Zero();
      for (std::size_t up = 1; up < levels.size() && !found; ++up) {
        const uint32_t above =
            pyramid_.level(base_ + static_cast<int>(up)).grid.find(key >> 3 * up);
        found = isPiece(levels[up].fates[above]);
        if (levels[up].fates[above] == Fate::kLine && normal.isZero()) {
          normal = levels[up].fits[above].normal;
        }
      }
      if (found) continue;
      if (fate == Fate::kLine) {
        fits_.push_back(levels[0].fits[i]);
        continue;
      }
      SurfaceFit piece;
      piece.center =
          brickCenter(key >> 6, base_) + Eigen::Vector3f(sums.x, sums.y, sums.z) / sums.count;
      piece.normal =
          normal.isZero() ? facing(sensor_, piece.center, Eigen::Vector3f::Zero()) : normal;
      piece.major = piece.normal.unitOrthogonal();
      piece.semi_major = piece.semi_minor = kLeastSemiAxis * edge;
      piece.trust = std::min(sums.count, kTrustedPoints);
      piece.weight = sums.weight / sums.count;
      piece.level = static_cast<uint8_t>(base_);
      fits_.push_back(piece);
    }
  }

  const VoxelPyramid& pyramid_;
  int base_;
  Eigen::Vector3f sensor_;
  ThreadPool* pool_;
  const std::vector<std::vector<uint32_t>>& unchanged_;
  const FitMemory& before_;
  FitMemory now_;
  std::vector<SurfaceFit> fits_;
};

/// Adds up the 27 voxels around every wanted one of a brick.
class BrickSums {
 public:
  BrickSums(const VoxelLevel& level, int level_number)
      : level_(level), brick_edge_(static_cast<float>(4 << level_number)) {}

  void add(std::size_t brick, bool thin_out, std::vector<uint8_t>* wanted,
           std::vector<PointSums>* out) {
    const SparseGrid::Brick& here = level_.grid.bricks()[brick];
    const uint32_t end = level_.grid.brickEnd(brick);
    if (std::none_of(wanted->begin() + here.first, wanted->begin() + end,
                     [](uint8_t flag) { return flag != 0; })) {
      return;
    }
    dispatch([&]() LADAR_INLINE_LAMBDA { addAround(brick, thin_out, wanted, out); });
  }

 private:
  static constexpr int kRow = SparseGrid::kBlockEdge;
  static constexpr int kLayer = kRow * kRow;

  LADAR_INLINE void addAround(std::size_t brick, bool thin_out, std::vector<uint8_t>* wanted,
                              std::vector<PointSums>* out) {
    gatherSums(brick);
    uint32_t i = level_.grid.bricks()[brick].first;
    for (uint64_t mask = level_.grid.bricks()[brick].mask; mask != 0; mask &= mask - 1, ++i) {
      if ((*wanted)[i] == 0) continue;
      const auto bit = static_cast<uint64_t>(__builtin_ctzll(mask));
      const auto x = static_cast<int>(morton::x(bit));
      const auto y = static_cast<int>(morton::y(bit));
      const auto z = static_cast<int>(morton::z(bit));
      const int place = SparseGrid::blockIndex(x, y, z);
      if (thin_out && ((x ^ y ^ z) & 1) != 0 && isCovered(place, *wanted)) {
        (*wanted)[i] = 0;
      } else {
        (*out)[i] = around(place);
      }
    }
  }

  /// The voxels of the block one after the other, all about this brick's centre; the first has no
  /// points, and stands for all that are not there.
  LADAR_INLINE void gatherSums(std::size_t brick) {
    places_.fill(0);
    std::size_t size = 1;
    level_.grid.visitBlock(brick, [&](uint32_t voxel, int place, uint32_t direction) {
      places_[static_cast<std::size_t>(place)] = static_cast<uint8_t>(size);
      numbers_[size] = voxel;
      const auto d = static_cast<int>(direction);
      sums_[size++] = direction == 13
                          ? level_.sums[voxel]
                          : level_.sums[voxel].movedBy(
                                brick_edge_ * Eigen::Vector3f(static_cast<float>(d % 3 - 1),
                                                              static_cast<float>(d / 3 % 3 - 1),
                                                              static_cast<float>(d / 9 - 1)));
    });
  }

  /// Of an odd voxel: whether four of its sides, which are even and never left out, are wanted.
  LADAR_INLINE bool isCovered(int place, const std::vector<uint8_t>& wanted) const {
    constexpr int kSidesEnough = 4;
    int sides = 0;
    for (const int step : {-1, 1, -kRow, kRow, -kLayer, kLayer}) {
      const uint8_t other = places_[static_cast<std::size_t>(place + step)];
      sides += other != 0 && wanted[numbers_[other]] != 0 ? 1 : 0;
    }
    return sides >= kSidesEnough;
  }

  LADAR_INLINE PointSums around(int place) const {
    PointSums sum;
    // Adding nothing is quicker than asking whether there is something.
    for (int layer = place - kLayer; layer <= place + kLayer; layer += kLayer) {
      for (int row = layer - kRow; row <= layer + kRow; row += kRow) {
        for (int at = row - 1; at <= row + 1; ++at) {
          sum.add(sums_[places_[static_cast<std::size_t>(at)]]);
        }
      }
    }
    return sum;
  }

  const VoxelLevel& level_;
  float brick_edge_;
  std::array<uint8_t, SparseGrid::kBlockCells> places_;
  std::array<PointSums, SparseGrid::kBlockCells + 1> sums_;
  std::array<uint32_t, SparseGrid::kBlockCells + 1> numbers_;
};

}  // namespace

bool SurfaceFit::operator==(const SurfaceFit& other) const {
  return center == other.center && normal == other.normal && major == other.major &&
         semi_major == other.semi_major && semi_minor == other.semi_minor && trust == other.trust &&
         weight == other.weight && level == other.level && low == other.low && high == other.high;
}

PlaneFit fitPlane(const PointSums& sums) {
  PlaneFit fit;
  const float by_count = 1.0F / sums.count;
  const float x = sums.x * by_count;
  const float y = sums.y * by_count;
  const float z = sums.z * by_count;
  fit.mean = {x, y, z};
  const EigenSymmetric3 eigen = eigenSymmetric3(
      {sums.xx * by_count - x * x, sums.xy * by_count - x * y, sums.xz * by_count - x * z,
       sums.yy * by_count - y * y, sums.yz * by_count - y * z, sums.zz * by_count - z * z});
  fit.normal = eigen.e0.cast<float>();
  fit.major = eigen.e2.cast<float>();
  fit.l0 = static_cast<float>(eigen.l0);
  fit.l1 = static_cast<float>(eigen.l1);
  fit.l2 = static_cast<float>(eigen.l2);
  return fit;
}

std::vector<PointSums> sumNeighborhoods(const VoxelLevel& level, int level_number, bool thin_out,
                                        std::vector<uint8_t>* wanted, ThreadPool* pool,
                                        const std::vector<uint32_t>& known) {
  std::vector<PointSums> sums(level.grid.size());
  parallelFor(pool, level.grid.bricks().size(), 256, [&](std::size_t begin, std::size_t end) {
    BrickSums bricks(level, level_number);
    for (std::size_t brick = begin; brick < end; ++brick) {
      if (known.empty() || known[brick] == kNoIndex) bricks.add(brick, thin_out, wanted, &sums);
    }
  });
  return sums;
}

std::vector<SurfaceFit> fitSurface(const VoxelPyramid& pyramid, int level,
                                   const std::vector<uint8_t>& wanted,
                                   const Eigen::Vector3f& sensor, ThreadPool* pool,
                                   const std::vector<std::vector<uint32_t>>& unchanged,
                                   FitMemory* memory) {
  const FitMemory before = memory != nullptr ? std::move(*memory) : FitMemory();
  Fitter fitter(pyramid, level, sensor, pool, unchanged, before);
  std::vector<SurfaceFit> pieces = fitter.run(wanted);
  if (memory != nullptr) *memory = fitter.takeMemory();
  return pieces;
}

}  // namespace ladar_perception
