// SPDX-License-Identifier: BSD-3-Clause
#include "basin_cloud.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>
#include <vector>

#include "ladar_perception/io/scan_file.h"
#include "ladar_perception/register/surface_points.h"
#include "ladar_perception/register/twist.h"

namespace ladar_perception {
namespace {

constexpr double kRotationTolerance = 1e-3;

ScanFormat formatOf(const std::string& path) {
  static const std::map<std::string, ScanFormat> kFormats = {
      {".pcd", ScanFormat::kPcd}, {".ply", ScanFormat::kPly},
      {".xyz", ScanFormat::kXyz}, {".txt", ScanFormat::kXyz},
      {".csv", ScanFormat::kXyz}, {".vtk", ScanFormat::kVtk},
      {".3d", ScanFormat::k3dtk}, {".bin", ScanFormat::kKitti},
      {".asc", ScanFormat::kXyz}, {".xyz_label_conf", ScanFormat::kOakland}};
  const auto found = kFormats.find(std::filesystem::path(path).extension().string());
  if (found == kFormats.end()) {
    throw std::runtime_error(path +
                             ": unknown extension, expected pcd, ply, xyz, txt, csv, asc, vtk, 3d, "
                             "bin or xyz_label_conf");
  }
  return found->second;
}

uint32_t colorBits(double value, ScalarType type) {
  if (type != ScalarType::kFloat32) return static_cast<uint32_t>(value) & 0xffffffU;
  const auto packed = static_cast<float>(value);
  uint32_t bits = 0;
  std::memcpy(&bits, &packed, sizeof(bits));
  return bits & 0xffffffU;
}

/// Fields of the points that are measurements.
PoseCloudData measurementsOf(const Scan& scan, const Eigen::Vector3d& sensor_m) {
  std::vector<Eigen::Vector3d> all(scan.size());
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> values = readColumn(scan, std::string(1, "xyz"[axis]));
    for (std::size_t i = 0; i < all.size(); ++i) all[i][axis] = values[i];
  }
  const Field* color = scan.layout.find("rgb");
  const Field* label = scan.layout.find("label");
  const std::vector<double> colors = color ? readColumn(scan, "rgb") : std::vector<double>();
  const std::vector<double> labels = label ? readColumn(scan, "label") : std::vector<double>();
  PoseCloudData cloud;
  cloud.sensor_m = sensor_m;
  for (const uint32_t i : plausibleReturns(all, sensor_m)) {
    cloud.positions_m.push_back(all[i]);
    if (color) cloud.rgb.push_back(colorBits(colors[i], color->type));
    if (label) cloud.labels.push_back(static_cast<uint8_t>(labels[i]));
  }
  return cloud;
}

}  // namespace

BasinCloud readBasinCloud(const std::string& path, const Eigen::Vector3d& sensor_m) {
  if (!std::filesystem::is_regular_file(path)) {
    throw std::runtime_error(path + ": no such file");
  }
  BasinCloud cloud;
  cloud.points = measurementsOf(readScan(path, formatOf(path)), sensor_m);
  if (cloud.points.positions_m.empty()) {
    throw std::runtime_error(path + ": has no finite point at least " +
                             std::to_string(kNearestReturn_m).substr(0, 3) + " m from the sensor");
  }
  cloud.surface = surfaceCentroids(cloud.points.positions_m, sensor_m);
  return cloud;
}

Eigen::Isometry3d readTransform(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  std::vector<double> values;
  std::string token;
  while (file >> token) {
    std::size_t used = 0;
    double value = NAN;
    try {
      value = std::stod(token, &used);
    } catch (const std::exception&) {
      used = 0;
    }
    if (used != token.size() || !std::isfinite(value)) {
      throw std::runtime_error(path + ": '" + token + "', expected a finite number");
    }
    values.push_back(value);
  }
  if (values.size() != 16 && values.size() != 12) {
    throw std::runtime_error(path + ": " + std::to_string(values.size()) +
                             " numbers, expected 4 rows of 4");
  }
  const Eigen::Matrix<double, 3, 4> rows =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(values.data());
  const Eigen::Matrix3d rotation = rows.leftCols<3>();
  const double off =
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (off > kRotationTolerance || rotation.determinant() < 0.0) {
    throw std::runtime_error(path + ": the upper left 3 x 3 numbers are no rotation (off by " +
                             std::to_string(off) + ")");
  }
  if (values.size() == 16) {
    const Eigen::RowVector4d last(values[12], values[13], values[14], values[15]);
    if ((last - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > kRotationTolerance) {
      throw std::runtime_error(path + ": the last row must be 0 0 0 1");
    }
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = nearestRotation(rotation);
  T.translation() = rows.col(3);
  return T;
}

}  // namespace ladar_perception
