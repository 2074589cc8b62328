// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace ladar_perception {

/// The folder of a report. Made, and tried for writing, before the work begins.
class ReportFolder {
 public:
  /// Throws std::runtime_error that names the folder if it cannot be made or written to.
  explicit ReportFolder(const std::string& path);

  const std::string& path() const { return path_; }
  /// Writes report.json. Throws std::runtime_error if that fails.
  void writeReport(const std::string& json) const;
  /// Runs plot_classifier_report.py on the folder, once its JSON is there; "", or why there are no
  /// pictures (matplotlib is missing, for one).
  std::string drawPictures() const;

 private:
  std::string path_;
};

/// Throws std::runtime_error that names the file unless it can be written; leaves no trace.
void checkWritable(const std::string& path);

}  // namespace ladar_perception
