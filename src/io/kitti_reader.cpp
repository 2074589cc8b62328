// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/kitti_reader.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>

namespace ladar_perception {
namespace {

std::vector<uint8_t> readRecords(const std::string& path, std::size_t record_bytes,
                                 const std::string& record) {
  std::ifstream stream(path, std::ios::binary);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!stream || error) throw std::runtime_error(path + ": cannot be opened for reading");
  if (size % record_bytes != 0) {
    throw std::runtime_error(path + ": has " + std::to_string(size) +
                             " bytes, expected a multiple of " + std::to_string(record_bytes) +
                             " (" + record + ")");
  }
  std::vector<uint8_t> bytes(size);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
    throw std::runtime_error(path + ": ended while reading its " + std::to_string(size) + " bytes");
  }
  return bytes;
}

void addLabels(Scan& scan, const std::string& path) {
  const std::vector<uint8_t> bytes = readRecords(path, sizeof(uint32_t), "one uint32 a point");
  const std::size_t count = bytes.size() / sizeof(uint32_t);
  if (count != scan.size()) {
    throw std::runtime_error(path + ": has " + std::to_string(count) + " labels, expected " +
                             std::to_string(scan.size()) + ", one for each point of its scan");
  }
  Column label{"label", ScalarType::kUint16, std::vector<double>(count)};
  Column instance{"instance", ScalarType::kUint16, std::vector<double>(count)};
  for (std::size_t i = 0; i < count; ++i) {
    uint32_t both = 0;
    std::memcpy(&both, bytes.data() + i * sizeof both, sizeof both);
    label.values[i] = both & 0xFFFFu;
    instance.values[i] = both >> 16;
  }
  addColumn(scan, label);
  addColumn(scan, instance);
}

}  // namespace

std::string findKittiLabels(const std::string& scan_path) {
  namespace fs = std::filesystem;
  const fs::path scan(scan_path);
  const fs::path name = scan.stem().string() + ".label";
  for (const fs::path& folder :
       {scan.parent_path(), fs::absolute(scan).parent_path().parent_path() / "labels"}) {
    if (fs::is_regular_file(folder / name)) return (folder / name).string();
  }
  return "";
}

Scan readKittiScan(const std::string& path) {
  Scan scan;
  for (const char* name : {"x", "y", "z", "intensity"}) {
    scan.layout.append(name, ScalarType::kFloat32);
  }
  scan.data = readRecords(path, scan.layout.point_step, "float32 x y z intensity");
  scan.layout.width = static_cast<uint32_t>(scan.data.size() / scan.layout.point_step);
  scan.layout.pack();
  updateIsDense(scan);
  const std::string labels = findKittiLabels(path);
  if (!labels.empty()) addLabels(scan, labels);
  return scan;
}

}  // namespace ladar_perception
