// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/classify/classifier_model.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

namespace ladar_perception {
namespace {

constexpr const char* kFormat = "ladar_perception/classifier/1";

/// Reads nodes of one file and says where and what when they are not as expected.
class ModelReader {
 public:
  explicit ModelReader(std::string path) : path_(std::move(path)) {}

  [[noreturn]] void fail(const YAML::Node& node, const std::string& message) const {
    const int line = node.IsDefined() ? node.Mark().line + 1 : 0;
    throw std::runtime_error(path_ + (line > 0 ? ":" + std::to_string(line) : "") + ": " + message);
  }

  void expectKeys(const YAML::Node& map, const std::set<std::string>& keys) const {
    if (!map.IsMap()) fail(map, "expected a map");
    for (const auto& entry : map) {
      if (!entry.first.IsScalar()) fail(entry.first, "expected a key, got a list or a map");
      const std::string& key = entry.first.Scalar();
      if (keys.count(key) == 0) fail(entry.first, "unknown key '" + key + "'");
    }
  }

  YAML::Node child(const YAML::Node& map, const std::string& key) const {
    const YAML::Node node = map[key];
    if (!node.IsDefined()) fail(map, "key '" + key + "' is missing");
    return node;
  }

  template <typename T>
  T value(const YAML::Node& node, const std::string& what) const {
    try {
      return node.as<T>();
    } catch (const YAML::Exception&) {
      fail(node, what);
    }
  }

  template <typename T>
  T value(const YAML::Node& map, const std::string& key, const std::string& type) const {
    return value<T>(child(map, key), "'" + key + "' must be " + type);
  }

 private:
  std::string path_;
};

GaussianComponent readComponent(const ModelReader& reader, const YAML::Node& node, int features) {
  reader.expectKeys(node, {"weight", "mean", "covariance"});
  GaussianComponent component;
  component.weight = reader.value<double>(node, "weight", "a number");
  const auto mean = reader.value<std::vector<double>>(node, "mean", "a list of numbers");
  component.mean = Eigen::Map<const Eigen::VectorXd>(mean.data(), mean.size());
  const auto rows = reader.value<std::vector<std::vector<double>>>(node, "covariance",
                                                                   "a list of lists of numbers");
  component.covariance.resize(features, features);
  bool square = rows.size() == static_cast<std::size_t>(features);
  for (std::size_t i = 0; square && i < rows.size(); ++i) {
    square = rows[i].size() == rows.size();
    for (std::size_t j = 0; square && j < rows.size(); ++j) component.covariance(i, j) = rows[i][j];
  }
  if (!square) {
    const std::string n = std::to_string(features);
    reader.fail(node["covariance"], "covariance must be " + n + " x " + n + " numbers");
  }
  return component;
}

uint32_t readColor(const ModelReader& reader, const YAML::Node& node) {
  const auto rgb = reader.value<std::vector<int>>(node, "color", "three integers [r, g, b]");
  if (rgb.size() != 3) reader.fail(node["color"], "'color' must be three integers [r, g, b]");
  uint32_t packed = 0;
  for (const int channel : rgb) {
    if (channel < 0 || channel > 255) reader.fail(node["color"], "colours run from 0 to 255");
    packed = packed << 8 | static_cast<uint32_t>(channel);
  }
  return packed;
}

ModelClass readClass(const ModelReader& reader, const YAML::Node& node, int features) {
  reader.expectKeys(node, {"name", "color", "prior", "components"});
  ModelClass result;
  result.name = reader.value<std::string>(node, "name", "a name");
  result.rgb = readColor(reader, node);
  result.prior = reader.value<double>(node, "prior", "a number");
  if (!(result.prior > 0.0) || !std::isfinite(result.prior)) {
    reader.fail(node["prior"], "'prior' must be positive");
  }
  const YAML::Node components = reader.child(node, "components");
  if (!components.IsSequence()) reader.fail(components, "'components' must be a list");
  for (const YAML::Node& component : components) {
    result.mixture.push_back(readComponent(reader, component, features));
  }
  const std::string problem = GaussianMixture::error(result.mixture, features);
  if (!problem.empty()) reader.fail(components, "class '" + result.name + "': " + problem);
  return result;
}

void readFeatures(const ModelReader& reader, const YAML::Node& root, ClassifierModel* model) {
  const auto names = reader.value<std::vector<std::string>>(root, "features", "a list of names");
  if (names.empty()) reader.fail(root["features"], "'features' is empty");
  try {
    for (const std::string& name : names) model->features.push_back(parseFeature(name));
  } catch (const std::invalid_argument& error) {
    reader.fail(root["features"], error.what());
  }
}

// Limits are far beyond what calibration ever finds, and yet no float32 overflows.
double readExponent(const ModelReader& reader, const YAML::Node& map, const std::string& key) {
  const auto value = reader.value<double>(map, key, "a number");
  if (!(value >= 1e-3 && value <= 1e3)) {
    reader.fail(map[key], "'" + key + "' must be 0.001 to 1000");
  }
  return value;
}

std::vector<double> readNumbers(const ModelReader& reader, const YAML::Node& map,
                                const std::string& key, std::size_t size) {
  const auto numbers = reader.value<std::vector<double>>(map, key, "a list of numbers");
  bool good = numbers.size() == size;
  for (const double number : numbers) good = good && std::abs(number) <= 1e3;
  if (!good) {
    reader.fail(map[key],
                "'" + key + "' must be " + std::to_string(size) + " numbers from -1000 to 1000");
  }
  return numbers;
}

void readSmoothing(const ModelReader& reader, const YAML::Node& node, std::size_t classes,
                   Calibration::Smoothing* smoothing) {
  reader.expectKeys(node, {"temperature", "radii_voxels", "exponents", "offsets"});
  smoothing->temperature = readExponent(reader, node, "temperature");
  smoothing->radii_voxels =
      reader.value<std::vector<int>>(node, "radii_voxels", "a list of integers");
  for (const int radius : smoothing->radii_voxels) {
    if (radius >= 1 && radius <= Calibration::kMaxSmoothingRadius) continue;
    reader.fail(node["radii_voxels"],
                "radii must be 1 to " + std::to_string(Calibration::kMaxSmoothingRadius));
  }
  if (smoothing->radii_voxels.empty()) reader.fail(node["radii_voxels"], "expected a radius");
  smoothing->exponents =
      readNumbers(reader, node, "exponents", 1 + smoothing->radii_voxels.size());
  smoothing->offsets = readNumbers(reader, node, "offsets", classes);
}

// Models that were never calibrated have none.
void readCalibration(const ModelReader& reader, const YAML::Node& node, std::size_t classes,
                     Calibration* calibration) {
  if (!node.IsDefined()) return;
  reader.expectKeys(node, {"temperature", "offsets", "smoothing"});
  calibration->temperature = readExponent(reader, node, "temperature");
  calibration->offsets = readNumbers(reader, node, "offsets", classes);
  readSmoothing(reader, reader.child(node, "smoothing"), classes, &calibration->smoothing);
}

void readClasses(const ModelReader& reader, const YAML::Node& root, ClassifierModel* model) {
  const YAML::Node classes = reader.child(root, "classes");
  if (!classes.IsSequence() || classes.size() < 2 || classes.size() > kMaxClasses) {
    reader.fail(classes, "'classes' must list 2 to " + std::to_string(kMaxClasses) + " classes");
  }
  std::set<std::string> names = {"unknown"};
  for (const YAML::Node& node : classes) {
    model->classes.push_back(readClass(reader, node, static_cast<int>(model->features.size())));
    if (!names.insert(model->classes.back().name).second) {
      reader.fail(node, "class name '" + model->classes.back().name + "' is taken");
    }
  }
}

ClassifierModel readModel(const ModelReader& reader, const YAML::Node& root) {
  reader.expectKeys(
      root, {"format", "provenance", "voxel_size_m", "support_radius_voxels", "support_kernel",
             "features", "calibration", "unknown_log_likelihood", "classes"});
  const auto format = reader.value<std::string>(root, "format", "a name");
  if (format != kFormat) {
    reader.fail(root["format"], "format is '" + format + "', expected '" + kFormat + "'");
  }
  ClassifierModel model;
  model.voxel_size_m = reader.value<double>(root, "voxel_size_m", "a number");
  if (!(model.voxel_size_m > 0.0)) reader.fail(root["voxel_size_m"], "voxel_size_m must be > 0");
  model.support_radius_voxels = reader.value<int>(root, "support_radius_voxels", "an integer");
  // Models from before there were kernels have none.
  if (root["support_kernel"].IsDefined()) {
    model.support_kernel = reader.value<std::string>(root, "support_kernel", "a name");
  }
  model.unknown_log_likelihood = reader.value<double>(root, "unknown_log_likelihood", "a number");
  if (std::isnan(model.unknown_log_likelihood)) {
    reader.fail(root["unknown_log_likelihood"], "unknown_log_likelihood must not be NaN");
  }
  const YAML::Node provenance = root["provenance"];
  if (provenance.IsDefined() && !provenance.IsNull()) {
    model.provenance = reader.value<std::map<std::string, std::string>>(
        provenance, "'provenance' must map names to texts");
  }
  readFeatures(reader, root, &model);
  readClasses(reader, root, &model);
  readCalibration(reader, root["calibration"], model.classes.size(), &model.calibration);
  return model;
}

// 9 significant digits give back the same float32, and the file the same bytes on every machine.
std::string number(double value) {
  if (std::isinf(value)) return value < 0 ? "-.inf" : ".inf";
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

template <typename Vector>
std::string numberList(const Vector& values) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) text += (i ? ", " : "") + number(values[i]);
  return text + "]";
}

std::string quoted(const std::string& text) {
  YAML::Emitter out;
  out << YAML::DoubleQuoted << text;
  return out.c_str();
}

void writeClass(const ModelClass& model_class, std::ostream& out) {
  out << "  - name: " << quoted(model_class.name) << "\n    color: ["
      << (model_class.rgb >> 16 & 255) << ", " << (model_class.rgb >> 8 & 255) << ", "
      << (model_class.rgb & 255) << "]\n    prior: " << number(model_class.prior)
      << "\n    components:\n";
  for (const GaussianComponent& component : model_class.mixture) {
    out << "      - weight: " << number(component.weight)
        << "\n        mean: " << numberList(component.mean) << "\n        covariance:\n";
    for (Eigen::Index i = 0; i < component.covariance.rows(); ++i) {
      const Eigen::VectorXd row = component.covariance.row(i);
      out << "          - " << numberList(row) << "\n";
    }
  }
}

void writeCalibration(const ClassifierModel& model, std::ostream& out) {
  const auto list = [](std::vector<double> numbers, std::size_t size) {
    numbers.resize(size, 0.0);
    return numberList(Eigen::Map<const Eigen::VectorXd>(numbers.data(), numbers.size()));
  };
  const std::size_t classes = model.classes.size();
  const Calibration::Smoothing& smoothing = model.calibration.smoothing;
  std::string radii;
  for (const int radius : smoothing.radii_voxels) {
    radii += (radii.empty() ? "" : ", ") + std::to_string(radius);
  }
  out << "calibration:\n  temperature: " << number(model.calibration.temperature)
      << "\n  offsets: " << list(model.calibration.offsets, classes)
      << "\n  smoothing:\n    temperature: " << number(smoothing.temperature)
      << "\n    radii_voxels: [" << radii
      << "]\n    exponents: " << list(smoothing.exponents, 1 + smoothing.radii_voxels.size())
      << "\n    offsets: " << list(smoothing.offsets, classes) << "\n";
}

}  // namespace

std::string ClassifierModel::labelName(uint8_t label) const {
  return label >= 1 && label <= classes.size() ? classes[label - 1].name : "unknown";
}

uint32_t ClassifierModel::labelColor(uint8_t label) const {
  return label >= 1 && label <= classes.size() ? classes[label - 1].rgb : kUnknownColor;
}

ClassifierModel parseClassifierModel(const std::string& text, const std::string& path) {
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(path + ":" + std::to_string(error.mark.line + 1) +
                             ": no YAML: " + error.msg);
  }
  if (!root.IsMap()) throw std::runtime_error(path + ": is empty or no map, expected a model");
  // A file cut off within its last number would still be YAML.
  if (text.back() != '\n') {
    throw std::runtime_error(path + ": the last line does not end, is the file complete?");
  }
  return readModel(ModelReader(path), root);
}

ClassifierModel loadClassifierModel(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": model file cannot be opened");
  std::ostringstream text;
  text << file.rdbuf();
  return parseClassifierModel(text.str(), path);
}

std::string formatClassifierModel(const ClassifierModel& model) {
  std::ostringstream out;
  out << "format: " << kFormat << "\nprovenance:\n";
  for (const auto& entry : model.provenance) {
    out << "  " << quoted(entry.first) << ": " << quoted(entry.second) << "\n";
  }
  out << "voxel_size_m: " << number(model.voxel_size_m)
      << "\nsupport_radius_voxels: " << model.support_radius_voxels
      << "\nsupport_kernel: " << model.support_kernel << "\nfeatures:\n";
  for (const Feature& feature : model.features) out << "  - " << featureName(feature) << "\n";
  writeCalibration(model, out);
  out << "classes:\n";
  for (const ModelClass& model_class : model.classes) writeClass(model_class, out);
  // Last, because it is required: a file cut off between two classes lacks it.
  out << "unknown_log_likelihood: " << number(model.unknown_log_likelihood) << "\n";
  return out.str();
}

void saveClassifierModel(const ClassifierModel& model, const std::string& path) {
  std::ofstream file(path);
  file << formatClassifierModel(model);
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

std::string modelMisfit(const ClassifierModel& model, double voxel_size_m,
                        int support_radius_voxels, const std::string& support_kernel) {
  std::string misfit;
  const auto differs = [&](const char* name, const std::string& learned, const std::string& set) {
    misfit += std::string(misfit.empty() ? "" : "; ") + "it was learned at " + name + " " +
              learned + ", the configuration has " + set;
  };
  if (std::abs(model.voxel_size_m - voxel_size_m) > 1e-6 * voxel_size_m) {
    differs("voxel_size_m", number(model.voxel_size_m), number(voxel_size_m));
  }
  if (model.support_radius_voxels != support_radius_voxels) {
    differs("support_radius_voxels", std::to_string(model.support_radius_voxels),
            std::to_string(support_radius_voxels));
  }
  if (model.support_kernel != support_kernel) {
    differs("support_kernel", model.support_kernel, support_kernel);
  }
  return misfit;
}

}  // namespace ladar_perception
