// SPDX-License-Identifier: BSD-3-Clause
// registration_basin as a user runs it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "program_run.h"
#include "register_scenes.h"

namespace ladar_perception::test {
namespace {

class RegistrationBasin : public testing::Test {
 protected:
  /// Points of the room as text.
  std::string writeCloud(const std::string& name, const Eigen::Isometry3d& T, uint64_t seed) {
    std::string text;
    char line[100];
    for (const Eigen::Vector3d& p : moved(T, pointsOn(roomFaces(), 6000, 0.01, seed)).positions_m) {
      std::snprintf(line, sizeof(line), "%.4f %.4f %.4f\n", p.x(), p.y(), p.z());
      text += line;
    }
    return folder_.write(name, text);
  }

  std::string writeTransform(const std::string& name, const Eigen::Isometry3d& T) {
    std::ostringstream text;
    text.precision(12);
    text << T.matrix() << "\n";
    return folder_.write(name, text.str());
  }

  void SetUp() override {
    // The sensor stands in the room, off the walls and the furniture.
    const Eigen::Isometry3d T_a_place = motion({0.0, 0.0, -1.5}, 0.0);
    a_ = writeCloud("a.xyz", T_a_place, 1);
    b_ = writeCloud("b.xyz", T_a_b_.inverse() * T_a_place, 2);
    truth_ = writeTransform("truth.txt", T_a_b_);
    out_ = folder_.file("out");
  }

  ProgramRun basin(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {a_, b_, "--count", "1000", "--out", out_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return runProgram("registration_basin", arguments);
  }

  nlohmann::json report() const { return readJson(out_ + "/basin.json"); }

  ScratchFolder folder_;
  Eigen::Isometry3d T_a_b_ = motion({0.3, 0.2, 0.05}, 8.0);
  std::string a_;
  std::string b_;
  std::string truth_;
  std::string out_;
};

TEST_F(RegistrationBasin, MeasuresEveryMethod) {
  const std::string methods = "raw,voxel_grid,random,fps,uniform,range";
  const ProgramRun run =
      basin({"--truth", truth_, "--methods", methods, "--starts", "10", "--steps", "3",
             "--max-translation", "1", "--max-rotation", "15", "--initial-radius", "2"});
  expectSuccess(run);
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 6) << run.out;
  const nlohmann::json json = report();
  ASSERT_EQ(json["methods"].size(), 6U);
  for (const auto& [name, one] : json["methods"].items()) {
    EXPECT_EQ(one["starts"], 10) << name;
    EXPECT_GE(one["success"].get<double>(), 0.7) << name;
    EXPECT_LE(one["interval"][0], one["success"]);
    EXPECT_GE(one["interval"][1], one["success"]);
    EXPECT_GT(one["median_ms"].get<double>(), 0.0);
    EXPECT_LT(one["final_error_m"].get<double>(), 0.05) << name;
    EXPECT_EQ(one["random"].size(), 10U);
    EXPECT_EQ(one["curves"]["yaw"]["amount"], (std::vector<double>{-15.0, 0.0, 15.0}));
    EXPECT_NE(run.out.find(name), std::string::npos) << run.out;
  }
  EXPECT_EQ(json["methods"]["raw"]["points"][0], 6000);
  EXPECT_EQ(json["methods"]["random"]["points"][1], 1000);
  EXPECT_EQ(json["comparisons"].size(), 15U);
  EXPECT_GT(std::filesystem::file_size(out_ + "/basin_curves.png"), 10000U);
  EXPECT_GT(std::filesystem::file_size(out_ + "/basin_success.png"), 5000U);
}

TEST_F(RegistrationBasin, GivesTheSameEveryTime) {
  const std::vector<std::string> options = {"--truth",           truth_,     "--methods",
                                            "random,voxel_grid", "--starts", "5",
                                            "--steps",           "0",        "--no-pictures"};
  std::vector<nlohmann::json> runs;
  for (int i = 0; i < 2; ++i) {
    expectSuccess(basin(options));
    nlohmann::json methods = report()["methods"];
    for (auto& [name, one] : methods.items()) {
      for (const char* key : {"median_ms", "sampling_ms", "prepare_ms"}) one.erase(key);
      for (auto& start : one["random"]) start.erase("ms");
    }
    runs.push_back(methods);
  }
  EXPECT_EQ(runs[0], runs[1]);
}

TEST_F(RegistrationBasin, FindsTheTruthItself) {
  const ProgramRun run = basin({"--methods", "random", "--starts", "5", "--steps", "0",
                                "--initial-radius", "1", "--no-pictures"});
  expectSuccess(run);
  EXPECT_EQ(run.out.rfind("truth: registration of all points from the identity, converged", 0), 0U)
      << run.out;
  const nlohmann::json json = report();
  EXPECT_EQ(json["truth_from"], "registration of all points from the identity");
  EXPECT_NEAR(json["T_a_b_truth"][0][3].get<double>(), 0.3, 0.01);
  EXPECT_NEAR(json["T_a_b_truth"][1][3].get<double>(), 0.2, 0.01);
}

TEST_F(RegistrationBasin, RunsEverySolver) {
  for (const char* solver : {"annealed", "plain", "pcl_icp", "pcl_gicp", "pcl_ndt"}) {
    expectSuccess(basin({"--truth", truth_, "--methods", "random", "--starts", "2", "--steps", "0",
                         "--max-translation", "0.1", "--max-rotation", "1", "--initial-radius", "1",
                         "--solver", solver, "--no-pictures"}));
    const nlohmann::json json = report();
    EXPECT_EQ(json["solver"], solver);
    EXPECT_EQ(json["methods"]["random"]["success"], 1.0) << solver;
  }
}

TEST_F(RegistrationBasin, RefusesWhatItCannotUse) {
  expectFailure(basin({"--methods", "random,magic"}),
                {"--methods", "magic", "voxel_grid", "range"});
  expectFailure(basin({"--solver", "magic"}), {"--solver", "magic", "annealed"});
  expectFailure(basin({"--count", "0"}), {"--count"});
  const std::string words = folder_.write("words.txt", "1 0 0 0\n0 one 0 0\n0 0 1 0\n0 0 0 1\n");
  expectFailure(basin({"--truth", words}), {words, "one"});
  const std::string few = folder_.write("few.txt", "1 0 0 0 0 1 0 0\n");
  expectFailure(basin({"--truth", few}), {few, "8 numbers"});
  const std::string scaled = folder_.write("scaled.txt", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1\n");
  expectFailure(basin({"--truth", scaled}), {scaled, "rotation"});
  const std::string nowhere = folder_.file("nowhere.pcd");
  expectFailure(runProgram("registration_basin", {nowhere, b_, "--count", "10", "--out", out_}),
                {nowhere});
  const std::string odd = folder_.write("cloud.las", "1 2 3\n");
  expectFailure(runProgram("registration_basin", {odd, b_, "--count", "10", "--out", out_}),
                {odd, "extension", "pcd"});
  const std::string empty = folder_.write("empty.xyz", "nan 1 2\n0 0 0\n");
  expectFailure(runProgram("registration_basin", {empty, b_, "--count", "10", "--out", out_}),
                {empty, "no finite point"});
  EXPECT_FALSE(std::filesystem::exists(out_));
  expectFailure(basin({"--methods", "label:surface=0.2", "--truth", truth_}), {"label"});
  expectFailure(runProgram("registration_basin", {a_, b_, "--count", "10", "--out", truth_}),
                {truth_, "folder"});
}

TEST_F(RegistrationBasin, Helps) {
  expectHelp("registration_basin", {"--truth", "--count", "--out", "--methods", "--solver",
                                    "--starts", "--seed", "annealed", "plain", "voxel_grid"});
}

/// A pair of real scans whose transform is known: almost all starts find it.
void expectRealPair(const std::string& a, const std::string& b, const std::string& truth,
                    const std::string& method = "random") {
  if (realData(a).empty()) GTEST_SKIP() << "no real data (LADAR_DATA)";
  const ScratchFolder folder;
  const std::string matrix = folder.write("truth.txt", truth);
  expectSuccess(runProgram(
      "registration_basin",
      {realData(a), realData(b), "--truth", matrix, "--count", "2000", "--out", folder.path(),
       "--methods", method, "--starts", "20", "--steps", "0", "--no-pictures"}));
  const nlohmann::json json = readJson(folder.file("basin.json"));
  EXPECT_GE(json["methods"][method]["success"].get<double>(), 0.9);
  // What is said to have converged has.
  for (const nlohmann::json& start : json["methods"][method]["random"]) {
    EXPECT_TRUE(start["success"] || start["verdict"] != "converged") << start;
  }
}

TEST(RegistrationBasinOfRealScans, HdlPair) {
  expectRealPair("hdl_pair/251370668.pcd", "hdl_pair/251371071.pcd",
                 "0.999941 0.0108432 -0.000635437 0.485657 -0.0108468 0.999924 -0.00587782 0.10642 "
                 "0.000571654 0.00588436 0.999983 -0.0131581 0 0 0 1");
}

TEST(RegistrationBasinOfRealScans, NorlabCar) {
  expectRealPair("norlab_car/car_cloud400.csv", "norlab_car/car_cloud401.csv",
                 "0.981715 0.169605 -0.0864239 0.0614127 -0.152902 0.973034 0.172703 0.191433 "
                 "0.113385 -0.15633 0.981175 -0.0338571 0 0 0 1");
}

TEST(RegistrationBasinOfRealScans, Kitti) {
  expectRealPair("kitti00/000000.bin", "kitti00/000005.bin",
                 "0.999779372 -0.020397945 -0.005013126 3.575650484 0.020393794 0.999791640 "
                 "-0.000877764 0.063010070 0.005029987 0.000775334 0.999987049 0.021580776");
}

/// The truth is its own registration from odometry. Here most of the scan is what is next to the
/// sensor, and random points are not enough.
TEST(RegistrationBasinOfRealScans, IndoorScans) {
  expectRealPair("3dtk_indoor/scan000.3d", "3dtk_indoor/scan001.3d",
                 "0.999858 -0.013324 0.010290 1.569113 0.013378 0.999897 -0.005205 0.038852 "
                 "-0.010218 0.005341 0.999934 -0.100762 0 0 0 1",
                 "range:min=1");
}

}  // namespace
}  // namespace ladar_perception::test
