// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/labelled_inputs.h"

#include <array>
#include <filesystem>
#include <set>
#include <stdexcept>

namespace ladar_perception {
namespace {

namespace fs = std::filesystem;

struct Kind {
  const char* extension;
  std::optional<ScanFormat> format;
};
// No .txt: a README.txt beside the scans is none.
const std::array<Kind, 9> kKinds = {{{".xyz_label_conf", ScanFormat::kOakland},
                                     {".bin", ScanFormat::kKitti},
                                     {".pcd", ScanFormat::kPcd},
                                     {".ply", ScanFormat::kPly},
                                     {".xyz", ScanFormat::kXyz},
                                     {".csv", ScanFormat::kXyz},
                                     {".vtk", ScanFormat::kVtk},
                                     {".3d", ScanFormat::k3dtk},
                                     {".bag", std::nullopt}}};

const Kind* kindOf(const fs::path& path) {
  for (const Kind& kind : kKinds) {
    if (path.extension() == kind.extension) return &kind;
  }
  return nullptr;
}

std::string knownExtensions() {
  std::string list;
  for (const Kind& kind : kKinds) list += (list.empty() ? "" : " ") + std::string(kind.extension);
  return list;
}

std::vector<std::string> bagsIn(const fs::path& folder) {
  std::set<std::string> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".bag") paths.insert(entry.path().string());
  }
  if (paths.empty()) throw std::runtime_error(folder.string() + ": has no *.bag");
  return {paths.begin(), paths.end()};
}

std::optional<ScanFormat> formatOfFolder(const fs::path& folder) {
  std::set<std::string> extensions;
  std::set<int> formats;
  std::optional<ScanFormat> format;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const Kind* kind = entry.is_regular_file() ? kindOf(entry.path()) : nullptr;
    if (kind == nullptr) continue;
    extensions.insert(kind->extension);
    formats.insert(kind->format ? static_cast<int>(*kind->format) : -1);
    format = kind->format;
  }
  if (formats.empty()) {
    throw std::runtime_error(folder.string() + ": has no files of labelled points, expected " +
                             knownExtensions());
  }
  if (formats.size() > 1) {
    std::string found;
    for (const std::string& extension : extensions) found += " *" + extension;
    throw std::runtime_error(folder.string() + ": has files of several formats (" +
                             found.substr(1) + "), choose one with --format");
  }
  return format;
}

std::optional<ScanFormat> formatOf(const std::string& path) {
  if (!fs::exists(path)) throw std::runtime_error(path + ": no such file or folder");
  if (fs::is_directory(path)) return formatOfFolder(path);
  const Kind* kind = kindOf(path);
  if (kind != nullptr) return kind->format;
  throw std::runtime_error(path + ": its extension does not tell its format, expected one of " +
                           knownExtensions() + ", or --format");
}

}  // namespace

const char* passName(Pass pass) {
  switch (pass) {
    case Pass::kWhole:
      return "whole";
    case Pass::kStream:
      return "stream";
    case Pass::kRecorded:
      return "recorded";
  }
  return "";
}

Pass passFromName(const std::string& name) {
  for (const Pass pass : {Pass::kWhole, Pass::kStream}) {
    if (name == passName(pass)) return pass;
  }
  throw std::runtime_error("unknown pass '" + name + "', expected whole or stream");
}

std::vector<LabelledInput> listLabelledInputs(const std::vector<std::string>& arguments,
                                              const std::string& format_name) {
  std::optional<ScanFormat> given;
  if (!format_name.empty() && format_name != "bag") given = scanFormatFromName(format_name);
  std::vector<LabelledInput> inputs;
  for (const std::string& argument : arguments) {
    if (!fs::exists(argument)) throw std::runtime_error(argument + ": no such file or folder");
    const std::optional<ScanFormat> format = format_name.empty() ? formatOf(argument) : given;
    LabelledInput input{argument, {}};
    std::vector<std::string> paths = {argument};
    if (format) {
      paths = listScanFiles(paths, *format);
    } else if (fs::is_directory(argument)) {
      paths = bagsIn(argument);
    }
    for (const std::string& path : paths) input.files.push_back({path, format});
    inputs.push_back(std::move(input));
  }
  return inputs;
}

std::vector<Pass> passesOf(const LabelledFile& file, const std::vector<Pass>& wanted) {
  if (!file.format) return {Pass::kRecorded};
  if (!wanted.empty()) return wanted;
  if (*file.format == ScanFormat::kOakland) return {Pass::kWhole, Pass::kStream};
  return {Pass::kWhole};
}

}  // namespace ladar_perception
