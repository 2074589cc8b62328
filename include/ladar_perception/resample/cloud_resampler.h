// SPDX-License-Identifier: BSD-3-Clause
// Re-sampling of a pose's cloud: farthest points by fast marching over a crust of grid cells. After
// Cole, Harrison, Newman, "Context and feature sensitive re-sampling from discrete surface
// measurements".
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "ladar_perception/resample/policy.h"
#include "ladar_perception/resample/resample_config.h"

namespace ladar_perception {

/// Milliseconds of one re-sampling by stage.
struct ResampleTimes {
  double voxels = 0;      ///< points into voxels, cell size
  double attributes = 0;  ///< normals and weights of the points
  double crust = 0;
  double fronts = 0;   ///< the samples
  double samples = 0;  ///< order, nearest originals, normals
  double total = 0;
};

/// The samples, farthest first: every prefix is a good sampling too. All arrays have one length.
struct ResampledCloud {
  std::vector<Eigen::Vector3d> positions_m;  ///< on the surface, or of originals if so configured
  std::vector<Eigen::Vector3f> normals;      ///< unit, towards the sensor
  std::vector<uint32_t> sources;             ///< index of the nearest point of the input
  /// The farthest any place of the crust was from the samples up to and with this one: m where the
  /// weight is 1, arrival time elsewhere; straight among the first samples, and so across islands
  /// that have none yet. Does not grow.
  std::vector<float> covering_radii;
  std::vector<float> weights;  ///< of the crust at the sample

  uint64_t points_in = 0;      ///< points given
  uint64_t points_finite = 0;  ///< of these, with finite coordinates
  uint64_t cells = 0;
  uint64_t components = 0;          ///< of the crust that were sampled
  uint64_t dropped_components = 0;  ///< too small, or more than samples (the largest were kept)
  uint64_t lone_points = 0;         ///< in none, as no other is near, and without samples
  double cell_size_m = 0;           ///< of the finest cells
  ResampleTimes times_ms;

  std::size_t size() const { return positions_m.size(); }
};

/// Re-samples clouds one after the other. Results are the same bits for any number of threads,
/// unless stopped by time. Not thread-safe; several resamplers may work at the same time.
class CloudResampler {
 public:
  /// Throws std::invalid_argument with every violation of `config`.
  explicit CloudResampler(const ResampleConfig& config);
  ~CloudResampler();
  CloudResampler(CloudResampler&&) noexcept;
  CloudResampler& operator=(CloudResampler&&) noexcept;

  /// Forgets the cloud before and re-samples this one. A cloud with fewer finite points than
  /// samples wanted gives what its crust can hold; one without any gives none. Throws
  /// std::runtime_error where a policy needs a field that the cloud lacks. With `more_to_come` what
  /// the first extend() can use is kept, for half as much memory again.
  ResampledCloud resample(const PoseCloudData& cloud, const Policies& policies = {},
                          bool more_to_come = false);

  /// Adds points to the cloud that was re-sampled last. The crust is that of all points, bit by
  /// bit, but only what depends on the new ones is worked out. Samples that are there stay, first
  /// and in their order, but for the few whose surface is now found to be elsewhere; so do their
  /// fronts, but for those that ran over or beside what has changed. `config.count` then means this
  /// many more, as far as cells of the size chosen at first hold them, and `radius_m` is what it
  /// was. `sources` count through the clouds in the order they were given. A few points in one
  /// sector of a cloud cost about half a re-sampling of all, points from everywhere as much as one.
  ResampledCloud extend(const PoseCloudData& more);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ladar_perception
