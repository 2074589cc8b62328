// SPDX-License-Identifier: BSD-3-Clause
// Policies steer a re-sampling: each gives every point a weight, the density wanted there relative
// to elsewhere. After Cole, Harrison, Newman, section III-D (equation 8), where the weight is F.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace ladar_perception {

/// The points of one pose. Arrays are empty where the cloud has no such field, and as long as
/// `positions_m` otherwise.
struct PoseCloudData {
  std::vector<Eigen::Vector3d> positions_m;  ///< any frame; points that are not finite are ignored
  std::vector<uint32_t> rgb;                 ///< 0x00RRGGBB
  std::vector<uint8_t> labels;               ///< 0 unknown, else 1 + index of the class
  /// Where the sensor was, in the same frame: ranges count from here and normals point to it.
  Eigen::Vector3d sensor_m = Eigen::Vector3d::Zero();
};

/// What a policy may look at: the points that are finite, in the order of the cloud.
struct PointAttributes {
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<uint32_t> rgb;    ///< empty without colours
  std::vector<uint8_t> labels;  ///< empty without labels
  Eigen::Vector3d sensor_m = Eigen::Vector3d::Zero();
  /// Unit normals, towards the sensor; zero where there is no surface. Filled if a policy asks.
  std::vector<Eigen::Vector3f> normals;
  /// Variance of the angle between a point's normal and those around it, rad^2. As `normals`.
  std::vector<float> normal_variation;

  std::size_t size() const { return positions_m.size(); }
};

/// One rule. Immutable, so that clouds may be re-sampled at the same time.
class Policy {
 public:
  virtual ~Policy() = default;
  /// As it is written in a specification, for reports.
  virtual std::string describe() const = 0;
  virtual bool needsNormals() const { return false; }
  /// Multiplies every weight by this policy's; what leaves the range of float ends at its limits,
  /// so that weights stay finite and greater than 0. Throws std::runtime_error that names the
  /// policy, the field it needs and what is there, if the cloud lacks it.
  virtual void multiply(const PointAttributes& points, std::vector<float>* weights) const = 0;
};

/// Policies whose weights are multiplied; none is the uniform sampling.
using Policies = std::vector<std::shared_ptr<const Policy>>;

/// A policy from its name and options, "name" or "name:key=value,key=value":
///   uniform
///   range:min=3                          1 / max(range, min)^2, range from the sensor, m
///   normal_variation:mode=attract,ratio=16   mode attract (more where normals vary) or inhibit;
///                                        weights from 1 to ratio, spread evenly over the points:
///                                        by rank, equal where the variation is equal, and of the
///                                        middle where there is no normal
///   color:target=#b08060,softness=40,ratio=16   from ratio at the target to 1 far from it, half
///   way
///                                        at a distance of softness in RGB of 0..255 and nearly
///                                        there at three times that; a ratio below 1 avoids the
///                                        target
///   label:surface=0.2,linear=5           a factor per class name, 1 for others; `unknown` is a
///   name
/// The values are the defaults, but for target and factors, which must be given. `class_names` are
/// those of labels 1, 2, ... Throws std::invalid_argument that says what is wrong and what was
/// expected. A cloud with a label that has no name is refused with std::runtime_error.
std::shared_ptr<const Policy> makePolicy(const std::string& specification,
                                         const std::vector<std::string>& class_names = {
                                             "surface", "scatter", "linear"});

/// The user's own: `weight(points, i)` for point i. std::runtime_error names policy and point where
/// that is not finite or not greater than 0.
std::shared_ptr<const Policy> makePolicy(
    std::string name, std::function<double(const PointAttributes&, std::size_t)> weight,
    bool needs_normals = false);

}  // namespace ladar_perception
