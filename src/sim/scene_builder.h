// SPDX-License-Identifier: BSD-3-Clause
// What the scenes share: rolling ground, room for the track, things put down at random.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "ladar_perception/sim/random.h"
#include "ladar_perception/sim/world.h"

namespace ladar_perception::sim {

/// One layer of bumps.
struct Bumps {
  double height_m;
  double length_m;
  double on_track;  ///< share left under the wheels
};

struct GroundStyle {
  std::vector<Bumps> layers;
  /// From the distance to the track and a slow noise in -1..1.
  std::function<Material(double track_m, double noise)> material;
  /// Height added to the layers, in the coordinates of the track; may be empty.
  std::function<double(const TrackPlace& place)> profile = nullptr;
};

/// How models are scattered over the world.
struct Scattering {
  std::vector<uint32_t> models;
  int count = 0;
  double min_scale = 0.8;
  double max_scale = 1.25;
  double spacing_m = 0.0;    ///< radius kept free around each; 0 keeps nothing
  double min_track_m = 0.0;  ///< at least this far from the track
  double max_track_m = 52.0;
  double patch_length_m = 0.0;  ///< grows in patches of this size; 0 grows everywhere
};

class SceneBuilder {
 public:
  SceneBuilder(const CircuitShape& shape, const GroundStyle& style, uint64_t seed);

  Random& random() { return random_; }
  const Circuit& circuit() const { return circuit_; }
  double ground(double x_m, double y_m) const { return scene_.ground().height(x_m, y_m); }
  /// Point on the ground, raised by `above_m`.
  Eigen::Vector3d at(const Eigen::Vector2d& p_world, double above_m = 0.0) const;

  uint32_t addModel(std::vector<Primitive> primitives) {
    return scene_.addModel(std::move(primitives));
  }
  void place(uint32_t model, const Eigen::Vector2d& p_world, double yaw_rad, double scale = 1.0);
  /// Where the ground is steep, parts that are high above a foot are low above the track.
  void keepClear(double height_m) { clear_height_m_ = height_m; }
  /// Places models where nothing is claimed and the track stays clear.
  void scatter(const Scattering& scattering);
  /// Shapes in world coordinates, for things that follow the ground: fences, wires, kerbs.
  std::vector<Primitive>& fixed() { return fixed_; }
  /// A capsule chain that sags like a wire between two points.
  void hangWire(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double sag_m,
                double radius_m, Material material = Material::kWire);

  bool isFree(const Eigen::Vector2d& p_world, double radius_m) const;
  void claim(const Eigen::Vector2d& p_world, double radius_m);
  World finish();

 private:
  struct Claim {
    Eigen::Vector2d p_world;
    double radius_m;
  };

  uint64_t seed_;
  Random random_;
  Circuit circuit_;
  double half_size_m_;
  double clear_height_m_ = kClearHeightM;
  Scene scene_;
  std::vector<Primitive> fixed_;
  std::vector<Claim> claims_;
};

/// Adds `count` models made one after the other by `make(Random*)`.
template <typename Make>
std::vector<uint32_t> addVariants(int count, SceneBuilder* builder, Make&& make) {
  std::vector<uint32_t> models;
  for (int i = 0; i < count; ++i) models.push_back(builder->addModel(make(&builder->random())));
  return models;
}

World makeFlatGround(uint64_t seed);
World makeForest(uint64_t seed);
World makeTallGrass(uint64_t seed);
World makeCampus(uint64_t seed);
World makeStreet(uint64_t seed);
World makeScrubland(uint64_t seed);

}  // namespace ladar_perception::sim
