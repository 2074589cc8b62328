// SPDX-License-Identifier: BSD-3-Clause
// How far registrations may start from the truth, for several ways to sample the clouds: the
// experiment of Cole, Harrison, Newman, figure 8.
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <stdexcept>

#include "basin_cloud.h"
#include "basin_sampling.h"
#include "basin_study.h"
#include "command_line.h"
#include "pcl_registrars.h"
#include "report_pictures.h"

namespace ladar_perception {
namespace {

struct Options {
  std::string cloud_a;
  std::string cloud_b;
  std::string truth_path;
  std::string out;
  std::string methods = "voxel_grid,random,fps,uniform,range";
  std::string solver = "annealed";
  std::vector<double> sensor_a = {0.0, 0.0, 0.0};
  std::vector<double> sensor_b = {0.0, 0.0, 0.0};
  int count = 0;
  bool no_pictures = false;
  StartOptions starts;
  RegistrationConfig registration;
};

void addOptions(CLI::App* app, Options* o) {
  app->add_option("A", o->cloud_a, "cloud: pcd, ply, xyz, txt, csv, vtk, 3d (3DTK), bin (KITTI)")
      ->required();
  app->add_option("B", o->cloud_b, "cloud that is registered to A")->required();
  app->add_option("--truth", o->truth_path,
                  "4 x 4 matrix, as text, that takes B into A; without it, it is what the "
                  "registration of all points ends with when it starts from the identity");
  app->add_option("--count", o->count, "samples of each cloud")
      ->required()
      ->check(CLI::Range(1, 10000000));
  app->add_option("--out", o->out, "folder to write basin.json and pictures to")->required();
  app->add_option("--methods", o->methods,
                  "separated by commas: raw, voxel_grid, voxel_grid_25m (cropped to 25 m), random, "
                  "fps, or policies of the re-sampler (uniform, range, normal_variation:..., "
                  "label:..., several multiplied by +): the points nearest to the samples")
      ->capture_default_str();
  app->add_option("--solver", o->solver,
                  "annealed or plain (point to plane), or PCL's pcl_icp, pcl_gicp, pcl_ndt")
      ->check(CLI::IsMember({"annealed", "plain", "pcl_icp", "pcl_gicp", "pcl_ndt"}))
      ->capture_default_str();
  app->add_option("--cost", o->registration.cost, "of annealed and plain")
      ->check(CLI::IsMember({"point_to_plane", "generalized"}))
      ->capture_default_str();
  app->add_option("--initial-radius", o->registration.initial_radius_m,
                  "m, how far apart partners may be at first")
      ->check(CLI::Range(0.3, 100.0))
      ->capture_default_str();
  app->add_option("--restarts", o->registration.restarts,
                  "other attempts of annealed and plain where one diverged")
      ->check(CLI::Range(0, RegistrationConfig::kMaxRestarts))
      ->capture_default_str();
  app->add_option("--finish", o->registration.finish_points,
                  "of the 30,000 points that clouds are averaged to, how many annealed lays on the "
                  "other's at the end; 0: the samples are the last")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  app->add_option("--starts", o->starts.random_starts, "random starts")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  app->add_option("--steps", o->starts.curve_steps, "starts along each of x, y and yaw")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app->add_option("--max-translation", o->starts.max_translation_m, "m, of the starts")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  app->add_option("--max-rotation", o->starts.max_rotation_deg, "degrees, of the starts")
      ->check(CLI::Range(0.0, 180.0))
      ->capture_default_str();
  app->add_option("--seed", o->starts.seed, "of the starts and of random samples")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app->add_option("--sensor-a", o->sensor_a, "where A's sensor was in A's frame, m: X Y Z")
      ->expected(3);
  app->add_option("--sensor-b", o->sensor_b, "where B's sensor was in B's frame, m: X Y Z")
      ->expected(3);
  app->add_flag("--no-pictures", o->no_pictures, "basin.json alone");
}

double millisecondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
      .count();
}

class BasinRun {
 public:
  explicit BasinRun(const Options& options)
      : options_(options), methods_(splitMethods(options.methods)) {
    if (methods_.empty()) throw std::runtime_error("--methods: none is given");
    for (const std::string& method : methods_) {
      try {
        checkMethod(method);
      } catch (const std::invalid_argument& error) {
        throw std::runtime_error(std::string("--methods: ") + error.what());
      }
    }
    a_ = readBasinCloud(options.cloud_a, Eigen::Vector3d(options.sensor_a.data()));
    b_ = readBasinCloud(options.cloud_b, Eigen::Vector3d(options.sensor_b.data()));
    registrar_ = makePclRegistrar(options.solver, options.registration.initial_radius_m);
    if (!registrar_) {
      RegistrationConfig config = options.registration;
      config.solver = options.solver;
      registrar_ = std::make_unique<SurfaceRegistrar>(config);
    }
  }

  void run() {
    report_.cloud_a = options_.cloud_a;
    report_.cloud_b = options_.cloud_b;
    report_.solver = options_.solver;
    report_.count = options_.count;
    report_.options = options_.starts;
    report_.starts = makeStarts(options_.starts);
    findTruth();
    prepareFolder();  // not before: what cannot be read leaves none
    for (const std::string& method : methods_) runMethod(method);
    const std::string path = options_.out + "/basin.json";
    std::ofstream file(path, std::ios::binary);
    file << basinJson(report_);
    if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
    file.close();
    if (options_.no_pictures) return;
    const std::string trouble = drawPictures("plot_registration_basin.py", options_.out);
    if (!trouble.empty()) std::cerr << "note: no pictures: " << trouble << "\n";
  }

 private:
  void prepareFolder() const {
    std::error_code error;
    std::filesystem::create_directories(options_.out, error);
    if (error || !std::filesystem::is_directory(options_.out)) {
      throw std::runtime_error(options_.out + ": the folder cannot be made");
    }
  }

  void findTruth() {
    if (!options_.truth_path.empty()) {
      report_.truth = options_.truth_path;
      report_.T_a_b_truth = readTransform(options_.truth_path);
      return;
    }
    report_.truth = "registration of all points from the identity";
    const RegistrationCloud a = prepare(a_, "raw", nullptr);
    const RegistrationCloud b = prepare(b_, "raw", nullptr);
    RegistrationConfig config = options_.registration;
    config.solver = "annealed";
    const RegistrationResult result =
        SurfaceRegistrar(config).align(a, b, Eigen::Isometry3d::Identity());
    report_.T_a_b_truth = result.T_a_b;
    const Eigen::Vector3d t = result.T_a_b.translation();
    std::printf("truth: %s, %s, %.3f %.3f %.3f m, %.2f degrees\n", report_.truth.c_str(),
                verdictName(result.verdict), t.x(), t.y(), t.z(),
                Eigen::AngleAxisd(result.T_a_b.linear()).angle() * 180.0 / M_PI);
    if (result.verdict == Verdict::kDiverged) {
      throw std::runtime_error("without --truth: the registration from the identity diverged (" +
                               result.reason + ")");
    }
  }

  RegistrationCloud prepare(const BasinCloud& cloud, const std::string& method,
                            MethodOutcomes* outcomes) const {
    const SampledCloud sampled = sampleCloud(cloud, {method, options_.count, options_.starts.seed});
    const auto begin = std::chrono::steady_clock::now();
    RegistrationCloud prepared(sampled.points, cloud.surface);
    if (outcomes != nullptr) {
      outcomes->sampling_ms += sampled.sampling_ms;
      outcomes->prepare_ms += millisecondsSince(begin);
    }
    return prepared;
  }

  void runMethod(const std::string& method) {
    MethodOutcomes outcomes;
    outcomes.method = method;
    const RegistrationCloud a = prepare(a_, method, &outcomes);
    const RegistrationCloud b = prepare(b_, method, &outcomes);
    runStarts(*registrar_, a, b, report_.T_a_b_truth, report_.starts, &outcomes);
    std::printf("%s\n", describeMethod(report_, outcomes).c_str());
    std::fflush(stdout);
    report_.methods.push_back(std::move(outcomes));
  }

  Options options_;
  std::vector<std::string> methods_;
  BasinCloud a_;
  BasinCloud b_;
  std::unique_ptr<Registrar> registrar_;
  BasinReport report_;
};

}  // namespace
}  // namespace ladar_perception

int main(int argc, char** argv) {
  CLI::App app(
      "Registers cloud B to cloud A from many starts, for several ways to sample them: how many "
      "find "
      "the truth, with what error, in what time.",
      "registration_basin");
  ladar_perception::Options options;
  ladar_perception::addOptions(&app, &options);
  if (const auto status = ladar_perception::parseArguments(&app, argc, argv)) return *status;
  try {
    ladar_perception::BasinRun(options).run();
  } catch (const std::exception& error) {
    std::cerr << "registration_basin: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
