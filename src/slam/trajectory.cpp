// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/slam/trajectory.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace ladar_perception {
namespace {

// Of the spread along a trajectory: with less across it, its roll about itself is arbitrary.
constexpr double kLeastSpread = 1e-6;

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof(buffer), format, value);
  return buffer;
}

void writeLines(const std::string& path, const std::string& lines) {
  std::ofstream file(path, std::ios::binary);
  file << lines;
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

TrajectoryError errorAfter(const Eigen::Isometry3d& T_truth_map, const Trajectory& poses,
                           const Trajectory& truth) {
  TrajectoryError error;
  double sum = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double distance_m =
        (T_truth_map * poses[i].translation() - truth[i].translation()).norm();
    sum += distance_m * distance_m;
    error.max_m = std::max(error.max_m, distance_m);
  }
  if (!poses.empty()) error.rms_m = std::sqrt(sum / static_cast<double>(poses.size()));
  return error;
}

}  // namespace

void writeTum(const std::string& path, const std::vector<double>& stamps_s,
              const Trajectory& poses) {
  std::string lines;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Quaterniond q(poses[i].linear());
    const Eigen::Vector3d& p = poses[i].translation();
    lines += text("%.9f", stamps_s[i]);
    for (const double value : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}) {
      lines += text(" %.9g", value);
    }
    lines += "\n";
  }
  writeLines(path, lines);
}

void writeKitti(const std::string& path, const Trajectory& poses) {
  std::string lines;
  for (const Eigen::Isometry3d& pose : poses) {
    for (int i = 0; i < 12; ++i) {
      lines += text(i == 0 ? "%.9g" : " %.9g", pose.matrix()(i / 4, i % 4));
    }
    lines += "\n";
  }
  writeLines(path, lines);
}

TrajectoryError errorFromStart(const Trajectory& poses, const Trajectory& truth) {
  if (poses.empty()) return {};
  return errorAfter(truth.front() * poses.front().inverse(Eigen::Isometry), poses, truth);
}

TrajectoryError errorAligned(const Trajectory& poses, const Trajectory& truth) {
  if (poses.size() < 3) return errorFromStart(poses, truth);
  const auto count = static_cast<Eigen::Index>(poses.size());
  Eigen::Matrix3Xd from(3, count);
  Eigen::Matrix3Xd to(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    from.col(i) = poses[static_cast<std::size_t>(i)].translation();
    to.col(i) = truth[static_cast<std::size_t>(i)].translation();
  }
  const Eigen::Vector3d from_mean = from.rowwise().mean();
  const Eigen::Vector3d to_mean = to.rowwise().mean();
  const Eigen::Matrix3d spread =
      (to.colwise() - to_mean) * (from.colwise() - from_mean).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(spread, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()(1) > kLeastSpread * svd.singularValues()(0))) {
    return errorFromStart(poses, truth);
  }
  // The last sign keeps a flat trajectory from being mirrored.
  Eigen::Vector3d signs(1.0, 1.0, 1.0);
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  T.translation() = to_mean - T.linear() * from_mean;
  return errorAfter(T, poses, truth);
}

}  // namespace ladar_perception
