// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <sstream>

#include "io_test_files.h"
#include "ladar_perception/io/output_file.h"

namespace ladar_perception {
namespace {

std::string readFile(const std::string& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

std::size_t filesIn(const std::filesystem::path& folder) {
  const std::filesystem::directory_iterator begin(folder);
  return static_cast<std::size_t>(std::distance(begin, std::filesystem::directory_iterator()));
}

TEST(IoOutputFile, ReplacesAnOlderFileOnlyWhenComplete) {
  const std::string path = writeFile("a.txt", "old");
  auto file = std::make_unique<OutputFile>(path);
  file->stream() << "new";
  EXPECT_EQ(readFile(path), "old");
  file->complete();
  EXPECT_EQ(readFile(path), "new");
  file.reset();
  EXPECT_EQ(readFile(path), "new");
  EXPECT_EQ(filesIn(testFolder()), 1u);
}

TEST(IoOutputFile, LeavesNothingBehindWhatIsNotComplete) {
  const std::string path = (testFolder() / "a.txt").string();
  { OutputFile(path).stream() << "half"; }
  EXPECT_EQ(filesIn(testFolder()), 0u);
}

TEST(IoOutputFile, SaysAtOnceThatAFileCannotBeWritten) {
  const std::string folder = testFolder().string();
  expectError([&] { OutputFile file(folder + "/none/a.txt"); }, {"/none/a.txt", "No such file"});
  expectError([&] { OutputFile file(folder); }, {folder, "folder"});
}

TEST(IoOutputFile, SaysThatNotAllCouldBeWritten) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const std::string path = (testFolder() / "a.txt").string();
  std::filesystem::create_symlink("/dev/full", path + ".partial");
  OutputFile file(path);
  file.stream() << "text";
  expectError([&] { file.complete(); }, {path, "completely"});
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace ladar_perception
