// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <memory>

#include "ladar_perception/classify/classifier_model.h"
#include "program_bag.h"
#include "program_labelled.h"
#include "program_run.h"

namespace ladar_perception::test {
namespace {

using Json = nlohmann::json;

/// A model of three classes learned from one street, to be judged on another.
class EvaluateClassifier : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = std::make_unique<ScratchFolder>();
    const std::string tile = shared_->write("learn.xyz_label_conf", oaklandText(street(1)));
    expectSuccess(runProgram("train_classifier", {tile, "--out", model(), "--samples", "1000",
                                                  "--components", "2", "--passes", "whole"}));
  }
  static void TearDownTestSuite() { shared_.reset(); }
  static std::string model() { return shared_->file("model.yaml"); }

  ProgramRun evaluate(std::vector<std::string> more) {
    more.insert(more.begin(),
                {"--model", model(), "--report", folder_.file("report"), "--no-pictures"});
    return runProgram("evaluate_classifier", more);
  }
  Json report() const { return readJson(folder_.file("report/report.json")); }
  std::string tile(uint64_t seed = 2) {
    return folder_.write("tile.xyz_label_conf", oaklandText(street(seed)));
  }
  /// The shared model with its classes in another order.
  std::string permutedModel() {
    ClassifierModel permuted = loadClassifierModel(model());
    std::swap(permuted.classes[0], permuted.classes[2]);
    Calibration& calibration = permuted.calibration;
    std::swap(calibration.offsets[0], calibration.offsets[2]);
    std::swap(calibration.smoothing.offsets[0], calibration.smoothing.offsets[2]);
    saveClassifierModel(permuted, folder_.file("permuted.yaml"));
    return folder_.file("permuted.yaml");
  }

  ScratchFolder folder_;

 private:
  static std::unique_ptr<ScratchFolder> shared_;
};
std::unique_ptr<ScratchFolder> EvaluateClassifier::shared_;

uint64_t sumOf(const Json& counts) {
  uint64_t sum = 0;
  for (const Json& entry : counts) sum += entry.is_array() ? sumOf(entry) : entry.get<uint64_t>();
  return sum;
}

TEST_F(EvaluateClassifier, EveryLabelledPointCounts) {
  auto points = street(2);
  // One that is far from all others, and one at no place at all.
  points.push_back({600.0, 0.0, 3.0, kGroundLabel});  // 4 m lower, too
  points.push_back({130.0, -45.0, 5000.0, kPoleLabel});
  std::size_t labelled = 0;
  for (const LabelledPoint& p : points) labelled += p.label != 9999 ? 1 : 0;
  const std::string path = folder_.write("tile.xyz_label_conf", oaklandText(points));
  const ProgramRun run = evaluate({path});
  expectSuccess(run);
  const Json r = report();
  EXPECT_EQ(r["points"], labelled);
  EXPECT_EQ(sumOf(r["confusion"]) + sumOf(r["unknown"]), labelled);
  EXPECT_GE(sumOf(r["unknown"]), 2u);
  EXPECT_EQ(r["points_outside_map"], 1);
  EXPECT_EQ(r["classes"], (Json{"surface", "scatter", "linear"}));
  EXPECT_EQ(r["inputs"], (Json{path}));
  EXPECT_GT(r["mean_recall"].get<double>(), 0.9);
  EXPECT_GT(r["mean_f1"].get<double>(), 0.85);
  for (const char* name : {"surface", "scatter", "linear"}) {
    EXPECT_GT(r["recall"][name].get<double>(), 0.75) << name;
  }
  for (const char* part : {"surface", "precision", "mean", "calibration"}) {
    EXPECT_NE(run.out.find(part), std::string::npos) << part << " is not in " << run.out;
  }
}

TEST_F(EvaluateClassifier, FiguresAreThoseOfTheConfusion) {
  expectSuccess(evaluate({tile()}));
  const Json r = report();
  const Json& m = r["confusion"];
  double recalls = 0.0;
  double right = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double row = sumOf(m[c]) + r["unknown"][c].get<double>();
    const double column = m[0][c].get<double>() + m[1][c].get<double>() + m[2][c].get<double>();
    const std::string name = r["classes"][c];
    const double hit = m[c][c].get<double>();
    EXPECT_DOUBLE_EQ(r["recall"][name].get<double>(), hit / row);
    EXPECT_DOUBLE_EQ(r["precision"][name].get<double>(), hit / column);
    EXPECT_NEAR(r["f1"][name].get<double>(), 2.0 * hit / (row + column), 1e-12);
    recalls += hit / row;
    right += hit;
  }
  EXPECT_NEAR(r["mean_recall"].get<double>(), recalls / 3.0, 1e-12);
  EXPECT_NEAR(r["overall_accuracy"].get<double>(), right / r["points"].get<double>(), 1e-12);
  double shares = 0.0;
  double ece = 0.0;
  for (const Json& bin : r["calibration"]["bins"]) {
    shares += bin["share"].get<double>();
    ece += bin["share"].get<double>() *
           std::abs(bin["confidence"].get<double>() - bin["accuracy"].get<double>());
  }
  EXPECT_NEAR(shares, 1.0, 1e-9);
  EXPECT_NEAR(r["calibration"]["ece"].get<double>(), ece, 1e-9);
}

TEST_F(EvaluateClassifier, AllFormatsSayTheSame) {
  const auto points = street(2);
  const std::string classes = LADAR_SOURCE_DIR "/config/classes/oakland_three.yaml";
  expectSuccess(evaluate({folder_.write("a.xyz_label_conf", oaklandText(points))}));
  const Json expected = report()["confusion"];
  const std::vector<std::string> paths = {folder_.write("a.ply", plyText(points)),
                                          folder_.write("a.pcd", pcdText(points)),
                                          folder_.write("a.csv", csvText(points, "label"))};
  for (const std::string& path : paths) {
    expectSuccess(evaluate({path, "--classes", classes}));
    EXPECT_EQ(report()["confusion"], expected) << path;
  }
  // No extension tells, but --format does.
  const std::string odd = folder_.write("a.dat", oaklandText(points));
  expectFailure(evaluate({odd}), {odd, "--format"});
  expectSuccess(evaluate({odd, "--format", "oakland"}));
  EXPECT_EQ(report()["confusion"], expected);
}

TEST_F(EvaluateClassifier, KittiScansInAFolderAreOneInput) {
  writeKitti(folder_, "velodyne/000000", street(2));
  writeKitti(folder_, "velodyne/000001", street(3));
  expectSuccess(evaluate({folder_.file("velodyne")}));
  const Json r = report();
  EXPECT_EQ(r["inputs"].size(), 1u);
  EXPECT_EQ(r["points"], 2 * (24000 + 12 * 1550 + 3000) * 99 / 100);
  EXPECT_GT(r["mean_recall"].get<double>(), 0.85);
  std::filesystem::remove(folder_.file("velodyne/000001.label"));
  expectFailure(evaluate({folder_.file("velodyne")}), {"000001.bin", "'label'"});
}

TEST_F(EvaluateClassifier, ClassesGoByNameNotByPlace) {
  const std::string path = tile();
  expectSuccess(evaluate({path}));
  const Json plain = report();
  expectSuccess(runProgram("evaluate_classifier", {path, "--model", permutedModel(), "--report",
                                                   folder_.file("report"), "--no-pictures"}));
  const Json permuted = report();
  EXPECT_EQ(permuted["classes"], (Json{"linear", "scatter", "surface"}));
  EXPECT_EQ(permuted["recall"], plain["recall"]);
  EXPECT_EQ(permuted["precision"], plain["precision"]);
  EXPECT_EQ(permuted["confusion"][0][2], plain["confusion"][2][0]);
}

TEST_F(EvaluateClassifier, MappingsThatDoNotFitAreRefused) {
  const std::string more = folder_.write(
      "more.yaml", "classes: [{name: surface, labels: [1202]}, {name: lake, labels: [3]}]\n");
  expectFailure(evaluate({tile(), "--classes", more}),
                {more, "'lake'", "surface, scatter, linear"});
  // Fewer classes than the model's: the others have no truth.
  const std::string fewer = folder_.write(
      "fewer.yaml", "classes: [{name: linear, labels: [1103]}, {name: surface, labels: [1202]}]\n");
  expectSuccess(evaluate({tile(), "--classes", fewer}));
  EXPECT_TRUE(report()["recall"]["scatter"].is_null());
  EXPECT_GT(report()["mean_recall"].get<double>(), 0.9);
  const std::string none = folder_.write(
      "none.yaml", "classes: [{name: linear, labels: [5]}, {name: surface, labels: [6]}]\n");
  expectFailure(evaluate({tile(), "--classes", none}), {"tile.xyz_label_conf", "not one point"});
}

TEST_F(EvaluateClassifier, AFiveClassModelHasItsOwnMapping) {
  const std::string classes = "package://ladar_perception/config/classes/oakland_five.yaml";
  const std::string five = folder_.file("five.yaml");
  expectSuccess(runProgram("train_classifier", {tile(1), "--classes", classes, "--out", five,
                                                "--samples", "800", "--components", "2"}));
  expectSuccess(runProgram("evaluate_classifier", {tile(2), "--model", five, "--report",
                                                   folder_.file("report"), "--no-pictures"}));
  const Json r = report();
  EXPECT_EQ(r["classes"], (Json{"wire", "pole_trunk", "ground", "vegetation", "facade"}));
  EXPECT_EQ(r["colors"][0], "#0072b2");
  EXPECT_GT(r["mean_recall"].get<double>(), 0.65);  // of chance 0.2
  // Of other classes nothing is known.
  ClassifierModel other = loadClassifierModel(five);
  other.classes[0].name = "cable";
  saveClassifierModel(other, five);
  expectFailure(runProgram("evaluate_classifier", {tile(2), "--model", five}),
                {"tile.xyz_label_conf", "cable", "--classes"});
}

TEST_F(EvaluateClassifier, StreamGoesThroughTheVehiclesMap) {
  const std::string path = tile();
  expectSuccess(evaluate({path, "--pass", "stream"}));
  const Json narrow = report();
  EXPECT_EQ(narrow["per_input"][0]["pass"], "stream");
  // Higher than 2 m above the ground is outside the default map.
  EXPECT_GT(narrow["points_outside_map"].get<int>(), 5000);
  EXPECT_GT(narrow["mean_recall_in_map"].get<double>(), narrow["mean_recall"].get<double>());
  const std::string config = folder_.write(
      "wide.yaml", "map_size_x_m: 60\nmap_size_y_m: 60\nmap_size_z_m: 20\nmin_range_m: 0\n");
  expectSuccess(evaluate({path, "--pass", "stream", "--config", config}));
  const Json wide = report();
  EXPECT_EQ(wide["points_outside_map"], 0);
  EXPECT_EQ(wide["points"], narrow["points"]);
  EXPECT_GT(wide["mean_recall"].get<double>(), 0.85);
}

TEST_F(EvaluateClassifier, BagsAreJudgedAsClassifyBagDoes) {
  const std::string drive = folder_.file("drive.bag");
  expectSuccess(
      runProgram("simulate_ladar", {"--scene", "campus", "--duration", "1", "--out", drive}));
  expectSuccess(evaluate({drive}));
  const Json r = report();
  const std::string metrics = folder_.file("m.json");
  expectSuccess(runProgram("classify_bag", {drive, "--model", model(), "--metrics", metrics}));
  const Json m = readJson(metrics);
  EXPECT_EQ(r["per_input"][0]["pass"], "recorded");
  EXPECT_EQ(r["points_outside_map"], m["truth_points_outside_map"]);
  EXPECT_EQ(r["points"].get<uint64_t>(),
            m["truth_points"].get<uint64_t>() + m["truth_points_outside_map"].get<uint64_t>());
  EXPECT_EQ(r["confusion"][1][0], m["confusion"]["scatter"]["surface"]);
  EXPECT_EQ(r["confusion"][2][2], m["confusion"]["linear"]["linear"]);
  EXPECT_NEAR(r["mean_recall_in_map"].get<double>(), m["mean_recall"].get<double>(), 1e-12);
  // The truth of a bag goes by name as well.
  expectSuccess(runProgram("evaluate_classifier", {drive, "--model", permutedModel(), "--report",
                                                   folder_.file("report"), "--no-pictures"}));
  EXPECT_EQ(report()["recall"], r["recall"]);
}

TEST_F(EvaluateClassifier, LabelsOfBagsAreMappedToo) {
  const std::string bag = folder_.file("tile.bag");
  expectSuccess(runProgram("import_scans", {"--format", "oakland", tile(), "--out", bag}));
  expectSuccess(evaluate({bag}));  // by the truth that import_scans wrote
  const Json by_truth = report();
  const std::string classes = LADAR_SOURCE_DIR "/config/classes/oakland_three.yaml";
  expectSuccess(evaluate({bag, "--classes", classes}));
  EXPECT_EQ(report()["confusion"], by_truth["confusion"]);
  EXPECT_EQ(report()["unknown"], by_truth["unknown"]);
  // The same scans as those of the tile's stream.
  expectSuccess(evaluate({tile(), "--pass", "stream"}));
  EXPECT_EQ(report()["points"], by_truth["points"]);
  EXPECT_NEAR(report()["mean_recall"].get<double>(), by_truth["mean_recall"].get<double>(), 0.005);
  expectFailure(evaluate({bag, "--classes", classes, "--label-field", "kind"}), {bag, "'kind'"});
}

TEST_F(EvaluateClassifier, ModelDecidesOnVoxelsAndSupports) {
  const std::string config = folder_.write("coarse.yaml",
                                           "voxel_size_m: 0.3\nsupport_radius_voxels: 2\n"
                                           "min_support_points: 6\n");
  const std::string coarse = folder_.file("coarse_model.yaml");
  expectSuccess(runProgram("train_classifier", {tile(1), "--out", coarse, "--config", config,
                                                "--samples", "800", "--components", "2"}));
  expectSuccess(runProgram("evaluate_classifier", {tile(2), "--model", coarse}));
  const ProgramRun with_config =
      runProgram("evaluate_classifier", {tile(2), "--model", model(), "--config", config});
  expectSuccess(with_config);
}

TEST_F(EvaluateClassifier, DrawsPictures) {
  const std::string folder = folder_.file("report");
  expectSuccess(
      runProgram("evaluate_classifier", {tile(), "--model", model(), "--report", folder}));
  for (const char* name : {"confusion", "reliability", "features", "cloud_1"}) {
    EXPECT_EQ(fileBytes(folder + "/" + name + ".png").substr(1, 3), "PNG") << name;
  }
  expectSuccess(evaluate({tile()}));
}

TEST_F(EvaluateClassifier, WithoutMatplotlibTheReportStays) {
  // A module of that name that cannot be imported.
  folder_.write("python/matplotlib/__init__.py", "raise ImportError('not here')\n");
  setenv("PYTHONPATH", folder_.file("python").c_str(), 1);
  const ProgramRun run = runProgram(
      "evaluate_classifier", {tile(), "--model", model(), "--report", folder_.file("report")});
  unsetenv("PYTHONPATH");
  expectSuccess(run);
  EXPECT_NE(run.err.find("matplotlib is missing"), std::string::npos) << run;
  EXPECT_GT(report()["mean_recall"].get<double>(), 0.9);
}

TEST_F(EvaluateClassifier, FindsTroubleBeforeTheWork) {
  expectFailure(runProgram("evaluate_classifier", {tile(), "--model", folder_.file("no.yaml")}),
                {"no.yaml"});
  expectFailure(runProgram("evaluate_classifier", {tile(), "--model", model(), "--report",
                                                   folder_.write("file", "") + "/x"}),
                {"file/x"});
  expectFailure(evaluate({folder_.file("none.ply")}), {"none.ply", "no such"});
  expectFailure(runProgram("evaluate_classifier", {tile()}), {"--model"});
  expectFailure(evaluate({tile(), "--pass", "half"}), {"--pass", "half"});
  const std::string empty = folder_.write("empty.xyz_label_conf", "");
  expectFailure(evaluate({empty}), {empty});
}

TEST_F(EvaluateClassifier, Helps) {
  expectHelp("evaluate_classifier", {"--model", "--report", "--classes", "--config", "--pass",
                                     "--label-field", "--format", "--no-pictures"});
}

/// On real data: what is learned from two tiles holds on two others.
TEST(OaklandTiles, LearnedFromPart3HoldsOnPart2) {
  const std::string tiles = realData("oakland/tiles");
  if (tiles.empty()) GTEST_SKIP() << "oakland/tiles is not there: set LADAR_DATA to its folder";
  const ScratchFolder folder;
  const std::string model = folder.file("model.yaml");
  const std::string begin = tiles + "/oakland_part";
  const std::string end = ".xyz_label_conf";
  const std::string config = folder.write("wide.yaml",
                                          "map_size_x_m: 60\nmap_size_y_m: 60\nmap_size_z_m: 40\n"
                                          "map_center_height_m: 15\n");
  expectSuccess(runProgram("train_classifier",
                           {"--config", config, "--out", model, "--features",
                            "cbrt_scatter,cbrt_surface,cbrt_linear,normal_angle,tangent_angle",
                            begin + "3_am" + end, begin + "3_an" + end}));
  for (const std::string pass : {"whole", "stream"}) {
    const std::string report = folder.file(pass);
    expectSuccess(
        runProgram("evaluate_classifier",
                   {"--config", config, "--model", model, "--report", report, "--no-pictures",
                    "--pass", pass, begin + "2_ac" + end, begin + "2_ah" + end}));
    const Json r = readJson(report + "/report.json");
    EXPECT_EQ(r["points"], 97588 + 98658);
    EXPECT_GT(r["mean_recall"].get<double>(), 0.75) << pass;
    EXPECT_LT(r["calibration"]["class_balanced_ece"].get<double>(), 0.06) << pass;
  }
}

}  // namespace
}  // namespace ladar_perception::test
