// SPDX-License-Identifier: BSD-3-Clause
// PCL's headers stay in this file.
#include "pcl_registrars.h"

#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>
#include <pcl/search/kdtree.h>

#include <cmath>
#include <functional>
#include <vector>

#include "ladar_perception/register/twist.h"

namespace ladar_perception {
namespace {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;
using PclRegistration = pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>;
using Maker = std::function<std::shared_ptr<PclRegistration>()>;

constexpr int kIterations = 50;
constexpr double kEpsilon = 1e-6;
/// As of a registration that has ended well: what is farther has no partner.
constexpr float kPartner_m = 0.3F;

PclCloud::Ptr toPcl(const RegistrationCloud& cloud) {
  auto out = std::make_shared<PclCloud>();
  for (const Eigen::Vector3f& p : cloud.positions()) out->emplace_back(p.x(), p.y(), p.z());
  return out;
}

void measureFit(const RegistrationCloud& a, const PclCloud& laid_on, const PclCloud::Ptr& target,
                RegistrationResult* result) {
  pcl::search::KdTree<pcl::PointXYZ> tree;
  tree.setInputCloud(target);
  std::vector<int> found(1);
  std::vector<float> squared(1);
  double sum = 0.0;
  std::size_t pairs = 0;
  const double limit_m = std::max(static_cast<double>(kPartner_m), 1.2 * a.spacing_m());
  for (const pcl::PointXYZ& p : laid_on) {
    if (tree.nearestKSearch(p, 1, found, squared) == 0) continue;
    if (std::sqrt(squared[0]) > limit_m) continue;
    const auto j = static_cast<std::size_t>(found[0]);
    const float distance = a.normals()[j].dot(Eigen::Vector3f(p.x, p.y, p.z) - a.positions()[j]);
    sum += static_cast<double>(distance) * static_cast<double>(distance);
    ++pairs;
  }
  if (pairs == 0) return;
  result->overlap = static_cast<double>(pairs) / static_cast<double>(laid_on.size());
  result->residual_m = std::sqrt(sum / static_cast<double>(pairs));
}

class PclRegistrar : public Registrar {
 public:
  explicit PclRegistrar(Maker make) : make_(std::move(make)) {}

  RegistrationResult align(const RegistrationCloud& a, const RegistrationCloud& b,
                           const Eigen::Isometry3d& T_a_b_guess) const override {
    RegistrationResult result;
    constexpr std::size_t kLeast = 20;  // GICP wants 20 neighbours
    if (a.size() < kLeast || b.size() < kLeast) {
      result.reason = "too few points";
      return result;
    }
    const PclCloud::Ptr target = toPcl(a);
    Eigen::Isometry3d local = T_a_b_guess;
    local.translation() = T_a_b_guess * b.origin_m() - a.origin_m();
    const std::shared_ptr<PclRegistration> registration = make_();
    registration->setInputSource(toPcl(b));
    registration->setInputTarget(target);
    PclCloud laid_on;
    registration->align(laid_on, local.matrix().cast<float>());
    local.matrix() = registration->getFinalTransformation().cast<double>();
    local.linear() = nearestRotation(local.linear());
    result.T_a_b = Eigen::Translation3d(a.origin_m()) * local * Eigen::Translation3d(-b.origin_m());
    measureFit(a, laid_on, target, &result);
    if (registration->hasConverged()) {
      result.verdict = Verdict::kConverged;
    } else {
      result.reason = "PCL says so";
    }
    return result;
  }

 private:
  Maker make_;
};

template <typename Method>
std::shared_ptr<Method> configured(double max_distance_m) {
  auto method = std::make_shared<Method>();
  method->setMaximumIterations(kIterations);
  method->setTransformationEpsilon(kEpsilon);
  method->setMaxCorrespondenceDistance(max_distance_m);
  return method;
}

}  // namespace

std::unique_ptr<Registrar> makePclRegistrar(const std::string& name, double max_distance_m) {
  using Icp = pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>;
  using Gicp = pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>;
  using Ndt = pcl::NormalDistributionsTransform<pcl::PointXYZ, pcl::PointXYZ>;
  if (name == "pcl_icp") {
    return std::make_unique<PclRegistrar>([=] { return configured<Icp>(max_distance_m); });
  }
  if (name == "pcl_gicp") {
    return std::make_unique<PclRegistrar>([=] { return configured<Gicp>(max_distance_m); });
  }
  if (name == "pcl_ndt") {
    return std::make_unique<PclRegistrar>([=] {
      auto ndt = configured<Ndt>(max_distance_m);
      ndt->setResolution(1.0F);
      return ndt;
    });
  }
  return nullptr;
}

}  // namespace ladar_perception
