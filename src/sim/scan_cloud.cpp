// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/sim/scan_cloud.h"

#include <cstring>

namespace ladar_perception::sim {
namespace {

/// Writes fields one after the other, where scanLayout() put them.
class PointWriter {
 public:
  PointWriter(uint8_t* point, const CloudLayout& layout) : point_(point), layout_(layout) {}

  void put(uint32_t bits) {
    const Field& field = layout_.fields[next_++];
    const std::size_t size = scalarSize(field.type);
    for (std::size_t i = 0; i < size; ++i) {
      point_[field.offset + i] = static_cast<uint8_t>(bits >> (8 * i));
    }
  }
  void put(float value) {
    uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    put(bits);
  }

 private:
  uint8_t* point_;
  const CloudLayout& layout_;
  std::size_t next_ = 0;
};

}  // namespace

CloudLayout scanLayout(const LadarConfig& config) {
  CloudLayout layout;
  layout.width = static_cast<uint32_t>(config.columns);
  layout.height = static_cast<uint32_t>(config.rows);
  for (const char* name : {"x", "y", "z", "intensity"}) layout.append(name, ScalarType::kFloat32);
  layout.append("ring", ScalarType::kUint16);
  layout.append("time", ScalarType::kFloat32);
  layout.append("truth", ScalarType::kUint8);
  layout.append("rgb", ScalarType::kFloat32);
  layout.append("label", ScalarType::kUint16);
  layout.pack();
  return layout;
}

std::vector<uint8_t> encodeScan(const Scan& scan, const LadarConfig& config) {
  const CloudLayout layout = scanLayout(config);
  std::vector<uint8_t> data(std::size_t{layout.row_step} * layout.height, 0);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Return& beam = scan[i];
    PointWriter writer(data.data() + i * layout.point_step, layout);
    writer.put(beam.p_ladar.x());
    writer.put(beam.p_ladar.y());
    writer.put(beam.p_ladar.z());
    writer.put(beam.intensity);
    writer.put(static_cast<uint32_t>(i / layout.width));
    writer.put(beam.time_s);
    writer.put(static_cast<uint32_t>(beam.truth));
    writer.put(beam.rgb);
    writer.put(static_cast<uint32_t>(beam.label));
  }
  return data;
}

void ScanSummary::add(const Scan& scan) {
  beams += scan.size();
  for (const Return& beam : scan) {
    returned += beam.valid() ? 1 : 0;
    mixed += beam.mixed ? 1 : 0;
    surface += beam.truth == Truth::kSurface ? 1 : 0;
    scatter += beam.truth == Truth::kScatter ? 1 : 0;
    linear += beam.truth == Truth::kLinear ? 1 : 0;
  }
}

}  // namespace ladar_perception::sim
