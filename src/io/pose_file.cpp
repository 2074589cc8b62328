// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/pose_file.h"

#include <cmath>
#include <stdexcept>

#include "text_table.h"

namespace ladar_perception {
namespace {

constexpr double kRotationTolerance = 1e-3;

std::vector<double> parseNumbers(const LineReader& lines, std::string_view text) {
  std::vector<std::string_view> cells;
  splitCells(text, cells);
  std::vector<double> numbers;
  for (const std::string_view cell : cells) {
    double value = 0.0;
    if (!parseNumber(cell, value) || !std::isfinite(value)) {
      lines.fail("'" + std::string(cell) + "' is not a finite number");
    }
    numbers.push_back(value);
  }
  return numbers;
}

/// The rotation nearest to `R`, which must nearly be one already.
Eigen::Matrix3d checkedRotation(const LineReader& lines, const Eigen::Matrix3d& R) {
  const double off = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (off > kRotationTolerance || R.determinant() < 0.0) {
    lines.fail("the 3x3 part is not a rotation: R^T R differs from identity by " +
               std::to_string(off) + " (at most 0.001), its determinant is " +
               std::to_string(R.determinant()));
  }
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

Eigen::Isometry3d parseMatrix(const LineReader& lines, const std::vector<double>& numbers) {
  if (numbers.size() != 12 && numbers.size() != 16) {
    lines.fail("found " + std::to_string(numbers.size()) +
               " numbers, expected 12 (row-major 3x4) or 16 (4x4), one pose a line");
  }
  using RowMajor34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor34> matrix(numbers.data());
  if (numbers.size() == 16) {
    const Eigen::Map<const Eigen::RowVector4d> last_row(numbers.data() + 12);
    if ((last_row - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kRotationTolerance) {
      lines.fail("the last row of the 4x4 matrix is not 0 0 0 1");
    }
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = checkedRotation(lines, matrix.leftCols<3>());
  T.translation() = matrix.col(3);
  return T;
}

Eigen::Isometry3d parseTum(const LineReader& lines, const std::vector<double>& numbers) {
  if (numbers.size() != 8) {
    lines.fail("found " + std::to_string(numbers.size()) +
               " numbers, expected 8: stamp x y z qx qy qz qw");
  }
  const Eigen::Quaterniond q(numbers[7], numbers[4], numbers[5], numbers[6]);
  if (std::abs(q.norm() - 1.0) > kRotationTolerance) {
    lines.fail("the quaternion has norm " + std::to_string(q.norm()) + ", expected 1 +- 0.001");
  }
  Eigen::Isometry3d T(q.normalized());
  T.translation() = Eigen::Vector3d(numbers[1], numbers[2], numbers[3]);
  return T;
}

void addStamp(const LineReader& lines, double stamp_s, std::vector<double>& stamps_s) {
  if (!stamps_s.empty() && stamp_s <= stamps_s.back()) {
    lines.fail("stamp " + std::to_string(stamp_s) + " is not after the one before, " +
               std::to_string(stamps_s.back()));
  }
  stamps_s.push_back(stamp_s);
}

}  // namespace

Poses readPoses(const std::string& path, PoseFormat format) {
  LineReader lines(path);
  Poses poses;
  while (lines.next()) {
    const std::string_view text = lines.text();
    const std::vector<double> numbers =
        parseNumbers(lines, trimmed(text.substr(0, text.find('#'))));
    if (numbers.empty()) continue;
    if (format == PoseFormat::kKitti) {
      poses.T_map_lidar.push_back(parseMatrix(lines, numbers));
    } else {
      poses.T_map_lidar.push_back(parseTum(lines, numbers));
      addStamp(lines, numbers[0], poses.stamps_s);
    }
  }
  if (poses.T_map_lidar.empty()) throw std::runtime_error(path + ": has no poses");
  return poses;
}

}  // namespace ladar_perception
