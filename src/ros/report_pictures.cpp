// SPDX-License-Identifier: BSD-3-Clause
#include "report_pictures.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>

#include "package_path.h"

namespace ladar_perception {
namespace {

namespace fs = std::filesystem;

/// Installed it lies beside the programs, in a source tree among the scripts.
std::string findScript(const std::string& script) {
  std::error_code ignored;
  const fs::path beside = fs::read_symlink("/proc/self/exe", ignored).parent_path() / script;
  if (fs::exists(beside)) return beside.string();
  return resolvePackagePath("package://ladar_perception/scripts/" + script);
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

std::string drawPictures(const std::string& script, const std::string& folder) {
  // The script says on standard error what it lacks.
  constexpr int kNoMatplotlib = 3;
  const int status = run(findScript(script), folder);
  if (status == 0) return "";
  if (status == kNoMatplotlib) {
    return "matplotlib is missing (apt-get install python3-matplotlib)";
  }
  return script + " failed (status " + std::to_string(status) + ")";
}

}  // namespace ladar_perception
