// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "hand_model.h"
#include "io_test_files.h"
#include "ladar_perception/learn/picture_samples.h"
#include "terrain_scenes.h"

namespace ladar_perception {
namespace {

std::string bytesAt(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

/// Sends the mixed scene through; ground is class 1, the wire 3, leaves have no truth.
void see(PictureSamples* pictures, int seed) {
  TerrainPipeline pipeline({}, test::handModel());
  pipeline.keepFeatures(true);
  const test::MixedScene scene(seed);
  test::processAt(&pipeline, scene.points, Eigen::Vector3d::Zero());
  std::vector<double> truth(scene.points.size(), 1.0);
  std::fill(truth.begin() + 20000, truth.begin() + 21000, 3.0);
  std::fill(truth.begin() + 21000, truth.end(), 0.0);
  pictures->add(pipeline, truth);
}

TEST(LearnPictureSamples, WritesWhatWasSeen) {
  PictureSamples pictures(test::handModel(), 1);
  pictures.beginCloud("first");
  see(&pictures, 1);
  pictures.write(testFolder().string());
  const auto data = nlohmann::json::parse(bytesAt(testFolder() / "picture_data.json"));
  EXPECT_EQ(data["features"][2], "cbrt_linear");
  ASSERT_EQ(data["mixtures"].size(), 3u);
  EXPECT_NEAR(data["mixtures"][0][0]["mean"][1].get<double>(), 0.51, 1e-12);
  ASSERT_EQ(data["samples"].size(), 3u);
  EXPECT_EQ(data["samples"][0]["values"].size(), PictureSamples::kFeaturesPerClass);
  EXPECT_EQ(data["samples"][0]["values"][0].size(), 3u);
  EXPECT_EQ(data["samples"][1]["values"].size(), 0u);
  EXPECT_EQ(data["samples"][2]["values"].size(), 1000u);
  EXPECT_EQ(data["samples"][2]["labels"].size(), 1000u);
  ASSERT_EQ(data["clouds"].size(), 1u);
  EXPECT_EQ(data["clouds"][0]["name"], "first");

  const std::string npy = bytesAt(testFolder() / data["clouds"][0]["file"].get<std::string>());
  EXPECT_EQ(npy.substr(0, 6), "\x93NUMPY");
  const std::size_t header = 10 + static_cast<uint8_t>(npy[8]) + 256 * static_cast<uint8_t>(npy[9]);
  EXPECT_EQ(header % 64, 0u);
  std::vector<float> values((npy.size() - header) / sizeof(float));
  std::memcpy(values.data(), npy.data() + header, npy.size() - header);
  const std::size_t rows = values.size() / 5;
  // Within half a metre of the sensor points are dropped.
  EXPECT_GT(rows, 20800u);
  EXPECT_LE(rows, 21000u);
  EXPECT_NE(npy.find("(" + std::to_string(rows) + ", 5)"), std::string::npos);
  for (std::size_t i = 0; i < rows; ++i) {
    const float* row = values.data() + 5 * i;
    if (row[3] == 3.0F) {
      ASSERT_NEAR(row[0], 2.0, 0.06);
      ASSERT_NEAR(row[2], 1.25, 0.06);
    } else {
      ASSERT_EQ(row[3], 1.0F);
      ASSERT_NEAR(row[2], -0.45, 0.06);
    }
    ASSERT_LE(row[4], 3.0F);
  }
}

TEST(LearnPictureSamples, KeepsABoundedPartOfMuch) {
  PictureSamples pictures(test::handModel(), 1);
  pictures.beginCloud("much");
  for (int scan = 0; scan < 8; ++scan) see(&pictures, scan);
  pictures.write(testFolder().string());
  const std::string npy = bytesAt(testFolder() / "cloud_1.npy");
  EXPECT_NE(npy.find("(120000, 5)"), std::string::npos);
}

TEST(LearnPictureSamples, NamesTheFileThatCannotBeWritten) {
  PictureSamples pictures(test::handModel(), 1);
  expectError([&] { pictures.write("/nowhere"); }, {"/nowhere/picture_data.json"});
}

}  // namespace
}  // namespace ladar_perception
