// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/scan_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>

#include "ladar_perception/io/kitti_reader.h"
#include "ladar_perception/io/pcl_reader.h"
#include "ladar_perception/io/text_reader.h"

namespace ladar_perception {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string>& extensionsOf(ScanFormat format) {
  static const std::vector<std::vector<std::string>> kExtensions = {
      {".xyz_label_conf"},      {".bin"}, {".pcd"}, {".ply"},
      {".xyz", ".csv", ".txt"}, {".vtk"}, {".3d"}};
  return kExtensions[static_cast<std::size_t>(format)];
}

bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// The run of digits at `at` without its leading zeros; moves `at` behind it.
std::string takeNumber(const std::string& text, std::size_t& at) {
  const std::size_t begin = at;
  while (at < text.size() && isDigit(text[at])) ++at;
  const std::string digits = text.substr(begin, at - begin);
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
}

bool naturallyBefore(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (isDigit(a[i]) && isDigit(b[j])) {
      const std::string m = takeNumber(a, i);
      const std::string n = takeNumber(b, j);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // scan1 and scan01
}

std::vector<std::string> namesIn(const fs::path& folder, const std::string& extension) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool matches = entry.path().extension() == extension && entry.is_regular_file();
    if (matches) names.push_back(entry.path().filename().string());
  }
  return names;
}

std::vector<std::string> filesIn(const fs::path& folder, ScanFormat format) {
  const std::vector<std::string>& extensions = extensionsOf(format);
  std::vector<std::string> names;
  // Only the first extension that is there: a README.txt beside *.xyz is no scan.
  for (auto it = extensions.begin(); it != extensions.end() && names.empty(); ++it) {
    names = namesIn(folder, *it);
  }
  if (names.empty()) {
    std::string expected;
    for (const std::string& extension : extensions) expected += " *" + extension;
    throw std::runtime_error(folder.string() + ": has no scans, expected" + expected);
  }
  std::sort(names.begin(), names.end(), naturallyBefore);
  for (std::string& name : names) name = (folder / name).string();
  return names;
}

}  // namespace

const std::vector<std::string>& scanFormatNames() {
  static const std::vector<std::string> kNames = {"oakland", "kitti", "pcd", "ply",
                                                  "xyz",     "vtk",   "3dtk"};
  return kNames;
}

ScanFormat scanFormatFromName(const std::string& name) {
  const std::vector<std::string>& names = scanFormatNames();
  const auto it = std::find(names.begin(), names.end(), name);
  if (it != names.end()) return static_cast<ScanFormat>(it - names.begin());
  std::string expected;
  for (const std::string& known : names) expected += " " + known;
  throw std::runtime_error("unknown format '" + name + "', expected one of" + expected);
}

ScanFormat scanFormatFromPath(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  std::string expected;
  for (std::size_t i = 0; i < scanFormatNames().size(); ++i) {
    const auto format = static_cast<ScanFormat>(i);
    for (const std::string& known : extensionsOf(format)) {
      if (extension == known) return format;
      expected += " " + known;
    }
  }
  throw std::runtime_error(path + ": extension '" + extension +
                           "' names no format, expected one of" + expected);
}

Scan readScan(const std::string& path, ScanFormat format, const std::vector<std::string>& columns) {
  switch (format) {
    case ScanFormat::kOakland:
      return readOaklandScan(path);
    case ScanFormat::kKitti:
      return readKittiScan(path);
    case ScanFormat::kPcd:
      return readPcdScan(path);
    case ScanFormat::kPly:
      return readPlyScan(path);
    case ScanFormat::kXyz:
      return readTextScan(path, columns);
    case ScanFormat::kVtk:
      return readVtkScan(path);
    case ScanFormat::k3dtk:
      return read3dtkScan(path);
  }
  throw std::runtime_error(path + ": unknown format");
}

std::vector<std::string> listScanFiles(const std::vector<std::string>& inputs, ScanFormat format) {
  std::vector<std::string> files;
  for (const std::string& input : inputs) {
    if (fs::is_directory(input)) {
      const std::vector<std::string> found = filesIn(input, format);
      files.insert(files.end(), found.begin(), found.end());
    } else if (fs::exists(input)) {
      files.push_back(input);
    } else {
      throw std::runtime_error(input + ": no such file or folder");
    }
  }
  return files;
}

}  // namespace ladar_perception
