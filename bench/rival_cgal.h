// SPDX-License-Identifier: BSD-3-Clause
// CGAL's classification of point sets (its package Classification) with the random forest of ETH
// Zurich, called as its manual does. CGAL's headers stay inside the .cpp.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "labeled_tile.h"

namespace ladar_perception::bench {

/// Of the generator of its multi-scale features.
struct CgalFeatureSettings {
  double voxel_size_m = -1.0;  ///< the smallest scale; -1: from the spacing of the points
  std::size_t scales = 5;      ///< each twice the one before
};

struct CgalForestSettings {
  std::size_t trees = 25;
  std::size_t depth = 20;
  std::size_t samples_per_class = 0;  ///< training points of a class at most; 0: all
};

/// What follows the forest: nothing, the mean over 12 neighbours, the mean over a sphere of three
/// voxels, or a graph cut over 12 neighbours of strength 0.2.
enum class CgalRegularization { kNone, kNeighbours, kSphere, kGraphCut };
constexpr int kCgalRegularizations = 4;
const char* cgalRegularizationName(CgalRegularization regularization);

/// A cloud as CGAL wants it, and its features.
class CgalCloud {
 public:
  explicit CgalCloud(const std::vector<Eigen::Vector3d>& points_m);
  ~CgalCloud();
  CgalCloud(CgalCloud&&) noexcept;

  /// Forgets the features.
  void clear();
  /// Everything CGAL does to a new cloud before it can classify: search trees, grids, scatter
  /// matrices, features. On one thread.
  void computeFeatures(const CgalFeatureSettings& settings);
  std::size_t features() const;
  std::size_t size() const;

 private:
  friend class CgalForest;
  friend class CgalClassifier;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A trained forest, in CGAL's own file format.
class CgalForest {
 public:
  /// `truth` of the cloud's points, each class with at least one. The same forest every time.
  CgalForest(const CgalCloud& cloud, const Labels& truth, std::size_t classes,
             const CgalForestSettings& settings);

 private:
  friend class CgalClassifier;
  std::size_t classes_;
  std::string bytes_;
};

/// A forest set on the features of a cloud, which must outlive it.
class CgalClassifier {
 public:
  CgalClassifier(const CgalForest& forest, const CgalCloud& cloud);
  ~CgalClassifier();

  /// The class of every point. On one thread.
  Labels classify(CgalRegularization regularization) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ladar_perception::bench
