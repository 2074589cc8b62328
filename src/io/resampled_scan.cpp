// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/resampled_scan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>

#include "ladar_perception/cloud/point_reader.h"

namespace ladar_perception {
namespace {

constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
constexpr std::array<const char*, 4> kAdded = {"normal_x", "normal_y", "normal_z",
                                               "covering_radius"};

bool isWhole(double value, double max) {
  return value >= 0.0 && value <= max && value == std::floor(value);
}

[[noreturn]] void failAtPoint(const std::string& field, double value, std::size_t point,
                              const std::string& expected) {
  throw std::runtime_error("field '" + field + "' of point " + std::to_string(point) + " is " +
                           std::to_string(value) + ", expected " + expected);
}

/// The names of three columns of numbers if the scan has them.
std::vector<std::string> partsOfColor(const CloudLayout& layout) {
  for (const std::vector<std::string>& names : {std::vector<std::string>{"red", "green", "blue"},
                                                std::vector<std::string>{"r", "g", "b"}}) {
    const bool all = std::all_of(names.begin(), names.end(), [&](const std::string& name) {
      return layout.find(name) != nullptr;
    });
    if (all) return names;
  }
  return {};
}

double asFloatBits(uint32_t rgb) {
  float value = 0.0F;
  std::memcpy(&value, &rgb, sizeof value);
  return value;
}

Column colorFromParts(const Scan& scan, const std::vector<std::string>& names) {
  Column rgb{"rgb", ScalarType::kFloat32, std::vector<double>(scan.size())};
  std::vector<uint32_t> packed(scan.size(), 0);
  for (const std::string& name : names) {
    const std::vector<double> part = readColumn(scan, name);
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (!isWhole(part[i], 255.0)) failAtPoint(name, part[i], i, "a whole number from 0 to 255");
      packed[i] = packed[i] << 8 | static_cast<uint32_t>(part[i]);
    }
  }
  std::transform(packed.begin(), packed.end(), rgb.values.begin(), asFloatBits);
  return rgb;
}

/// The same scan with a column in the place of others; only for scans of single scalars.
Scan withColumn(const Scan& scan, const std::vector<std::string>& without, const Column& column) {
  std::vector<Column> columns;
  for (const Field& field : scan.layout.fields) {
    if (std::find(without.begin(), without.end(), field.name) != without.end()) continue;
    columns.push_back({field.name, field.type, readColumn(scan, field.name)});
  }
  columns.push_back(column);
  return makeScan(columns);
}

/// Whether a field rgb holds the number itself: as bits in a float, colours are tiny.
bool isNumericColor(const Scan& scan, const Field& rgb) {
  if (rgb.type != ScalarType::kFloat32 && rgb.type != ScalarType::kFloat64) return false;
  const std::vector<double> values = readColumn(scan, rgb.name);
  const bool whole = std::all_of(values.begin(), values.end(),
                                 [](double value) { return isWhole(value, 16777215.0); });
  return whole && std::any_of(values.begin(), values.end(), [](double v) { return v > 0.0; });
}

std::vector<uint8_t> labelsBy(const Scan& scan, const std::string& field, double max,
                              const std::string& expected,
                              const std::function<uint8_t(uint32_t)>& toLabel) {
  const std::vector<double> values = readColumn(scan, field);
  std::vector<uint8_t> labels(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!isWhole(values[i], max)) failAtPoint(field, values[i], i, expected);
    labels[i] = toLabel(static_cast<uint32_t>(values[i]));
  }
  return labels;
}

/// Layout of the samples, and for each field of the original where its bytes go.
CloudLayout layoutOf(const CloudLayout& original, std::size_t samples,
                     std::vector<uint32_t>* offsets) {
  CloudLayout layout;
  layout.width = static_cast<uint32_t>(samples);
  layout.big_endian = original.big_endian;
  for (const Field& field : original.fields) {
    const bool is_axis = std::find(kAxes.begin(), kAxes.end(), field.name) != kAxes.end();
    const bool is_added = std::find(kAdded.begin(), kAdded.end(), field.name) != kAdded.end();
    std::string name = field.name;
    while (is_added && (name == field.name || original.find(name) != nullptr)) name += "_input";
    const bool is_double = field.type == ScalarType::kFloat64;
    const ScalarType axis_type = is_double ? ScalarType::kFloat64 : ScalarType::kFloat32;
    Field& copy = layout.append(name, is_axis ? axis_type : field.type);
    copy.count = std::max(field.count, 1U);
    layout.point_step +=
        static_cast<uint32_t>(scalarSize(copy.type)) * (copy.count - 1);  // append() counts one
    offsets->push_back(copy.offset);
  }
  for (const char* name : kAdded) layout.append(name, ScalarType::kFloat32);
  layout.pack();
  return layout;
}

void store(double value, const Field& field, uint8_t* point) {
  if (field.type == ScalarType::kFloat64) {
    std::memcpy(point + field.offset, &value, sizeof value);
    return;
  }
  const auto single = static_cast<float>(value);
  std::memcpy(point + field.offset, &single, sizeof single);
}

}  // namespace

void packColors(Scan* scan) {
  const Field* rgb = scan->layout.find("rgb");
  if (rgb == nullptr) {
    const std::vector<std::string> parts = partsOfColor(scan->layout);
    if (!parts.empty()) *scan = withColumn(*scan, parts, colorFromParts(*scan, parts));
    return;
  }
  if (!isNumericColor(*scan, *rgb)) return;
  Column column{"rgb", ScalarType::kFloat32, readColumn(*scan, "rgb")};
  for (double& value : column.values) value = asFloatBits(static_cast<uint32_t>(value));
  *scan = withColumn(*scan, {"rgb"}, column);
}

PoseCloudData poseCloudOf(const Scan& scan) {
  const CloudView view{scan.layout, scan.data.data(), scan.data.size()};
  std::string error;
  const std::optional<PointFields> fields = findPointFields(view, &error);
  if (!fields) throw std::runtime_error(error);
  PoseCloudData cloud;
  readPositions(view, *fields, &cloud.positions_m);
  if (fields->color) readColors(view, *fields->color, &cloud.rgb);
  return cloud;
}

std::vector<uint8_t> labelsOf(const Scan& scan, const std::string& label_field,
                              const ClassMapping& mapping) {
  return labelsBy(scan, label_field, std::numeric_limits<uint32_t>::max(), "a whole number",
                  [&](uint32_t label) { return mapping.truth(label); });
}

std::vector<uint8_t> labelsOf(const Scan& scan, const std::string& label_field, int classes) {
  return labelsBy(scan, label_field, classes, "a label from 0 to " + std::to_string(classes),
                  [](uint32_t label) { return static_cast<uint8_t>(label); });
}

Scan resampledScan(const Scan& original, const ResampledCloud& samples) {
  Scan scan;
  std::vector<uint32_t> offsets;
  scan.layout = layoutOf(original.layout, samples.size(), &offsets);
  scan.data.resize(scan.layout.pointCount() * scan.layout.point_step, 0);
  const CloudView from{original.layout, original.data.data(), original.data.size()};
  const std::size_t width = original.layout.width;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const uint8_t* in = from.point(samples.sources[i] / width, samples.sources[i] % width);
    uint8_t* out = scan.data.data() + i * scan.layout.point_step;
    for (std::size_t k = 0; k < offsets.size(); ++k) {
      const Field& field = original.layout.fields[k];
      // Axes that change their type are overwritten below.
      const std::size_t bytes =
          std::min(scalarSize(field.type), scalarSize(scan.layout.fields[k].type)) *
          std::max(field.count, 1U);
      std::memcpy(out + offsets[k], in + field.offset, bytes);
    }
    for (int axis = 0; axis < 3; ++axis) {
      store(samples.positions_m[i][axis], *scan.layout.find(kAxes[axis]), out);
      store(samples.normals[i][axis], *scan.layout.find(kAdded[axis]), out);
    }
    store(samples.covering_radii[i], *scan.layout.find(kAdded[3]), out);
  }
  updateIsDense(scan);
  return scan;
}

}  // namespace ladar_perception
