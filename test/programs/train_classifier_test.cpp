// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <memory>

#include "ladar_perception/classify/classifier_model.h"
#include "program_bag.h"
#include "program_labelled.h"
#include "program_run.h"

namespace ladar_perception::test {
namespace {

/// The same two short drives for all tests.
class TrainClassifier : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = std::make_unique<ScratchFolder>();
    for (const std::string scene : {"forest", "campus"}) {
      expectSuccess(runProgram("simulate_ladar", {"--scene", scene, "--duration", "2", "--seed",
                                                  "11", "--out", drive(scene)}));
    }
  }
  static void TearDownTestSuite() { shared_.reset(); }
  static std::string drive(const std::string& scene) { return shared_->file(scene + ".bag"); }

  ProgramRun train(std::vector<std::string> more, const std::string& name = "model.yaml") {
    more.insert(more.begin(),
                {"--out", folder_.file(name), "--samples", "800", "--components", "2"});
    return runProgram("train_classifier", more);
  }

  ScratchFolder folder_;

 private:
  static std::unique_ptr<ScratchFolder> shared_;
};
std::unique_ptr<ScratchFolder> TrainClassifier::shared_;

TEST_F(TrainClassifier, MakesAModelThatWorks) {
  const ProgramRun run = train({drive("forest"), drive("campus")});
  expectSuccess(run);
  const std::string path = folder_.file("model.yaml");
  const ClassifierModel model = loadClassifierModel(path);
  ASSERT_EQ(model.classes.size(), 3u);
  EXPECT_EQ(model.labelName(1), "surface");
  EXPECT_EQ(model.labelName(2), "scatter");
  EXPECT_EQ(model.labelName(3), "linear");
  EXPECT_EQ(modelMisfit(model, 0.1, 6), "");
  EXPECT_TRUE(std::isfinite(model.unknown_log_likelihood));
  for (const ModelClass& model_class : model.classes) {
    EXPECT_GE(model_class.mixture.size(), 1u);
    EXPECT_LE(model_class.mixture.size(), 2u);
  }
  EXPECT_EQ(model.provenance.at("inputs"), "forest.bag campus.bag");
  EXPECT_EQ(model.provenance.count("seed"), 1u);

  const std::string metrics = folder_.file("m.json");
  expectSuccess(
      runProgram("classify_bag", {drive("forest"), "--model", path, "--metrics", metrics}));
  EXPECT_EQ(readJson(metrics)["model"], path);
  EXPECT_GT(readJson(metrics)["mean_recall"].get<double>(), 0.6);
}

TEST_F(TrainClassifier, SameArgumentsSameBytes) {
  expectSuccess(train({drive("forest")}, "a.yaml"));
  expectSuccess(train({drive("forest")}, "b.yaml"));
  expectSuccess(train({drive("forest"), "--seed", "2"}, "c.yaml"));
  EXPECT_EQ(fileBytes(folder_.file("a.yaml")), fileBytes(folder_.file("b.yaml")));
  EXPECT_NE(fileBytes(folder_.file("a.yaml")), fileBytes(folder_.file("c.yaml")));
}

TEST_F(TrainClassifier, UsesFeaturesAndConfiguration) {
  const std::string config =
      folder_.write("coarse.yaml", "voxel_size_m: 0.2\nsupport_radius_voxels: 2\n");
  expectSuccess(train({drive("forest"), "--config", config, "--features",
                       "cbrt_scatter,cbrt_surface,cbrt_linear"}));
  const ClassifierModel model = loadClassifierModel(folder_.file("model.yaml"));
  EXPECT_EQ(model.features.size(), 3u);
  EXPECT_EQ(modelMisfit(model, 0.2, 2), "");
  EXPECT_NE(modelMisfit(model, 0.1, 6), "");
}

TEST_F(TrainClassifier, NeedsTruth) {
  const std::string bare = editedBag(
      drive("campus"), folder_.file("bare.bag"), [](const auto& message, rosbag::Bag* to) {
        if (message.getTopic() != "/points") return writeAsItIs(message, to);
        auto cloud = *message.template instantiate<sensor_msgs::PointCloud2>();
        for (auto& field : cloud.fields) {
          if (field.name == "truth") field.name = "class";
        }
        to->write(message.getTopic(), message.getTime(), cloud);
      });
  expectFailure(train({bare}), {bare, "truth", "x:float32", "class:uint8"});
  EXPECT_EQ(folder_.list(), "bare.bag");
}

TEST_F(TrainClassifier, SaysWhichClassHasTooFewSamples) {
  const std::string surface = editedBag(
      drive("forest"), folder_.file("surface.bag"), [](const auto& message, rosbag::Bag* to) {
        if (message.getTopic() != "/points") return writeAsItIs(message, to);
        auto cloud = *message.template instantiate<sensor_msgs::PointCloud2>();
        const uint32_t offset = findField(cloud, "truth")->offset;
        for (std::size_t i = offset; i < cloud.data.size(); i += cloud.point_step) {
          if (cloud.data[i] == 3) cloud.data[i] = 0;
        }
        to->write(message.getTopic(), message.getTime(), cloud);
      });
  expectFailure(train({surface}), {"'linear'", "0 samples", "0 labelled points"});
  EXPECT_EQ(folder_.list(), "surface.bag");
}

TEST_F(TrainClassifier, SaysWhichBagHasNoTransforms) {
  const std::string no_tf = editedBag(drive("campus"), folder_.file("no_tf.bag"),
                                      [](const auto& message, rosbag::Bag* to) {
                                        if (message.getTopic() != "/tf") writeAsItIs(message, to);
                                      });
  // Not "class 'surface' has 0 samples": that would hide why.
  expectFailure(train({no_tf}), {no_tf, "no_transform"});
  EXPECT_EQ(folder_.list(), "no_tf.bag");
}

TEST_F(TrainClassifier, LearnsFromATileInBothPasses) {
  const std::string tile = folder_.write("tile.xyz_label_conf", oaklandText(street(1)));
  const ProgramRun run = train({tile, "--report", folder_.file("report")});
  expectSuccess(run);
  const ClassifierModel model = loadClassifierModel(folder_.file("model.yaml"));
  EXPECT_EQ(model.provenance.at("inputs"), "tile.xyz_label_conf");
  const nlohmann::json report = readJson(folder_.file("report/report.json"));
  EXPECT_EQ(report["kind"], "training");
  // Ground and walls, but every 100th, once whole and once as a stream.
  EXPECT_NEAR(report["classes"][0]["points"].get<double>(), 2 * 0.99 * (24000 + 12 * 600), 700);
  for (const char* picture : {"report/features.png"}) {
    EXPECT_EQ(fileBytes(folder_.file(picture)).substr(1, 3), "PNG") << picture;
  }
  expectSuccess(train({tile, "--passes", "whole", "--report", folder_.file("whole")}));
  const nlohmann::json whole = readJson(folder_.file("whole/report.json"));
  EXPECT_EQ(2 * whole["classes"][0]["points"].get<int>(), report["classes"][0]["points"]);
  EXPECT_EQ(loadClassifierModel(folder_.file("model.yaml")).provenance.at("passes"), "whole");
}

TEST_F(TrainClassifier, ChoosesComponentsAndShowsWhy) {
  const std::string tile = folder_.write("tile.xyz_label_conf", oaklandText(street(1)));
  const std::string model = folder_.file("model.yaml");
  for (const std::string choice : {"held_out", "bic"}) {
    const std::string folder = folder_.file("by_" + choice);
    expectSuccess(runProgram("train_classifier", {tile, "--out", model, "--report", folder,
                                                  "--samples", "500", "--choose-by", choice}));
    const nlohmann::json report = readJson(folder + "/report.json");
    for (const nlohmann::json& one : report["classes"]) {
      EXPECT_EQ(one["chosen_by"], choice) << one["name"];
      EXPECT_GE(one["scores"].size(), 5u);
      // What was chosen may shrink when weights vanish, but never grow.
      EXPECT_LE(one["components"], 8);
    }
    EXPECT_EQ(fileBytes(folder + "/components.png").substr(1, 3), "PNG");
  }
}

TEST_F(TrainClassifier, LearnsAnyClassesWithTheirColors) {
  const std::string tile = folder_.write("tile.csv", csvText(street(1), "kind"));
  const std::string classes =
      folder_.write("classes.yaml",
                    "classes:\n  - {name: flat, labels: [1202, 1400], color: \"#010203\"}\n"
                    "  - {name: rest, labels: [1300, 1101, 1103]}\n");
  expectSuccess(
      train({tile, "--classes", classes, "--label-field", "kind", "--priors", "training"}));
  const ClassifierModel model = loadClassifierModel(folder_.file("model.yaml"));
  ASSERT_EQ(model.classes.size(), 2u);
  EXPECT_EQ(model.classes[0].name, "flat");
  EXPECT_EQ(model.classes[0].rgb, 0x010203u);
  EXPECT_NEAR(model.classes[0].prior, 31200.0 / (31200.0 + 8400.0 + 3000.0 + 3000.0), 0.01);
}

TEST_F(TrainClassifier, NamesWhatIsWrongWithLabels) {
  const std::string tile = folder_.write("tile.csv", csvText(street(1), "kind"));
  const std::string classes =
      folder_.write("classes.yaml", "classes: [{name: a, labels: [7]}, {name: b, labels: [8]}]\n");
  expectFailure(train({tile}), {tile, "'truth'", "--classes", "kind"});
  expectFailure(train({tile, "--classes", classes}), {tile, "'label'", "kind"});
  expectFailure(train({tile, "--classes", classes, "--label-field", "kind"}),
                {tile, "not one point"});
  expectFailure(train({tile, "--classes", folder_.file("no.yaml")}), {"no.yaml"});
  const std::string empty = folder_.write("empty.csv", "");
  expectFailure(train({empty, "--classes", classes}), {empty});
  const std::string one = folder_.write(
      "one.yaml", "classes: [{name: flat, labels: [1202]}, {name: none, labels: [8]}]\n");
  expectFailure(train({tile, "--classes", one, "--label-field", "kind"}), {"'none'", "0 samples"});
  EXPECT_EQ(folder_.list(), "classes.yaml empty.csv one.yaml tile.csv");
}

TEST_F(TrainClassifier, RefusesBadArguments) {
  expectFailure(train({drive("campus"), "--features", "cbrt_scatter,colour"}),
                {"--features", "colour"});
  expectFailure(train({folder_.file("none.bag")}), {"none.bag"});
  expectFailure(runProgram("train_classifier", {drive("campus")}), {"--out"});
  expectFailure(
      runProgram("train_classifier", {drive("campus"), "--out", "m.yaml", "--components", "0"}),
      {"--components", "0"});
  const std::string path = folder_.file("none/model.yaml");
  expectFailure(runProgram("train_classifier", {drive("campus"), "--out", path, "--samples", "500",
                                                "--components", "1"}),
                {path});
  expectFailure(train({drive("campus"), "--components", "many"}), {"--components", "many"});
  expectFailure(train({drive("campus"), "--passes", "half"}), {"'half'", "whole"});
  expectFailure(train({drive("campus"), "--report", "/proc/report"}), {"/proc/report"});
  EXPECT_EQ(folder_.list(), "");
}

TEST_F(TrainClassifier, Helps) {
  expectHelp("train_classifier",
             {"--out", "--report", "--classes", "--config", "--features", "--passes",
              "--components", "--samples", "--priors", "--seed", "truth"});
}

}  // namespace
}  // namespace ladar_perception::test
