// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

#include "hand_model.h"
#include "ladar_perception/classify/classifier_model.h"
#include "temporary_file.h"

namespace ladar_perception {
namespace {

using test::handModel;
using test::TemporaryFile;

/// A model that uses all there is: correlations, two components, priors, odd texts.
ClassifierModel richModel() {
  ClassifierModel model = handModel();
  model.classes[1].prior = 0.125;
  model.classes[2].mixture = {test::gaussian(0.3, {0.1, 1.0 / 3, -2e-7}, {0.1, 0.2, 0.3}),
                              test::gaussian(0.7, {1e-12, 2e5, 0.0}, {1e-3, 1e3, 1.0})};
  Eigen::MatrixXd& covariance = model.classes[2].mixture[0].covariance;
  covariance(0, 1) = covariance(1, 0) = 0.012345678901;
  model.unknown_log_likelihood = -12.5;
  model.features = parseFeatures({"spread_angle@3x15", "log_height@40", "cbrt_linear@6"});
  model.calibration.temperature = 1.0 / 3;
  model.calibration.offsets = {0.5, -1.0 / 3, 0.0};
  model.calibration.smoothing = {12.5, {8, 1, 5}, {0.75, 0.0, 2.5, 1e-3}, {-7.0, 0.125, 2e-6}};
  model.provenance = {{"source", "campus: seed 7, \"noisy\"\nsecond line"}, {"points", "123"}};
  return model;
}

std::string replaced(const std::string& text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) ADD_FAILURE() << "'" << from << "' is not in the model";
  return std::string(text).replace(at, from.size(), to);
}

/// The text without a key of the top level and all that belongs to it.
std::string withoutKey(const std::string& text, const std::string& key) {
  std::string kept;
  bool skipping = false;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin) + 1;
    const std::string line = text.substr(begin, end - begin);
    if (line[0] != ' ') skipping = line.rfind(key + ":", 0) == 0;
    if (!skipping) kept += line;
    begin = end;
  }
  return kept;
}

/// What parsing complains about. Everything it throws must be a runtime_error about the file.
std::string parseError(const std::string& text) {
  try {
    parseClassifierModel(text, "m.yaml");
  } catch (const std::runtime_error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind("m.yaml:", 0), 0U) << message;
    return message;
  }
  ADD_FAILURE() << "no error for:\n" << text;
  return "";
}

void expectParseError(const std::string& from, const std::string& to,
                      std::initializer_list<const char*> parts) {
  const std::string error = parseError(replaced(formatClassifierModel(handModel()), from, to));
  for (const char* part : parts) {
    EXPECT_NE(error.find(part), std::string::npos) << "'" << part << "' is not in: " << error;
  }
  // "m.yaml:<line>: "
  EXPECT_TRUE(error.size() > 8 && std::isdigit(error[7]) != 0) << "no line in: " << error;
}

TEST(ClassifierModel, LabelsHaveNamesAndColours) {
  const ClassifierModel model = handModel();
  EXPECT_EQ(model.labelName(0), "unknown");
  EXPECT_EQ(model.labelName(1), "surface");
  EXPECT_EQ(model.labelName(3), "linear");
  EXPECT_EQ(model.labelName(4), "unknown");
  EXPECT_EQ(model.labelColor(0), kUnknownColor);
  EXPECT_EQ(model.labelColor(2), 0x00ff00U);
  EXPECT_EQ(model.labelColor(200), kUnknownColor);
}

TEST(ClassifierModel, FileRoundTripGivesTheSameText) {
  for (const ClassifierModel& model : {handModel(), richModel()}) {
    const TemporaryFile file("");
    saveClassifierModel(model, file.path());
    const ClassifierModel loaded = loadClassifierModel(file.path());
    EXPECT_EQ(formatClassifierModel(loaded), formatClassifierModel(model));
  }
}

TEST(ClassifierModel, FileRoundTripKeepsEveryValue) {
  const ClassifierModel model = richModel();
  const ClassifierModel loaded = parseClassifierModel(formatClassifierModel(model), "m.yaml");
  EXPECT_EQ(loaded.features, model.features);
  EXPECT_EQ(loaded.voxel_size_m, 0.1);
  EXPECT_EQ(loaded.support_radius_voxels, 6);
  EXPECT_EQ(loaded.unknown_log_likelihood, -12.5);
  EXPECT_NEAR(loaded.calibration.temperature, 1.0 / 3, 1e-9);
  ASSERT_EQ(loaded.calibration.offsets.size(), 3U);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(loaded.calibration.offsets[c], model.calibration.offsets[c], 1e-9);
  }
  const Calibration::Smoothing& smoothing = loaded.calibration.smoothing;
  EXPECT_EQ(smoothing.temperature, 12.5);
  EXPECT_EQ(smoothing.radii_voxels, (std::vector<int>{8, 1, 5}));
  EXPECT_EQ(smoothing.exponents, (std::vector<double>{0.75, 0.0, 2.5, 1e-3}));
  EXPECT_EQ(smoothing.offsets, (std::vector<double>{-7.0, 0.125, 2e-6}));
  EXPECT_EQ(loaded.provenance, model.provenance);
  ASSERT_EQ(loaded.classes.size(), model.classes.size());
  for (std::size_t c = 0; c < model.classes.size(); ++c) {
    EXPECT_EQ(loaded.classes[c].name, model.classes[c].name);
    EXPECT_EQ(loaded.classes[c].rgb, model.classes[c].rgb);
    EXPECT_EQ(loaded.classes[c].prior, model.classes[c].prior);
    ASSERT_EQ(loaded.classes[c].mixture.size(), model.classes[c].mixture.size());
    for (std::size_t i = 0; i < model.classes[c].mixture.size(); ++i) {
      const GaussianComponent& a = loaded.classes[c].mixture[i];
      const GaussianComponent& b = model.classes[c].mixture[i];
      EXPECT_NEAR(a.weight, b.weight, 1e-9);
      EXPECT_TRUE(a.mean.isApprox(b.mean, 1e-8));
      EXPECT_TRUE(a.covariance.isApprox(b.covariance, 1e-8));
    }
  }
}

TEST(ClassifierModel, NoThresholdAndNoProvenanceRoundTrip) {
  ClassifierModel model = handModel();
  model.provenance.clear();
  EXPECT_TRUE(std::isinf(model.unknown_log_likelihood));
  const ClassifierModel loaded = parseClassifierModel(formatClassifierModel(model), "m.yaml");
  EXPECT_EQ(loaded.unknown_log_likelihood, model.unknown_log_likelihood);
  EXPECT_TRUE(loaded.provenance.empty());
}

TEST(ClassifierModel, EveryMissingKeyIsNamed) {
  for (const char* key : {"format", "voxel_size_m", "support_radius_voxels", "features",
                          "unknown_log_likelihood", "classes"}) {
    const std::string text = withoutKey(formatClassifierModel(handModel()), key);
    const std::string error = parseError(text);
    EXPECT_NE(error.find("'" + std::string(key) + "' is missing"), std::string::npos) << error;
  }
  expectParseError("    prior: 1\n", "", {"'prior' is missing"});
  expectParseError("    color: [255, 0, 0]\n", "", {"'color' is missing"});
  expectParseError("- weight: 1\n        mean: [0.06, 0.51, 0.26]\n", "- weight: 1\n",
                   {"'mean' is missing"});
}

TEST(ClassifierModel, UnknownKeysAreNamedWithTheirLine) {
  expectParseError("voxel_size_m:", "colour: 3\nvoxel_size_m:", {"unknown key 'colour'", ":4:"});
  const std::string text = formatClassifierModel(handModel());
  const std::size_t prior = text.find("    prior:");
  const auto line = 1 + std::count(text.begin(), text.begin() + prior, '\n');
  expectParseError("    prior: 1", "    priors: 1",
                   {"unknown key 'priors'", (":" + std::to_string(line) + ":").c_str()});
  expectParseError("- weight: 1", "- wait: 1", {"unknown key 'wait'"});
  expectParseError("voxel_size_m:", "? [a, b]\n: 3\nvoxel_size_m:", {"key"});
}

TEST(ClassifierModel, WrongTypesSayWhatIsExpected) {
  expectParseError("voxel_size_m: 0.1", "voxel_size_m: big", {"'voxel_size_m' must be a number"});
  expectParseError("voxel_size_m: 0.1", "voxel_size_m: [1]", {"'voxel_size_m'", "a number"});
  expectParseError("voxel_size_m: 0.1", "voxel_size_m: -0.1", {"voxel_size_m", "> 0"});
  expectParseError("support_radius_voxels: 6", "support_radius_voxels: 6.5",
                   {"'support_radius_voxels' must be an integer"});
  expectParseError("unknown_log_likelihood: -.inf", "unknown_log_likelihood: none",
                   {"'unknown_log_likelihood' must be a number"});
  expectParseError("name: \"surface\"", "name: [surface]", {"'name' must be a name"});
  expectParseError("[255, 0, 0]", "red", {"'color' must be three integers"});
  expectParseError("[255, 0, 0]", "[255, 0]", {"'color' must be three integers"});
  expectParseError("[255, 0, 0]", "[256, 0, 0]", {"0 to 255"});
  expectParseError("prior: 1", "prior: 0", {"'prior' must be positive"});
  expectParseError("prior: 1", "prior: .nan", {"'prior' must be positive"});
  expectParseError("[0.06, 0.51, 0.26]", "[0.06, x, 0.26]", {"'mean' must be a list of numbers"});
  expectParseError("features:\n", "features: 3\nx:\n", {"x"});
  expectParseError("  \"source\": \"made by hand for tests\"", "  - text", {"'provenance'"});
}

TEST(ClassifierModel, FeaturesAreWrittenWithTheirSupports) {
  const std::string text = formatClassifierModel(richModel());
  EXPECT_NE(text.find("features:\n  - spread_angle@3x15\n  - log_height@40\n  - cbrt_linear@6\n"),
            std::string::npos)
      << text;
  expectParseError("- cbrt_scatter", "- cbrt_scatter@0", {"'cbrt_scatter@0'", "from 1", ":8:"});
  expectParseError("- cbrt_scatter", "- cbrt_scatter@30", {"too large"});
  expectParseError("- cbrt_scatter", "- log_height", {"'log_height'", "needs '@'"});
}

TEST(ClassifierModel, FilesFromBeforeCalibrationAreOnesThatNeverHadIt) {
  ClassifierModel model = richModel();
  const std::string text = withoutKey(formatClassifierModel(model), "calibration");
  EXPECT_EQ(text.find("temperature"), std::string::npos);
  const Calibration loaded = parseClassifierModel(text, "m.yaml").calibration;
  const Calibration none;
  EXPECT_EQ(loaded.temperature, 1.0);
  EXPECT_TRUE(loaded.offsets.empty());
  EXPECT_EQ(loaded.smoothing.temperature, none.smoothing.temperature);
  EXPECT_EQ(loaded.smoothing.radii_voxels, none.smoothing.radii_voxels);
  EXPECT_EQ(loaded.smoothing.exponents, none.smoothing.exponents);
  EXPECT_TRUE(loaded.smoothing.offsets.empty());
}

TEST(ClassifierModel, OffsetsThatAreNotGivenAreWrittenAsZeros) {
  const ClassifierModel loaded =
      parseClassifierModel(formatClassifierModel(handModel()), "m.yaml");
  EXPECT_EQ(loaded.calibration.offsets, std::vector<double>(3, 0.0));
  EXPECT_EQ(loaded.calibration.smoothing.offsets, std::vector<double>(3, 0.0));
}

// In the file of handModel calibration stands in line 11: temperature, offsets, smoothing, and of
// the latter temperature, radii_voxels, exponents and offsets follow, a line each.

TEST(ClassifierModel, TemperatureErrorsNameLineAndKey) {
  const std::string plain = "calibration:\n  temperature: ";
  const std::string smoothing = "smoothing:\n    temperature: ";
  expectParseError("  temperature: 1\n", "", {":12:", "'temperature' is missing"});
  expectParseError("    temperature: 2\n", "", {":15:", "'temperature' is missing"});
  expectParseError(plain + "1\n", plain + "hot\n", {":12:", "'temperature' must be a number"});
  for (const std::string value : {"0", "-1", ".nan", ".inf", "1e-60", "0.0009", "1001"}) {
    expectParseError(plain + "1\n", plain + value + "\n",
                     {":12:", "'temperature' must be 0.001 to 1000"});
    expectParseError(smoothing + "2\n", smoothing + value + "\n",
                     {":15:", "'temperature' must be 0.001 to 1000"});
  }
  expectParseError("calibration:\n", "calibration:\n  heat: 3\n",
                   {":12:", "unknown key 'heat'"});
}

TEST(ClassifierModel, SmoothingErrorsNameLineAndKey) {
  const std::string radii = "radii_voxels: [4, 12]\n";
  for (const std::string value : {"[0, 12]", "[4, 13]", "[-3]"}) {
    expectParseError(radii, "radii_voxels: " + value + "\n", {":16:", "radii must be 1 to 12"});
  }
  expectParseError(radii, "radii_voxels: []\n", {":16:", "expected a radius"});
  for (const std::string value : {"[2.5, 8]", "5", "[a]", "{a: 3}"}) {
    expectParseError(radii, "radii_voxels: " + value + "\n",
                     {":16:", "'radii_voxels' must be a list of integers"});
  }
  expectParseError("    " + radii, "", {":15:", "'radii_voxels' is missing"});
  const std::string exponents = "exponents: [0.2, 0.5, 1]\n";
  for (const std::string value :
       {"[]", "[0.2, 0.5]", "[1, 1, 1, 1]", "[0.2, .nan, 1]", "[0.2, .inf, 1]", "[0.2, 1e39, 1]"}) {
    expectParseError(exponents, "exponents: " + value + "\n",
                     {":17:", "'exponents' must be 3 numbers"});
  }
  // An exponent for the voxel's own and one for each radius.
  expectParseError(radii, "radii_voxels: [3, 8, 5]\n", {":17:", "'exponents' must be 4 numbers"});
  for (const std::string value : {"0.5", "[0.2, x, 1]"}) {
    expectParseError(exponents, "exponents: " + value + "\n",
                     {":17:", "'exponents' must be a list of numbers"});
  }
  expectParseError("    " + exponents, "", {":15:", "'exponents' is missing"});
  expectParseError(exponents, exponents + "    width: 3\n", {":18:", "unknown key 'width'"});
}

TEST(ClassifierModel, OffsetErrorsNameLineAndKey) {
  struct Place {
    std::string indent;
    const char* line;
    const char* line_of_map;
  };
  // After a temperature, and after exponents.
  for (const Place& place :
       {Place{"  temperature: 1\n  ", ":13:", ":12:"}, Place{"1]\n    ", ":18:", ":15:"}}) {
    const std::string offsets = place.indent + "offsets: ";
    for (const std::string value :
         {"[]", "[0, 0]", "[0, 0, 0, 0]", "[0, .inf, 0]", "[0, 0, .nan]", "[0, -1001, 0]"}) {
      expectParseError(offsets + "[0, 0, 0]", offsets + value,
                       {place.line, "'offsets' must be 3 numbers"});
    }
    expectParseError(offsets + "[0, 0, 0]", offsets + "[0, a, 0]",
                     {place.line, "'offsets' must be a list of numbers"});
    const std::string before = place.indent.substr(0, place.indent.find('\n') + 1);
    expectParseError(offsets + "[0, 0, 0]\n", before,
                     {place.line_of_map, "'offsets' is missing"});
  }
}

TEST(ClassifierModel, CalibrationMustBeAMap) {
  const std::string text = withoutKey(formatClassifierModel(handModel()), "calibration");
  const std::string alone = "\n  temperature: 1\n  offsets: [0, 0, 0]";
  for (const std::string& value :
       {std::string(), std::string(" 3"), std::string(" [1, 2]"), alone + "\n  smoothing: 3"}) {
    const std::string error = parseError(text + "calibration:" + value + "\n");
    EXPECT_NE(error.find("expected a map"), std::string::npos) << error;
  }
  const std::string error = parseError(text + "calibration:" + alone + "\n");
  EXPECT_NE(error.find("'smoothing' is missing"), std::string::npos) << error;
}

TEST(ClassifierModel, AThresholdThatIsNoNumberIsRefused) {
  expectParseError("unknown_log_likelihood: -.inf", "unknown_log_likelihood: .nan",
                   {"unknown_log_likelihood"});
}

TEST(ClassifierModel, MixturesMustBeMixtures) {
  expectParseError("[0.0225, 0, 0]", "[-0.0225, 0, 0]", {"'surface'", "positive definite"});
  expectParseError("[0.0225, 0, 0]", "[0.0225, 0.1, 0]", {"'surface'", "symmetric"});
  expectParseError("[0.0225, 0, 0]", "[0.0225, 0]", {"covariance must be 3 x 3"});
  expectParseError("          - [0.0225, 0, 0]\n", "", {"covariance must be 3 x 3"});
  expectParseError("[0.0225, 0, 0]", "[.nan, 0, 0]", {"'surface'", "finite"});
  expectParseError("[0.06, 0.51, 0.26]", "[0.06, 0.51]", {"'surface'", "mean must have 3"});
  expectParseError("weight: 1", "weight: 0.5", {"'surface'", "weights sum to 0.5"});
  expectParseError("weight: 1", "weight: -1", {"'surface'", "weight must be positive"});
}

TEST(ClassifierModel, ClassesAndFeaturesMustFit) {
  expectParseError("\"scatter\"", "\"surface\"", {"'surface' is taken"});
  expectParseError("\"scatter\"", "\"unknown\"", {"'unknown' is taken"});
  expectParseError("- cbrt_scatter", "- redness", {"'redness'", "cbrt_linear"});
  expectParseError("  - cbrt_scatter\n", "", {"must be 2 x 2"});
  expectParseError("classifier/1", "classifier/2", {"classifier/2", "classifier/1", ":1:"});
  ClassifierModel model = handModel();
  model.classes.resize(1);
  EXPECT_NE(parseError(formatClassifierModel(model)).find("2 to 16"), std::string::npos);
  model.classes.resize(17, model.classes[0]);
  EXPECT_NE(parseError(formatClassifierModel(model)).find("2 to 16"), std::string::npos);
}

TEST(ClassifierModel, AFileCutOffAnywhereIsRefused) {
  const std::string text = formatClassifierModel(richModel());
  ASSERT_EQ(text.back(), '\n');
  for (std::size_t size = 0; size < text.size(); ++size) {
    try {
      parseClassifierModel(text.substr(0, size), "m.yaml");
      ADD_FAILURE() << "the first " << size << " bytes are taken for a model";
    } catch (const std::runtime_error& error) {
      ASSERT_EQ(std::string(error.what()).rfind("m.yaml:", 0), 0U) << error.what() << "\n" << size;
    }
  }
}

TEST(ClassifierModel, NoYamlNoMapNoFile) {
  parseError("");
  parseError("# nothing\n");
  parseError("- 1\n- 2\n");
  EXPECT_NE(parseError("format: [1\nx: {\n").find("YAML"), std::string::npos);
  for (const std::string path : {"/nowhere/model.yaml", "/tmp"}) {
    try {
      loadClassifierModel(path);
      ADD_FAILURE() << path;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).rfind(path + ":", 0), 0U) << error.what();
    }
  }
  EXPECT_THROW(saveClassifierModel(handModel(), "/nowhere/model.yaml"), std::runtime_error);
}

TEST(ModelMisfit, NamesWhatDiffers) {
  const ClassifierModel model = handModel();
  EXPECT_EQ(modelMisfit(model, 0.1, 6), "");
  EXPECT_EQ(modelMisfit(model, 0.1 + 1e-9, 6), "");
  EXPECT_EQ(modelMisfit(model, 0.2, 6),
            "it was learned at voxel_size_m 0.1, the configuration has 0.2");
  EXPECT_EQ(modelMisfit(model, 0.1, 3),
            "it was learned at support_radius_voxels 6, the configuration has 3");
  const std::string both = modelMisfit(model, 0.05, 5);
  EXPECT_NE(both.find("0.05; it was learned at support_radius_voxels 6"), std::string::npos)
      << both;
}

}  // namespace
}  // namespace ladar_perception
