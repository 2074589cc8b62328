// SPDX-License-Identifier: BSD-3-Clause
// Labelled clouds as users have them, for the tests of the programs that learn and judge.
#pragma once

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "program_run.h"
#include "test_random.h"

namespace ladar_perception::test {

struct LabelledPoint {
  double x, y, z;
  int label;
};

constexpr int kGroundLabel = 1202;
constexpr int kFoliageLabel = 1300;
constexpr int kPoleLabel = 1103;
constexpr int kWallLabel = 1400;
constexpr int kWireLabel = 1101;

/// Ground of 60 x 12 m with trees, poles, wires and a wall along it, labelled as Oakland's tiles
/// are; every 100th point has a label that no mapping has.
inline std::vector<LabelledPoint> street(uint64_t seed) {
  TestRandom random(seed);
  std::vector<LabelledPoint> points;
  const auto add = [&](double x, double y, double z, int label) {
    points.push_back({x + 100.0, y - 50.0, z + 7.0, points.size() % 100 == 99 ? 9999 : label});
  };
  for (int i = 0; i < 24000; ++i) {
    add(random.real(0, 60), random.real(0, 12), 0.02 * random.normal(), kGroundLabel);
  }
  for (int object = 0; object < 12; ++object) {
    const double x = 5.0 * object + 2.5;
    for (int i = 0; i < 700; ++i) {
      const double angle = random.real(0, 6.28);
      const double radius = 0.9 * std::sqrt(random.real(0, 1));
      add(x + radius * std::cos(angle), 2.0 + radius * std::sin(angle), random.real(1.5, 3.3),
          kFoliageLabel);
    }
    for (int i = 0; i < 250; ++i) {
      add(x + 0.02 * random.normal(), 6.0 + 0.02 * random.normal(), random.real(0.3, 4.5),
          kPoleLabel);
    }
    for (int i = 0; i < 600; ++i) {
      add(x + random.real(-2, 2), 11.0 + 0.02 * random.normal(), random.real(0.3, 3.3), kWallLabel);
    }
  }
  for (int i = 0; i < 3000; ++i) {
    add(random.real(0, 60), 8.0 + 0.02 * random.normal(), 3.8 + 0.02 * random.normal(), kWireLabel);
  }
  return points;
}

/// `x y z label confidence`, a line per point.
inline std::string oaklandText(const std::vector<LabelledPoint>& points) {
  std::ostringstream text;
  text.precision(8);
  for (const LabelledPoint& p : points) {
    text << p.x << " " << p.y << " " << p.z << " " << p.label << " 1\n";
  }
  return text.str();
}

inline std::string csvText(const std::vector<LabelledPoint>& points, const std::string& field) {
  std::ostringstream text;
  text.precision(8);
  text << "x,y,z," << field << "\n";
  for (const LabelledPoint& p : points) {
    text << p.x << "," << p.y << "," << p.z << "," << p.label << "\n";
  }
  return text.str();
}

inline std::string plyText(const std::vector<LabelledPoint>& points) {
  std::ostringstream text;
  text.precision(8);
  text << "ply\nformat ascii 1.0\nelement vertex " << points.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nproperty int label\n"
          "end_header\n";
  for (const LabelledPoint& p : points) {
    text << p.x << " " << p.y << " " << p.z << " " << p.label << "\n";
  }
  return text.str();
}

inline std::string pcdText(const std::vector<LabelledPoint>& points) {
  std::ostringstream text;
  text.precision(8);
  text << "VERSION 0.7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH "
       << points.size() << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << points.size()
       << "\nDATA ascii\n";
  for (const LabelledPoint& p : points) {
    text << p.x << " " << p.y << " " << p.z << " " << p.label << "\n";
  }
  return text.str();
}

/// A SemanticKITTI scan with its labels: 40 road, 70 vegetation, 80 pole, 50 building.
inline void writeKitti(const ScratchFolder& folder, const std::string& stem,
                       const std::vector<LabelledPoint>& points) {
  std::vector<float> scan;
  std::vector<uint32_t> labels;
  for (const LabelledPoint& p : points) {
    for (const double value : {p.x - 130.0, p.y + 44.0, p.z - 8.7, 0.5}) {
      scan.push_back(static_cast<float>(value));
    }
    const uint32_t kind = p.label == kGroundLabel    ? 40
                          : p.label == kFoliageLabel ? 70
                          : p.label == kWallLabel    ? 50
                          : p.label == 9999          ? 0
                                                     : 80;
    labels.push_back(kind | 7U << 16);
  }
  folder.write(stem + ".bin", bytesOf(scan));
  folder.write(stem + ".label", bytesOf(labels));
}

}  // namespace ladar_perception::test
