// SPDX-License-Identifier: BSD-3-Clause
// simulate_ladar --cloud: single clouds with the true surface.
#include <Eigen/Core>
#include <cmath>

#include "ladar_perception/io/pcl_reader.h"
#include "ladar_perception/io/text_reader.h"
#include "program_run.h"

namespace ladar_perception::test {
namespace {

std::vector<Eigen::Vector3d> vectorsOf(const Scan& scan, const std::string& prefix) {
  const auto x = readColumn(scan, prefix + "x");
  const auto y = readColumn(scan, prefix + "y");
  const auto z = readColumn(scan, prefix + "z");
  std::vector<Eigen::Vector3d> vectors;
  for (std::size_t i = 0; i < x.size(); ++i) vectors.emplace_back(x[i], y[i], z[i]);
  return vectors;
}

TEST(SimulateCloud, WritesPointsWithTheirTruth) {
  const ScratchFolder folder;
  const std::string path = folder.file("campus.pcd");
  const ProgramRun run = runProgram(
      "simulate_ladar",
      {"--scene", "campus", "--cloud", path, "--points", "20000", "--range-noise", "0.05"});
  expectSuccess(run);
  EXPECT_NE(run.out.find(path), std::string::npos) << run.out;
  EXPECT_EQ(folder.list(), "campus.pcd");
  const Scan scan = readPcdScan(path);
  EXPECT_NEAR(static_cast<double>(scan.size()), 20000.0, 600.0);
  EXPECT_EQ(scan.layout.describeFields(),
            "x:float32, y:float32, z:float32, intensity:float32, rgb:float32, truth:uint8, "
            "label:uint16, true_x:float32, true_y:float32, true_z:float32, true_normal_x:float32, "
            "true_normal_y:float32, true_normal_z:float32, face:uint32");
  const auto measured = vectorsOf(scan, "");
  const auto real = vectorsOf(scan, "true_");
  const auto normals = vectorsOf(scan, "true_normal_");
  const auto truth = readColumn(scan, "truth");
  const auto face = readColumn(scan, "face");
  double squares = 0.0;
  std::size_t flat = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    squares += (measured[i] - real[i]).squaredNorm();
    EXPECT_NEAR(normals[i].norm(), 1.0, 1e-5);
    EXPECT_LT(normals[i].dot(real[i]), 1e-2);
    EXPECT_TRUE(truth[i] >= 1.0 && truth[i] <= 3.0);
    flat += face[i] > 0.0 ? 1 : 0;
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(scan.size())), 0.05, 0.002);
  EXPECT_GT(flat, 1000u);
}

TEST(SimulateCloud, SameArgumentsSameBytesInEveryFormat) {
  const ScratchFolder folder;
  const auto simulate = [&](const std::string& name, const std::string& seed) {
    expectSuccess(runProgram("simulate_ladar",
                             {"--scene", "flat_ground", "--points", "1000", "--at", "30", "--left",
                              "1", "--seed", seed, "--cloud", folder.file(name)}));
  };
  simulate("a.ply", "1");
  simulate("b.ply", "1");
  simulate("c.ply", "2");
  simulate("d.xyz", "1");
  EXPECT_EQ(digestOf(folder.file("a.ply")), digestOf(folder.file("b.ply")));
  EXPECT_NE(digestOf(folder.file("a.ply")), digestOf(folder.file("c.ply")));
  const auto from_ply = vectorsOf(readPlyScan(folder.file("a.ply")), "");
  const auto from_text = vectorsOf(readTextScan(folder.file("d.xyz")), "");
  EXPECT_EQ(from_ply, from_text);
}

TEST(SimulateCloud, RefusesBadArguments) {
  const ScratchFolder folder;
  const auto simulate = [&](std::vector<std::string> arguments) {
    return runProgram("simulate_ladar", arguments);
  };
  const std::string path = folder.file("a.pcd");
  expectFailure(simulate({"--cloud", path, "--out", folder.file("a.bag")}), {"--cloud", "--out"});
  expectFailure(simulate({"--cloud", path, "--sensor", "xuv"}), {"--cloud", "--sensor"});
  expectFailure(simulate({"--cloud", path, "--speed", "1"}), {"--cloud", "--speed"});
  expectFailure(simulate({"--cloud", path, "--points", "10"}), {"--points", "10"});
  expectFailure(simulate({"--cloud", path, "--range-noise", "nan"}), {"--range-noise", "nan"});
  expectFailure(simulate({"--out", folder.file("a.bag"), "--points", "2000"}),
                {"--points", "--cloud"});
  expectFailure(simulate({"--cloud", folder.file("a.las")}), {"a.las", ".pcd"});
  const std::string lost = folder.file("none/a.pcd");
  expectFailure(simulate({"--cloud", lost}), {lost});
  EXPECT_EQ(folder.list(), "");
}

TEST(SimulateCloud, Helps) {
  expectHelp("simulate_ladar", {"--cloud", "--points", "--range-noise", "--at", "--left"});
}

}  // namespace
}  // namespace ladar_perception::test
