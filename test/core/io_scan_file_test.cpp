// SPDX-License-Identifier: BSD-3-Clause
#include "io_test_files.h"
#include "ladar_perception/io/scan_file.h"

namespace ladar_perception {
namespace {

std::vector<std::string> namesOf(const std::vector<std::string>& files) {
  std::vector<std::string> names;
  for (const std::string& file : files) {
    names.push_back(std::filesystem::path(file).filename().string());
  }
  return names;
}

TEST(IoScanFile, SortsAFolderByTheNumbersInTheNames) {
  for (const char* name : {"scan10.pcd", "scan9.pcd", "scan010b.pcd", "scan1.pcd", "readme.txt",
                           "scan2_5.pcd", "scan2_11.pcd"}) {
    writeFile(name, "");
  }
  EXPECT_EQ(namesOf(listScanFiles({testFolder().string()}, ScanFormat::kPcd)),
            (std::vector<std::string>{"scan1.pcd", "scan2_5.pcd", "scan2_11.pcd", "scan9.pcd",
                                      "scan10.pcd", "scan010b.pcd"}));
}

TEST(IoScanFile, KeepsTheOrderOfFiles) {
  const std::string b = writeFile("b.bin", "");
  const std::string a = writeFile("a.bin", "");
  EXPECT_EQ(listScanFiles({b, a}, ScanFormat::kKitti), (std::vector<std::string>{b, a}));
}

TEST(IoScanFile, TakesTextFilesOfOneExtension) {
  writeFile("a.xyz", "1 2 3\n");
  writeFile("README.txt", "not a scan\n");
  EXPECT_EQ(namesOf(listScanFiles({testFolder().string()}, ScanFormat::kXyz)),
            (std::vector<std::string>{"a.xyz"}));
}

TEST(IoScanFile, NamesTheInputThatIsMissing) {
  expectError([] { listScanFiles({"/nowhere"}, ScanFormat::kPcd); }, {"/nowhere"});
  const std::string folder = testFolder().string();
  expectError([&] { listScanFiles({folder}, ScanFormat::kXyz); },
              {folder, "*.xyz", "*.csv", "*.txt"});
  expectError([] { scanFormatFromName("las"); }, {"'las'", "oakland", "kitti", "3dtk"});
}

TEST(IoScanFile, ReadsByFormat) {
  EXPECT_EQ(scanFormatFromName("3dtk"), ScanFormat::k3dtk);
  EXPECT_EQ(scanFormatFromName("oakland"), ScanFormat::kOakland);
  const std::string path = writeFile("a.xyz", "1 2 3 4\n");
  const Scan scan = readScan(path, ScanFormat::kXyz, {"x", "y", "z", "intensity"});
  EXPECT_NE(scan.layout.find("intensity"), nullptr);
}

}  // namespace
}  // namespace ladar_perception
