// SPDX-License-Identifier: BSD-3-Clause
// A world to look at: ground, and models placed on it many times.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/sim/bvh.h"
#include "ladar_perception/sim/height_field.h"
#include "ladar_perception/sim/primitive.h"

namespace ladar_perception::sim {

/// Where a model stands. The model's z axis stays vertical.
struct Placement {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;
  double scale = 1.0;
};

/// What a ray met.
struct Hit {
  double range = kMiss;  ///< the ray's t; metres if its direction has unit length
  Truth truth = Truth::kNone;
  Material material = Material::kSoil;
  uint32_t rgb = 0;        ///< 0x00RRGGBB
  double incidence = 0.0;  ///< cosine between the ray and the surface's normal, 0..1

  bool valid() const { return range < kMiss; }
};

/// Ground and placed models. Leaves by the thousand are stored once per model, not once per tree.
class Scene {
 public:
  explicit Scene(HeightField ground) : ground_(std::move(ground)) {}

  const HeightField& ground() const { return ground_; }
  /// Adds a model in its own coordinates; returns its number.
  uint32_t addModel(std::vector<Primitive> primitives);
  void place(uint32_t model, const Placement& placement);
  /// Builds the tree over all placements; call once, after the last place().
  void finish();

  /// The first thing a ray meets at t <= `t_limit`. `with_ground` false looks at models only.
  Hit castRay(const Ray& ray, double t_limit, bool with_ground = true) const;
  /// The same without the trees of boxes: the oracle of the tests.
  Hit castRayBruteForce(const Ray& ray, double t_limit, bool with_ground = true) const;

  /// Horizontal reach of a model's parts that begin below `height_m`, from its origin.
  double reachBelow(uint32_t model, double height_m) const;
  std::size_t placementCount() const { return instances_.size(); }
  /// Shapes stored, not counting repeated placements.
  std::size_t primitiveCount() const;

 private:
  struct Model {
    std::vector<Primitive> primitives;
    Bvh tree;
    Bounds bounds;
    double reach = 0.0;  // largest distance of a part from the z axis
  };
  struct Instance {
    Eigen::Vector3d p_world;
    double cos_yaw;
    double sin_yaw;
    double scale;
    uint32_t model;
  };
  struct Nearest {
    double t;
    uint32_t instance;
    uint32_t primitive;
  };

  static constexpr uint32_t kGround = 0xffffffff;

  static Ray toModel(const Instance& instance, const Ray& ray_world);
  static void test(const Primitive& primitive, const Ray& ray, uint32_t instance, uint32_t index,
                   Nearest* nearest);
  Bounds boundsOfInstance(const Instance& instance) const;
  Nearest nearestGround(const Ray& ray, double t_limit, bool with_ground) const;
  Hit describe(const Ray& ray, const Nearest& nearest) const;

  HeightField ground_;
  std::vector<Model> models_;
  std::vector<Instance> instances_;
  Bvh tree_;
};

}  // namespace ladar_perception::sim
