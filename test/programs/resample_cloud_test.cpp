// SPDX-License-Identifier: BSD-3-Clause
// resample_cloud as a user runs it.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>

#include "ladar_perception/io/pcl_reader.h"
#include "ladar_perception/io/scan_file.h"
#include "ladar_perception/resample/sampling_quality.h"
#include "program_run.h"

namespace ladar_perception::test {
namespace {

constexpr const char* kProgram = "resample_cloud";

/// A floor of 4 by 4 m at z = -1, a point every 2 cm, with a field of rings and colours; label 1
/// where x < 2, else 3.
std::string floorText(bool with_colors = true) {
  std::string text = with_colors ? "x y z ring label red green blue\n" : "x y z ring label\n";
  for (int iy = 0; iy < 200; ++iy) {
    for (int ix = 0; ix < 200; ++ix) {
      // Off the lattice by a little, as a ladar's points are.
      const double x = 0.02 * ix + 0.003 * std::sin(7.0 * ix + 3.0 * iy);
      const double y = 0.02 * iy + 0.003 * std::sin(5.0 * ix - 11.0 * iy);
      text += std::to_string(x) + " " + std::to_string(y) + " -1 " + std::to_string(iy) +
              (ix < 100 ? " 1" : " 3");
      if (with_colors) text += iy < 100 ? " 200 40 30" : " 30 40 200";
      text += "\n";
    }
  }
  return text;
}

struct Input {
  ScratchFolder folder;
  std::string path = folder.write("in/floor.xyz", floorText());

  ProgramRun resample(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), path);
    return runProgram(kProgram, arguments);
  }
};

Scan readBack(const std::string& path) { return readScan(path, scanFormatFromPath(path)); }

std::vector<Eigen::Vector3d> positionsOf(const Scan& scan) {
  const auto x = readColumn(scan, "x");
  const auto y = readColumn(scan, "y");
  const auto z = readColumn(scan, "z");
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t i = 0; i < x.size(); ++i) positions.emplace_back(x[i], y[i], z[i]);
  return positions;
}

class ResampleCloudFormat : public ::testing::TestWithParam<const char*> {};

TEST_P(ResampleCloudFormat, WritesExactlyTheSamplesWithAllFields) {
  const Input input;
  const std::string out = input.folder.file(std::string("out") + GetParam());
  const ProgramRun run = input.resample({"--count", "777", "--out", out});
  expectSuccess(run);
  EXPECT_NE(run.out.find("777 samples of 40000 points"), std::string::npos) << run.out;
  const Scan samples = readBack(out);
  ASSERT_EQ(samples.size(), 777u);
  const auto positions = positionsOf(samples);
  const auto ring = readColumn(samples, "ring");
  const auto label = readColumn(samples, "label");
  const auto normal_z = readColumn(samples, "normal_z");
  const auto covering = readColumn(samples, "covering_radius");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_NEAR(positions[i].z(), -1.0, 1e-4);
    // Fields are those of the nearest point; the crust ends a little beyond the last ones.
    EXPECT_NEAR(0.02 * ring[i], std::clamp(positions[i].y(), 0.0, 3.98), 0.05);
    EXPECT_LT(positions[i].y(), 4.1);
    EXPECT_EQ(label[i], positions[i].x() < 1.99 ? 1.0 : positions[i].x() > 2.01 ? 3.0 : label[i]);
    EXPECT_NEAR(normal_z[i], 1.0, 1e-3) << "towards the sensor, which is above";
    EXPECT_TRUE(i == 0 || covering[i] <= 1.2 * covering[i - 1]) << i;
  }
  EXPECT_GT(covering.back(), 0.0);
  const bool is_text = std::string(GetParam()) == ".xyz" || std::string(GetParam()) == ".csv";
  if (is_text) {
    const auto red = readColumn(samples, "red");
    EXPECT_EQ(red.front(), positions.front().y() < 2.0 ? 200.0 : 30.0);
  } else {
    EXPECT_NE(samples.layout.find("rgb"), nullptr) << samples.layout.describeFields();
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ResampleCloudFormat,
                         ::testing::Values(".pcd", ".ply", ".xyz", ".csv"),
                         [](const auto& format) { return std::string(format.param + 1); });

TEST(ResampleCloud, MetricsTellWhatTheFilesHold) {
  const Input input;
  const std::string out = input.folder.file("out.pcd");
  const std::string metrics = input.folder.file("m.json");
  expectSuccess(input.resample({"--count", "1000", "--out", out, "--metrics", metrics}));
  EXPECT_EQ(input.folder.list(), "in m.json out.pcd");
  const nlohmann::json json = readJson(metrics);
  EXPECT_EQ(json.at("points_in"), 40000);
  EXPECT_EQ(json.at("samples"), 1000);
  EXPECT_EQ(json.at("components"), 1);
  EXPECT_EQ(json.at("lone_points"), 0);
  EXPECT_GT(json.at("cells").get<int>(), 1000);
  EXPECT_GT(json.at("rss_mb").get<double>(), 1.0);
  double sum_ms = 0.0;
  for (const auto& [stage, ms] : json.at("times_ms").items()) {
    EXPECT_GE(ms.get<double>(), 0.0) << stage;
    if (stage != "total") sum_ms += ms.get<double>();
  }
  const double total_ms = json.at("times_ms").at("total");
  EXPECT_GT(total_ms, 0.0);
  EXPECT_LE(sum_ms, 1.01 * total_ms);
  const SpacingStatistics spacing = spacingOf(positionsOf(readPcdScan(out)));
  EXPECT_NEAR(json.at("mean_spacing").get<double>(), spacing.mean_m, 1e-5);
  EXPECT_NEAR(json.at("nn_cov").get<double>(), spacing.cov, 1e-3);
  EXPECT_NEAR(json.at("min_over_mean").get<double>(), spacing.min_over_mean, 1e-3);
  // 16 m^2 over 1000 samples, evenly: points at random would have 0.52, 0.0 and 2.4.
  EXPECT_NEAR(spacing.mean_m, std::sqrt(16.0 / 1000.0), 0.02);
  EXPECT_LT(spacing.cov, 0.15);
  EXPECT_GT(spacing.min_over_mean, 0.6);
  EXPECT_LT(json.at("cover_p99_over_spacing").get<double>(), 0.95);
  EXPECT_GT(json.at("cover_p99_over_spacing").get<double>(), 0.5);
}

TEST(ResampleCloud, StopsAtARadius) {
  const Input input;
  const std::string out = input.folder.file("out.pcd");
  expectSuccess(input.resample({"--radius", "0.2", "--out", out}));
  const Scan samples = readPcdScan(out);
  const auto distances = nearestDistances(positionsOf(readBack(input.path)), positionsOf(samples));
  // No cell is farther; points between cells are, by up to half of a cell's diagonal.
  EXPECT_LT(summarize(distances).max, 0.2 * 1.3);
  EXPECT_GT(summarize(distances).max, 0.2 * 0.8);
  EXPECT_LE(readColumn(samples, "covering_radius").back(), 0.2 + 1e-6);
}

TEST(ResampleCloud, StopsAfterATime) {
  const Input input;
  const std::string out = input.folder.file("out.pcd");
  const std::string metrics = input.folder.file("m.json");
  expectSuccess(input.resample({"--time", "0.05", "--out", out, "--metrics", metrics}));
  EXPECT_GT(readPcdScan(out).size(), 10u);
  EXPECT_LT(readJson(metrics).at("times_ms").at("total").get<double>(), 1000.0);
}

TEST(ResampleCloud, SameBytesForAnyNumberOfThreads) {
  const Input input;
  const auto resample = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"--count", "2000", "--out", input.folder.file(name)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expectSuccess(input.resample(arguments));
    return digestOf(input.folder.file(name));
  };
  for (const std::string engine : {"fast_marching", "flood"}) {
    const auto one = resample("one.pcd", {"--engine", engine});
    EXPECT_EQ(one, resample("again.pcd", {"--engine", engine}));
    EXPECT_EQ(one, resample("two.pcd", {"--engine", engine, "--threads", "2"}));
  }
}

TEST(ResampleCloud, NearestOriginalsAreOriginals) {
  const Input input;
  const std::string out = input.folder.file("out.pcd");
  expectSuccess(input.resample({"--count", "500", "--nearest-original", "--out", out}));
  const auto originals = positionsOf(readBack(input.path));
  const auto distances = nearestDistances(positionsOf(readPcdScan(out)), originals);
  EXPECT_EQ(distances.size(), 500u);
  EXPECT_LT(summarize(distances).max, 1e-6);
}

TEST(ResampleCloud, NormalsPointToTheSensor) {
  const Input input;
  const std::string out = input.folder.file("out.pcd");
  expectSuccess(input.resample({"--count", "100", "--sensor", "2", "2", "-3.5", "--out", out}));
  for (const double z : readColumn(readPcdScan(out), "normal_z")) EXPECT_NEAR(z, -1.0, 1e-3);
}

/// Samples with x < 2 over samples beyond.
double densityRatio(const Input& input, const std::vector<std::string>& more) {
  const std::string out = input.folder.file("out.pcd");
  std::vector<std::string> arguments = {"--count", "3000", "--out", out};
  arguments.insert(arguments.end(), more.begin(), more.end());
  expectSuccess(input.resample(arguments));
  const auto x = readColumn(readPcdScan(out), "x");
  const auto near = std::count_if(x.begin(), x.end(), [](double value) { return value < 2.0; });
  return static_cast<double>(near) / static_cast<double>(x.size() - near);
}

TEST(ResampleCloud, PoliciesSteerTheDensity) {
  const Input input;
  EXPECT_NEAR(densityRatio(input, {}), 1.0, 0.06);
  EXPECT_NEAR(densityRatio(input, {"--policy", "label:surface=4"}), 4.0, 0.5);
  EXPECT_NEAR(densityRatio(input, {"--policy", "label:surface=4", "--policy", "label:linear=4"}),
              1.0, 0.06);
  const std::string classes = input.folder.write(
      "in/classes.yaml",
      "classes:\n  - {name: left, labels: [1]}\n  - {name: right, labels: [3]}\n");
  EXPECT_NEAR(densityRatio(input, {"--classes", classes, "--policy", "label:right=4"}), 0.25, 0.03);
  // The ring is no label of the classes, and is not looked at without a policy that does.
  EXPECT_NEAR(densityRatio(input, {"--label-field", "ring"}), 1.0, 0.06);
}

TEST(ResampleCloud, ColoursOfTextFilesArePolicies) {
  const Input input;
  const std::string out = input.folder.file("out.pcd");
  expectSuccess(input.resample(
      {"--count", "3000", "--policy", "color:target=#c8281e,softness=40,ratio=9", "--out", out}));
  const auto y = readColumn(readPcdScan(out), "y");
  const auto red = std::count_if(y.begin(), y.end(), [](double value) { return value < 2.0; });
  EXPECT_GT(red, 2500);
}

TEST(ResampleCloud, RefusesBadArguments) {
  const Input input;
  const std::string out = input.folder.file("out.pcd");
  const auto expectRefusal = [&](std::vector<std::string> arguments,
                                 const std::vector<std::string>& parts) {
    if (std::find(arguments.begin(), arguments.end(), "--out") == arguments.end()) {
      arguments.insert(arguments.end(), {"--out", out});
    }
    expectFailure(input.resample(arguments), parts);
  };
  expectRefusal({}, {"--count", "--radius", "--time"});
  expectRefusal({"--count", "0"}, {"--count", "0"});
  expectRefusal({"--count", "many"}, {"--count", "many"});
  expectRefusal({"--radius", "-1"}, {"radius", "-1"});
  expectRefusal({"--radius", "nan"}, {"radius", "nan"});
  expectRefusal({"--count", "5", "--time", "-1"}, {"time", "-1"});
  expectRefusal({"--count", "5", "--threads", "0"}, {"threads", "0"});
  expectRefusal({"--count", "5", "--engine", "magic"}, {"--engine", "magic", "flood"});
  expectRefusal({"--count", "5", "--crust", "pizza"}, {"--crust", "pizza", "surfels"});
  expectRefusal({"--count", "5", "--format", "las"}, {"--format", "las", "pcd"});
  expectRefusal({"--count", "5", "--format", "pcd", "--columns", "x,y,z"}, {"--columns", "xyz"});
  expectRefusal({"--count", "5", "--sensor", "1", "2"}, {"--sensor"});
  expectRefusal({"--count", "5", "--sensor", "1", "2", "inf"}, {"--sensor", "finite"});
  expectRefusal({"--count", "5", "--policy", "shiny"}, {"shiny", "uniform"});
  expectRefusal({"--count", "5", "--policy", "range:min=x"}, {"range:min=x"});
  expectRefusal({"--count", "5", "--policy", "label:tree=2"}, {"tree", "surface"});
  expectRefusal({"--count", "5", "--classes", "/nowhere.yaml"}, {"/nowhere.yaml"});
  expectRefusal({"--count", "5", "--out", input.folder.file("out.las")}, {"out.las", ".pcd"});
  expectFailure(runProgram(kProgram, {"--count", "5", "--out", out}), {"input"});
  EXPECT_EQ(input.folder.list(), "in");
}

TEST(ResampleCloud, FindsOutputsItCannotWriteFirst) {
  const ScratchFolder folder;
  // The input does not exist: the outputs are looked at before.
  const std::string lost = folder.file("none/out.pcd");
  expectFailure(runProgram(kProgram, {"in.pcd", "--count", "5", "--out", lost}), {lost});
  const std::string metrics = folder.file("none/m.json");
  expectFailure(runProgram(kProgram, {"in.pcd", "--count", "5", "--out", folder.file("out.pcd"),
                                      "--metrics", metrics}),
                {metrics});
  EXPECT_EQ(folder.list(), "");
}

TEST(ResampleCloud, SaysWhatIsWrongWithTheInput) {
  const ScratchFolder folder;
  const auto expectRefusal = [&](const std::string& path, const std::vector<std::string>& more,
                                 const std::vector<std::string>& parts) {
    std::vector<std::string> arguments = {path, "--count", "50", "--out", folder.file("o.pcd")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expectFailure(runProgram(kProgram, arguments), parts);
  };
  const std::string head =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA binary\n";
  const std::string body = bytesOf<float>({1, 2, 3, 4, 5, 6, 7, 8, 9});
  const std::string cut = folder.write("cut.pcd", head + body.substr(0, 20));
  expectRefusal(cut, {}, {cut, "ends early"});
  std::string text = head;
  text.replace(text.find("FIELDS x"), 8, "FIELDS u");
  const std::string no_x = folder.write("no_x.pcd", text + body);
  expectRefusal(no_x, {}, {no_x, "'x'"});
  expectRefusal(folder.file("none.pcd"), {}, {"none.pcd", "cannot be opened"});
  expectRefusal(folder.write("a.las", "x"), {}, {"a.las", ".pcd"});
  const std::string plain = folder.write("plain.xyz", floorText(false));
  expectRefusal(plain, {"--policy", "color:target=#ffffff"}, {"color", "rgb"});
  expectRefusal(plain, {"--policy", "label:surface=2", "--label-field", "class"},
                {plain, "'class'", "ring"});
  expectRefusal(plain, {"--policy", "label:surface=2", "--label-field", "ring"},
                {plain, "'ring'", "from 0 to 3"});
  std::string nans = "x y z\n";
  for (int i = 0; i < 20; ++i) nans += "nan 1 2\n";
  const std::string nowhere = folder.write("nan.xyz", nans);
  expectRefusal(nowhere, {}, {nowhere, "0 finite points of 20"});
  EXPECT_EQ(folder.list(), "a.las cut.pcd nan.xyz no_x.pcd plain.xyz");
}

TEST(ResampleCloud, TinyCloudsGiveWhatTheyHold) {
  const ScratchFolder folder;
  for (const int points : {1, 2, 3}) {
    std::string text = "x y z\n";
    for (int i = 0; i < points; ++i) text += std::to_string(i) + " 0 0\n";
    const std::string path = folder.write("tiny.xyz", text);
    const std::string out = folder.file("out.xyz");
    const ProgramRun run =
        runProgram(kProgram, {path, "--count", "1000", "--min-component", "1", "--cell-size", "0.1",
                              "--out", out, "--metrics", folder.file("m.json")});
    expectSuccess(run);
    EXPECT_NE(run.err.find("note: "), std::string::npos) << run;
    const Scan samples = readBack(out);
    EXPECT_GE(samples.size(), 1u);
    EXPECT_LT(samples.size(), 1000u);
    EXPECT_EQ(readJson(folder.file("m.json")).at("points_in"), points);
  }
}

TEST(ResampleCloud, ReadsRealScansOfEveryKind) {
  const ScratchFolder folder;
  std::set<std::string> read;
  for (const std::string name :
       {"kitti00/000000.bin", "pjlab/2021-10-26-16-21-29-468.pcd", "3dtk_indoor/scan000.3d",
        "oakland/tiles/oakland_part2_ac.xyz_label_conf"}) {
    const std::string path = realData(name);
    if (path.empty()) continue;
    const std::string out = folder.file("out.ply");
    expectSuccess(runProgram(kProgram, {path, "--count", "3000", "--out", out}));
    EXPECT_EQ(readPlyScan(out).size(), 3000u) << name;
    read.insert(name);
  }
  if (read.empty()) GTEST_SKIP() << "no real data";
}

TEST(ResampleCloud, Helps) {
  expectHelp(kProgram,
             {"--count", "--radius", "--time", "--policy", "--classes", "--engine", "--crust",
              "--threads", "--sensor", "--nearest-original", "--format", "--out", "--metrics"});
}

}  // namespace
}  // namespace ladar_perception::test
