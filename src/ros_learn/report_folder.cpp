// SPDX-License-Identifier: BSD-3-Clause
#include "report_folder.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "package_path.h"

namespace ladar_perception {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScript = "plot_classifier_report.py";

/// Installed it lies beside the programs, in a source tree among the scripts.
std::string findScript() {
  std::error_code ignored;
  const fs::path beside = fs::read_symlink("/proc/self/exe", ignored).parent_path() / kScript;
  if (fs::exists(beside)) return beside.string();
  return resolvePackagePath(std::string("package://ladar_perception/scripts/") + kScript);
}

/// Waits for a program with its output where ours is; its exit status, or -1.
int run(const std::string& program, const std::string& argument) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) return -1;
  if (child == 0) {
    execl(program.c_str(), program.c_str(), argument.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

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
  // The script says on standard error what it lacks.
  constexpr int kNoMatplotlib = 3;
  const int status = run(findScript(), path_);
  if (status == 0) return "";
  if (status == kNoMatplotlib) {
    return "matplotlib is missing (apt-get install python3-matplotlib)";
  }
  return std::string(kScript) + " failed (status " + std::to_string(status) + ")";
}

void checkWritable(const std::string& path) {
  const bool existed = fs::exists(path);
  const bool opened = static_cast<bool>(std::ofstream(path, std::ios::app));
  if (!opened) throw std::runtime_error(path + ": cannot be written: " + std::strerror(errno));
  if (!existed) std::remove(path.c_str());
}

}  // namespace ladar_perception
