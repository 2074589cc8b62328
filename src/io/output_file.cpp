// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/output_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace ladar_perception {

OutputFile::OutputFile(const std::string& path) : path_(path), partial_(path + ".partial") {
  // Or only the last step would find out.
  if (std::filesystem::is_directory(path)) {
    throw std::runtime_error(path + ": cannot be written: is a folder");
  }
  stream_.open(partial_, std::ios::binary | std::ios::trunc);
  if (!stream_) throw std::runtime_error(path + ": cannot be written: " + std::strerror(errno));
}

OutputFile::~OutputFile() {
  if (stream_.is_open()) {
    stream_.close();
    std::remove(partial_.c_str());
  }
}

void OutputFile::complete() {
  stream_.close();
  if (!stream_ || std::rename(partial_.c_str(), path_.c_str()) != 0) {
    std::remove(partial_.c_str());
    throw std::runtime_error(path_ + ": cannot be written completely");
  }
}

}  // namespace ladar_perception
