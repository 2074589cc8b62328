// SPDX-License-Identifier: BSD-3-Clause
// A file that appears under its name only when it is complete.
#pragma once

#include <fstream>
#include <string>

namespace ladar_perception {

/// Opened at once, as `<path>.partial`, so that what cannot be written is found before the work.
/// Unless complete() was called, nothing is left behind and an older file stays as it is.
class OutputFile {
 public:
  /// Throws std::runtime_error that names the file and the reason.
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  const std::string& path() const { return path_; }
  std::ostream& stream() { return stream_; }
  /// Gives the file its name. Throws std::runtime_error if not all of it could be written.
  void complete();

 private:
  std::string path_;
  std::string partial_;
  std::ofstream stream_;
};

}  // namespace ladar_perception
