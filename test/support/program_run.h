// SPDX-License-Identifier: BSD-3-Clause
// Runs the package's programs as a user does, for the tests of the programs.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace ladar_perception::test {

/// A folder that goes away with everything in it.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "ladar_program_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string path() const { return path_; }
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  std::string write(const std::string& name, const std::string& bytes) const {
    const std::filesystem::path path = file(name);
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << bytes;
    return path.string();
  }
  /// Names of the files in it, sorted, "a b c".
  std::string list() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
    return text;
  }

 private:
  std::string path_;
};

inline std::string fileBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

/// A number that differs when the bytes do. Comparing bags themselves would print megabytes.
inline std::size_t digestOf(const std::string& path) {
  return std::hash<std::string>()(fileBytes(path));
}

inline nlohmann::json readJson(const std::string& path) {
  return nlohmann::json::parse(fileBytes(path));
}

/// The bytes of values one after the other.
template <typename T>
std::string bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// What a program did.
struct ProgramRun {
  int status = -1;  ///< exit status, 128 + the signal if one ended it
  std::string out;
  std::string err;
};

inline std::ostream& operator<<(std::ostream& stream, const ProgramRun& run) {
  return stream << "status " << run.status << "\n" << run.out << run.err;
}

inline std::string shellQuoted(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// package://ladar_perception/... must lead to this source folder where no setup.sh says so.
inline void providePackagePath() {
  const char* given = std::getenv("ROS_PACKAGE_PATH");
  std::istringstream entries(given == nullptr ? "" : given);
  for (std::string entry; std::getline(entries, entry, ':');) {
    if (!entry.empty() && std::string(LADAR_SOURCE_DIR).rfind(entry, 0) == 0) return;
  }
  const std::string rest = given == nullptr ? "" : std::string(":") + given;
  setenv("ROS_PACKAGE_PATH", (LADAR_SOURCE_DIR + rest).c_str(), 1);
}

/// Runs a program of the package with these arguments, through the shell.
inline ProgramRun runProgram(const std::string& name, const std::vector<std::string>& arguments) {
  providePackagePath();
  const ScratchFolder folder;
  std::string command = shellQuoted(std::string(LADAR_PROGRAM_DIR) + "/" + name);
  for (const std::string& argument : arguments) command += " " + shellQuoted(argument);
  command += " >" + shellQuoted(folder.file("out")) + " 2>" + shellQuoted(folder.file("err")) +
             " </dev/null";
  const int status = std::system(command.c_str());
  ProgramRun run;
  run.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  run.out = fileBytes(folder.file("out"));
  run.err = fileBytes(folder.file("err"));
  return run;
}

/// Lines that tell of progress or hint at --help, not of what went wrong.
inline bool isAside(const std::string& line) {
  const auto begins = [&](const char* text) { return line.rfind(text, 0) == 0; };
  const bool counts = line.find_first_of("0123456789") <= (begins("[") ? 1 : 0) &&
                      (begins("[") || line.find(" of ") != std::string::npos);
  return counts || begins("note: ") || begins("Run with --help");
}

/// `run` failed in order, with a message of at most `max_lines` lines that has all of `parts`.
inline void expectFailure(const ProgramRun& run, const std::vector<std::string>& parts,
                          int max_lines = 1) {
  EXPECT_GT(run.status, 0) << run;
  EXPECT_LT(run.status, 127) << run;  // neither not found nor ended by a signal
  std::istringstream lines(run.err);
  int count = 0;
  for (std::string line; std::getline(lines, line);) count += isAside(line) ? 0 : 1;
  EXPECT_GE(count, 1) << run;
  EXPECT_LE(count, max_lines) << run;
  for (const std::string& part : parts) {
    EXPECT_NE(run.err.find(part), std::string::npos) << "'" << part << "' is not in: " << run.err;
  }
}

inline void expectSuccess(const ProgramRun& run) { EXPECT_EQ(run.status, 0) << run; }

/// `--help` names every one of `options` and succeeds.
inline void expectHelp(const std::string& program, const std::vector<std::string>& options) {
  const ProgramRun run = runProgram(program, {"--help"});
  expectSuccess(run);
  for (const std::string& option : options) {
    EXPECT_NE(run.out.find(option), std::string::npos) << option << " is not in: " << run.out;
  }
}

/// A file or folder of the real data sets, "" if it is not there.
inline std::string realData(const std::string& name) {
  const char* given = std::getenv("LADAR_DATA");
  const std::string folder = given != nullptr ? given : LADAR_SOURCE_DIR "/../shared/data";
  const std::string path = folder + "/" + name;
  return std::filesystem::exists(path) ? path : "";
}

}  // namespace ladar_perception::test
