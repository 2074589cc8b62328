// SPDX-License-Identifier: BSD-3-Clause
// A world to look at: ground, and models placed on it many times.
#pragma once

#include <cstdint>
#include <vector>

#include "ladar_perception/sim/bvh.h"
#include "ladar_perception/sim/height_field.h"
#include "ladar_perception/sim/primitive.h"
#include "ladar_perception/sim/surface_point.h"

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

  /// The first surface a ray meets at t <= `t_limit`, as castRay() finds it; invalid if none. The
  /// direction must have unit length. `hit`, if given, receives what castRay() would return.
  SurfacePoint castRayToSurface(const Ray& ray, double t_limit, Hit* hit = nullptr) const;
  /// The surface nearest to `p_world`, if it is nearer than `limit_m`. Surfaces hidden inside
  /// others count as well.
  SurfacePoint nearestSurface(const Eigen::Vector3d& p_world, double limit_m = kMiss) const;
  /// Every side of every placed box, in the order of their ids.
  std::vector<PlanarFace> planarFaces() const;

  /// Horizontal reach of a model's parts that begin below `height_m`, from its origin.
  double reachBelow(uint32_t model, double height_m) const;
  std::size_t placementCount() const { return instances_.size(); }
  /// Shapes stored, not counting repeated placements.
  std::size_t primitiveCount() const;

 private:
  struct Model {
    std::vector<Primitive> primitives;
    std::vector<uint32_t> boxes_before;  // of each primitive: boxes ahead of it in the model
    uint32_t boxes = 0;
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
    uint32_t first_face;  // id of the first side of its first box
  };
  struct Nearest {
    double t;
    uint32_t instance;
    uint32_t primitive;
  };

  static constexpr uint32_t kGround = 0xffffffff;

  static Ray toModel(const Instance& instance, const Ray& ray_world);
  static Eigen::Vector3d turned(const Instance& instance, const Eigen::Vector3d& v_model);
  static Eigen::Vector3d toWorld(const Instance& instance, const Eigen::Vector3d& p_model);
  static void test(const Primitive& primitive, const Ray& ray, uint32_t instance, uint32_t index,
                   Nearest* nearest);
  Bounds boundsOfInstance(const Instance& instance) const;
  Nearest nearestGround(const Ray& ray, double t_limit, bool with_ground) const;
  Nearest nearestHit(const Ray& ray, double t_limit, bool with_ground) const;
  /// Normal, face and material of a point in the surface of a primitive.
  void describeSurface(const Instance& instance, uint32_t primitive,
                       const Eigen::Vector3d& seen_from_world, SurfacePoint* point) const;
  Hit describe(const Ray& ray, const Nearest& nearest) const;

  HeightField ground_;
  std::vector<Model> models_;
  std::vector<Instance> instances_;
  uint32_t next_face_ = 1;
  Bvh tree_;
};

}  // namespace ladar_perception::sim
