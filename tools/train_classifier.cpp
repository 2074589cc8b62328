// SPDX-License-Identifier: BSD-3-Clause
// Learns the mixtures of surface, scatter and linear from bags whose points carry a truth field.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <armadillo>
#include <array>
#include <cstdio>
#include <iostream>
#include <random>

#include "cloud_message.h"
#include "ladar_perception/cloud/point_reader.h"
#include "ladar_perception/util/progress.h"
#include "scan_bag_reader.h"
#include "terrain_processor.h"

namespace ladar_perception {
namespace {

struct Options {
  std::vector<std::string> inputs;
  std::string output;
  std::string config;
  std::vector<std::string> features = {"cbrt_scatter", "cbrt_surface", "cbrt_linear",
                                       "normal_angle", "tangent_angle"};
  int components = 5;
  int samples = 20000;
  unsigned seed = 1;
};

struct ClassSpec {
  const char* name;
  uint32_t rgb;
};
// In the order of the truth values 1, 2, 3.
constexpr std::array<ClassSpec, 3> kClasses = {
    {{"surface", 0xdc2828}, {"scatter", 0x28b43c}, {"linear", 0x3264ff}}};

// Added to every component's variance, as a share of the feature's variance over all samples:
// components narrower than this follow the training scenes, not the class.
constexpr double kCovarianceFloor = 0.1;
// Volumes less likely than all but this share of the training samples, by this much, are unknown.
constexpr double kUnknownShare = 0.001;
constexpr double kUnknownMargin = 10.0;

std::vector<Feature> featuresOf(const Options& options) {
  try {
    return parseFeatures(options.features);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(std::string("--features: ") + error.what());
  }
}

/// A uniform sample of bounded size from a stream of feature vectors.
class Reservoir {
 public:
  Reservoir(std::size_t capacity, unsigned seed) : capacity_(capacity), random_(seed) {}

  template <typename MakeSample>
  void offer(MakeSample&& make) {
    ++offered_;
    if (samples_.size() < capacity_) {
      samples_.push_back(make());
      return;
    }
    const uint64_t slot = random_() % offered_;
    if (slot < capacity_) samples_[slot] = make();
  }
  uint64_t offered() const { return offered_; }
  const std::vector<std::vector<double>>& samples() const { return samples_; }

 private:
  std::size_t capacity_;
  uint64_t offered_ = 0;
  std::mt19937_64 random_;
  std::vector<std::vector<double>> samples_;
};

/// The model's frame: everything but the mixtures, which are placeholders.
ClassifierModel emptyModel(const TerrainNodeConfig& config, const std::vector<Feature>& features) {
  ClassifierModel model;
  model.features = features;
  model.voxel_size_m = config.pipeline.voxel_size_m;
  model.support_radius_voxels = config.pipeline.support_radius_voxels;
  model.support_kernel = config.pipeline.support_kernel;
  const auto n = static_cast<Eigen::Index>(features.size());
  for (const ClassSpec& spec : kClasses) {
    model.classes.push_back({spec.name,
                             spec.rgb,
                             1.0,
                             {{1.0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Identity(n, n)}}});
  }
  return model;
}

void sampleScan(const TerrainPipeline& pipeline, const std::vector<double>& truth,
                std::vector<Reservoir>* reservoirs) {
  const auto least = static_cast<uint32_t>(pipeline.config().min_support_points);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!(truth[i] >= 1.0 && truth[i] <= kClasses.size())) continue;
    const CellId cell = pipeline.pointCells()[i];
    if (cell == kNoCell) continue;
    const std::size_t slot = pipeline.map().slotOf(cell);
    const SaliencyF& saliency = pipeline.saliency(slot);
    if (!saliency.defined || saliency.points < least) continue;
    (*reservoirs)[static_cast<std::size_t>(truth[i]) - 1].offer([&] {
      const float* features = pipeline.features(slot);
      return std::vector<double>(features, features + pipeline.model().features.size());
    });
  }
}

void sampleBag(const std::string& path, const TerrainNodeConfig& config,
               const ClassifierModel& model, std::vector<Reservoir>* reservoirs) {
  tf2::BufferCore buffer(ros::Duration(30.0));
  ScanBagReader reader(path, "", &buffer);
  TerrainProcessor processor(config, model, &buffer);
  processor.keepFeatures(true);
  Progress progress("scans of " + path, reader.scanCount());
  ScanBagReader::Scan scan;
  bool any = false;
  std::string first_drop;
  while (reader.next(&scan)) {
    const ros::Time deadline = scan.recorded + ros::Duration(config.tf_timeout_s);
    const auto outcome = processor.process(*scan.cloud, [&](const std::function<bool()>& ready) {
      return reader.playUntil(ready, deadline);
    });
    progress.advance();
    if (outcome.drop) {
      if (first_drop.empty()) first_drop = scanDropName(*outcome.drop) + (": " + outcome.detail);
      continue;
    }
    any = true;
    const CloudLayout& layout = processor.scanLayout();
    const Field* truth = layout.find("truth");
    if (truth == nullptr) {
      throw std::runtime_error(
          path + ": its clouds have no field 'truth'; fields present: " + layout.describeFields());
    }
    std::vector<double> values;
    readScalars({layout, scan.cloud->data.data(), scan.cloud->data.size()}, *truth, &values);
    sampleScan(processor.pipeline(), values, reservoirs);
  }
  progress.finish();
  if (!any) {
    throw std::runtime_error(path + ": not one scan could be used" +
                             (first_drop.empty() ? "" : "; the first: " + first_drop));
  }
}

arma::mat asMatrix(const Reservoir& reservoir, std::size_t features) {
  arma::mat data(features, reservoir.samples().size());
  for (std::size_t i = 0; i < data.n_cols; ++i) {
    for (std::size_t f = 0; f < features; ++f) data(f, i) = reservoir.samples()[i][f];
  }
  return data;
}

std::vector<GaussianComponent> learnMixture(const arma::mat& data, const arma::vec& floor,
                                            int components, const std::string& name) {
  arma::gmm_full mixture;
  if (!mixture.learn(data, components, arma::maha_dist, arma::static_spread, 20, 100, 1e-10,
                     false)) {
    throw std::runtime_error("class '" + name + "': expectation maximisation failed on " +
                             std::to_string(data.n_cols) + " samples");
  }
  std::vector<GaussianComponent> result;
  const auto n = static_cast<Eigen::Index>(data.n_rows);
  for (arma::uword c = 0; c < mixture.n_gaus(); ++c) {
    if (!(mixture.hefts(c) > 1e-4)) continue;
    const arma::mat covariance = mixture.fcovs.slice(c) + arma::diagmat(floor);
    GaussianComponent component;
    component.weight = mixture.hefts(c);
    component.mean = Eigen::Map<const Eigen::VectorXd>(mixture.means.colptr(c), n);
    component.covariance = Eigen::Map<const Eigen::MatrixXd>(covariance.memptr(), n, n);
    result.push_back(component);
  }
  double sum = 0.0;
  for (const GaussianComponent& component : result) sum += component.weight;
  for (GaussianComponent& component : result) component.weight /= sum;
  return result;
}

/// Greatest class log-likelihood of a sample under the learned mixtures.
double bestLogLikelihood(const std::vector<GaussianMixture>& mixtures,
                         const std::vector<double>& sample) {
  FeatureBlock block(static_cast<int>(sample.size()));
  for (std::size_t f = 0; f < sample.size(); ++f) {
    std::fill_n(block.row(static_cast<int>(f)), FeatureBlock::kSize, static_cast<float>(sample[f]));
  }
  double best = -std::numeric_limits<double>::infinity();
  std::array<float, FeatureBlock::kSize> log_likelihood{};
  for (const GaussianMixture& mixture : mixtures) {
    mixture.logLikelihood(block, log_likelihood.data());
    best = std::max(best, static_cast<double>(log_likelihood[0]));
  }
  return best;
}

double unknownThreshold(const ClassifierModel& model, const std::vector<Reservoir>& reservoirs) {
  std::vector<GaussianMixture> mixtures;
  for (const ModelClass& model_class : model.classes) mixtures.emplace_back(model_class.mixture);
  std::vector<double> likelihoods;
  for (const Reservoir& reservoir : reservoirs) {
    for (const auto& sample : reservoir.samples()) {
      likelihoods.push_back(bestLogLikelihood(mixtures, sample));
    }
  }
  std::sort(likelihoods.begin(), likelihoods.end());
  const auto index =
      static_cast<std::size_t>(kUnknownShare * static_cast<double>(likelihoods.size()));
  return likelihoods[index] - kUnknownMargin;
}

std::string baseName(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

void train(const Options& options) {
  const TerrainNodeConfig config = readTerrainNodeConfigFile(options.config);
  ClassifierModel model = emptyModel(config, featuresOf(options));
  std::vector<Reservoir> reservoirs;
  for (std::size_t c = 0; c < kClasses.size(); ++c) {
    reservoirs.emplace_back(options.samples, options.seed + static_cast<unsigned>(c));
  }
  for (const std::string& input : options.inputs) sampleBag(input, config, model, &reservoirs);

  const std::size_t features = model.features.size();
  std::vector<arma::mat> data;
  arma::mat all(features, 0);
  for (std::size_t c = 0; c < kClasses.size(); ++c) {
    data.push_back(asMatrix(reservoirs[c], features));
    const std::size_t needed = 10 * static_cast<std::size_t>(options.components);
    if (data[c].n_cols < needed) {
      throw std::runtime_error(std::string("class '") + kClasses[c].name + "' has " +
                               std::to_string(data[c].n_cols) + " samples, expected at least " +
                               std::to_string(needed));
    }
    all = arma::join_rows(all, data[c]);
  }
  const arma::vec floor = kCovarianceFloor * arma::var(all, 0, 1);
  arma::arma_rng::set_seed(options.seed);
  for (std::size_t c = 0; c < kClasses.size(); ++c) {
    model.classes[c].mixture = learnMixture(data[c], floor, options.components, kClasses[c].name);
    std::printf("%s: %zu samples of %lu points, %zu components\n", kClasses[c].name,
                static_cast<std::size_t>(data[c].n_cols),
                static_cast<unsigned long>(reservoirs[c].offered()),
                model.classes[c].mixture.size());
    model.provenance["points of " + model.classes[c].name] =
        std::to_string(reservoirs[c].offered());
  }
  model.unknown_log_likelihood = unknownThreshold(model, reservoirs);
  std::string inputs;
  for (const std::string& input : options.inputs)
    inputs += (inputs.empty() ? "" : " ") + baseName(input);
  model.provenance["inputs"] = inputs;
  model.provenance["program"] = "train_classifier";
  model.provenance["samples per class, at most"] = std::to_string(options.samples);
  model.provenance["seed"] = std::to_string(options.seed);
  saveClassifierModel(model, options.output);
  std::printf("%s written\n", options.output.c_str());
}

}  // namespace
}  // namespace ladar_perception

int main(int argc, char** argv) {
  ladar_perception::Options options;
  CLI::App app(
      "Learns a model of the classes surface, scatter and linear from bags whose clouds "
      "have a field 'truth' (1 surface, 2 scatter, 3 linear, else ignored). Features are "
      "computed scan by scan, by the code that runs on the vehicle.");
  app.add_option("inputs", options.inputs, "bags with truth, from simulate_ladar or import_scans")
      ->required();
  app.add_option("--out", options.output, "model file to write")->required();
  app.add_option("--config", options.config, "parameters, as config/terrain.yaml");
  app.add_option("--features", options.features, "names of the features, separated by commas")
      ->delimiter(',');
  app.add_option("--components", options.components, "Gaussians per class")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--samples", options.samples, "points per class, at most")
      ->check(CLI::Range(100, 10000000))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of sampling and of the start of EM")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    ladar_perception::train(options);
  } catch (const std::exception& error) {
    std::cerr << "train_classifier: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
