// SPDX-License-Identifier: BSD-3-Clause
#include "report_folder.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "report_pictures.h"

namespace ladar_perception {
namespace fs = std::filesystem;

ReportFolder::ReportFolder(const std::string& path) : path_(path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path)) {
    throw std::runtime_error(path + ": the folder of the report cannot be made" +
                             (error ? ": " + error.message() : ", it is a file"));
  }
  checkWritable(path + "/report.json");
}

void ReportFolder::writeReport(const std::string& json) const {
  const std::string file_path = path_ + "/report.json";
  std::ofstream file(file_path, std::ios::binary);
  file << json;
  if (!file.flush()) throw std::runtime_error(file_path + ": cannot be written");
}

std::string ReportFolder::drawPictures() const {
  return ladar_perception::drawPictures("plot_classifier_report.py", path_);
}

void checkWritable(const std::string& path) {
  const bool existed = fs::exists(path);
  const bool opened = static_cast<bool>(std::ofstream(path, std::ios::app));
  if (!opened) throw std::runtime_error(path + ": cannot be written: " + std::strerror(errno));
  if (!existed) std::remove(path.c_str());
}

}  // namespace ladar_perception
