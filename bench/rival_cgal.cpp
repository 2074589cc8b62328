// SPDX-License-Identifier: BSD-3-Clause
#include "rival_cgal.h"

#include <CGAL/Classification.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <sstream>

namespace ladar_perception::bench {
namespace {

namespace Classification = CGAL::Classification;
using Kernel = CGAL::Simple_cartesian<double>;
using Points = std::vector<Kernel::Point_3>;
using PointMap = CGAL::Identity_property_map<Kernel::Point_3>;
// Without threads, as ours is measured too.
using Concurrency = CGAL::Sequential_tag;
using FeatureGenerator =
    Classification::Point_set_feature_generator<Kernel, Points, PointMap, Concurrency>;
using Forest = Classification::ETHZ::Random_forest_classifier;

Classification::Label_set makeLabels(std::size_t classes) {
  Classification::Label_set labels;
  for (std::size_t c = 1; c <= classes; ++c) labels.add(std::to_string(c).c_str());
  return labels;
}

/// CGAL's label indices, -1 for points not to be trained on: of every class a random choice of at
/// most that many points.
std::vector<int> trainingLabels(const Labels& truth, std::size_t classes, std::size_t per_class) {
  std::vector<std::vector<std::size_t>> points_of(classes + 1);
  for (std::size_t i = 0; i < truth.size(); ++i) points_of[truth[i]].push_back(i);
  std::vector<int> labels(truth.size(), -1);
  std::mt19937_64 random(1);
  for (std::size_t c = 1; c <= classes; ++c) {
    std::vector<std::size_t>& points = points_of[c];
    std::shuffle(points.begin(), points.end(), random);
    if (per_class > 0 && points.size() > per_class) points.resize(per_class);
    for (const std::size_t i : points) labels[i] = static_cast<int>(c) - 1;
  }
  return labels;
}

}  // namespace

const char* cgalRegularizationName(CgalRegularization regularization) {
  switch (regularization) {
    case CgalRegularization::kNone:
      return "none";
    case CgalRegularization::kNeighbours:
      return "mean of 12 neighbours";
    case CgalRegularization::kSphere:
      return "mean over a sphere";
    case CgalRegularization::kGraphCut:
      return "graph cut";
  }
  return "";
}

struct CgalCloud::Impl {
  Points points;
  // Features look into their generator.
  std::unique_ptr<FeatureGenerator> generator;
  std::unique_ptr<Classification::Feature_set> features;
};

CgalCloud::CgalCloud(const std::vector<Eigen::Vector3d>& points_m)
    : impl_(std::make_unique<Impl>()) {
  for (const Eigen::Vector3d& p : points_m) impl_->points.emplace_back(p.x(), p.y(), p.z());
}
CgalCloud::~CgalCloud() = default;
CgalCloud::CgalCloud(CgalCloud&&) noexcept = default;

void CgalCloud::clear() {
  impl_->features.reset();
  impl_->generator.reset();
}

void CgalCloud::computeFeatures(const CgalFeatureSettings& settings) {
  clear();
  impl_->generator = std::make_unique<FeatureGenerator>(impl_->points, PointMap(), settings.scales,
                                                        static_cast<float>(settings.voxel_size_m));
  impl_->features = std::make_unique<Classification::Feature_set>();
  impl_->generator->generate_point_based_features(*impl_->features);
}

std::size_t CgalCloud::features() const { return impl_->features->size(); }
std::size_t CgalCloud::size() const { return impl_->points.size(); }

CgalForest::CgalForest(const CgalCloud& cloud, const Labels& truth, std::size_t classes,
                       const CgalForestSettings& settings)
    : classes_(classes) {
  const Classification::Label_set labels = makeLabels(classes);
  Forest forest(labels, *cloud.impl_->features);
  std::srand(1);  // what the forest draws its samples with
  forest.train<Concurrency>(trainingLabels(truth, classes, settings.samples_per_class), true,
                            settings.trees, settings.depth);
  std::ostringstream stream;
  forest.save_configuration(stream);
  bytes_ = stream.str();
}

struct CgalClassifier::Impl {
  Impl(const CgalCloud::Impl& on_cloud, std::size_t classes)
      : cloud(on_cloud), labels(makeLabels(classes)), forest(labels, *on_cloud.features) {}

  const CgalCloud::Impl& cloud;
  Classification::Label_set labels;  // the forest refers to it
  Forest forest;
};

CgalClassifier::CgalClassifier(const CgalForest& forest, const CgalCloud& cloud)
    : impl_(std::make_unique<Impl>(*cloud.impl_, forest.classes_)) {
  std::istringstream stream(forest.bytes_);
  impl_->forest.load_configuration(stream);
}
CgalClassifier::~CgalClassifier() = default;

Labels CgalClassifier::classify(CgalRegularization regularization) const {
  constexpr unsigned kNeighbours = 12;
  constexpr float kStrength = 0.2F;
  constexpr std::size_t kSubdivisions = 4;
  const Points& points = impl_->cloud.points;
  const FeatureGenerator& generator = *impl_->cloud.generator;
  const auto neighbours = generator.neighborhood().k_neighbor_query(kNeighbours);
  const auto sphere = generator.neighborhood().sphere_neighbor_query(generator.radius_neighbors());
  std::vector<int> indices(points.size(), -1);
  switch (regularization) {
    case CgalRegularization::kNone:
      Classification::classify<Concurrency>(points, impl_->labels, impl_->forest, indices);
      break;
    case CgalRegularization::kNeighbours:
      Classification::classify_with_local_smoothing<Concurrency>(
          points, PointMap(), impl_->labels, impl_->forest, neighbours, indices);
      break;
    case CgalRegularization::kSphere:
      Classification::classify_with_local_smoothing<Concurrency>(points, PointMap(), impl_->labels,
                                                                 impl_->forest, sphere, indices);
      break;
    case CgalRegularization::kGraphCut:
      Classification::classify_with_graphcut<Concurrency>(points, PointMap(), impl_->labels,
                                                          impl_->forest, neighbours, kStrength,
                                                          kSubdivisions, indices);
      break;
  }
  Labels result;
  result.reserve(indices.size());
  for (const int index : indices) result.push_back(static_cast<uint8_t>(index + 1));
  return result;
}

}  // namespace ladar_perception::bench
