// SPDX-License-Identifier: BSD-3-Clause
// Files that the tests of the readers write and read.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace ladar_perception {

/// A folder for the running test, empty at first.
inline std::filesystem::path testFolder() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) /
                                       "ladar_perception_io" / info->test_suite_name() /
                                       info->name();
  static std::string last;
  if (last != folder.string()) std::filesystem::remove_all(folder);
  last = folder.string();
  std::filesystem::create_directories(folder);
  return folder;
}

inline std::string writeFile(const std::string& name, const std::string& bytes) {
  const std::filesystem::path path = testFolder() / name;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
  return path.string();
}

/// The bytes of values one after the other.
template <typename T>
std::string bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// What `action` throws as std::runtime_error, "" if it does not throw.
template <typename Action>
std::string errorOf(Action action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// Expects that `action` throws and that the message has all of `parts`.
template <typename Action>
void expectError(Action action, const std::vector<std::string>& parts) {
  const std::string message = errorOf(action);
  EXPECT_NE(message, "") << "nothing was thrown";
  for (const std::string& part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
  }
}

/// Folder of the real data sets, "" if there is none.
inline std::string dataFolder() {
  const char* given = std::getenv("LADAR_DATA");
  const std::string folder = given != nullptr ? given : LADAR_SOURCE_DIR "/../shared/data";
  return std::filesystem::is_directory(folder) ? folder : "";
}

}  // namespace ladar_perception
