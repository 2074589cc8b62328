// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <memory>

#include "ladar_perception/classify/classifier_model.h"
#include "program_bag.h"
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
  EXPECT_EQ(modelMisfit(model, 0.1, 4), "");
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
  expectSuccess(train({drive("campus")}, "a.yaml"));
  expectSuccess(train({drive("campus")}, "b.yaml"));
  expectSuccess(train({drive("campus"), "--seed", "2"}, "c.yaml"));
  EXPECT_EQ(fileBytes(folder_.file("a.yaml")), fileBytes(folder_.file("b.yaml")));
  EXPECT_NE(fileBytes(folder_.file("a.yaml")), fileBytes(folder_.file("c.yaml")));
}

TEST_F(TrainClassifier, UsesFeaturesAndConfiguration) {
  const std::string config =
      folder_.write("coarse.yaml", "voxel_size_m: 0.2\nsupport_radius_voxels: 2\n");
  expectSuccess(train({drive("campus"), "--config", config, "--features",
                       "cbrt_scatter,cbrt_surface,cbrt_linear"}));
  const ClassifierModel model = loadClassifierModel(folder_.file("model.yaml"));
  EXPECT_EQ(model.features.size(), 3u);
  EXPECT_EQ(modelMisfit(model, 0.2, 2), "");
  EXPECT_NE(modelMisfit(model, 0.1, 4), "");
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
      drive("campus"), folder_.file("surface.bag"), [](const auto& message, rosbag::Bag* to) {
        if (message.getTopic() != "/points") return writeAsItIs(message, to);
        auto cloud = *message.template instantiate<sensor_msgs::PointCloud2>();
        const uint32_t offset = findField(cloud, "truth")->offset;
        for (std::size_t i = offset; i < cloud.data.size(); i += cloud.point_step) {
          if (cloud.data[i] == 3) cloud.data[i] = 0;
        }
        to->write(message.getTopic(), message.getTime(), cloud);
      });
  expectFailure(train({surface}), {"linear", "0 samples"});
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
  EXPECT_EQ(folder_.list(), "");
}

TEST_F(TrainClassifier, Helps) {
  expectHelp("train_classifier",
             {"--out", "--config", "--features", "--components", "--samples", "--seed", "truth"});
}

}  // namespace
}  // namespace ladar_perception::test
