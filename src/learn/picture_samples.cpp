// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/picture_samples.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "json_parts.h"
#include "ladar_perception/learn/labelled_pass.h"

namespace ladar_perception {
namespace {

using Json = nlohmann::ordered_json;

/// A file that says so if it cannot be written.
void writeFile(const std::string& path, const std::string& head, const char* bytes,
               std::size_t size) {
  std::ofstream file(path, std::ios::binary);
  file << head;
  file.write(bytes, static_cast<std::streamsize>(size));
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

/// Header of a NumPy file, version 1.0, of a C-ordered matrix of float32.
std::string npyHeader(std::size_t rows, std::size_t columns) {
  std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(rows) +
                     ", " + std::to_string(columns) + "), }";
  constexpr std::size_t kPreamble = 10;
  constexpr std::size_t kAlignment = 64;
  while ((kPreamble + text.size() + 1) % kAlignment != 0) text += ' ';
  text += '\n';
  const std::size_t size = text.size();
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(size & 255) +
         static_cast<char>(size >> 8) + text;
}

}  // namespace

PictureSamples::PictureSamples(const ClassifierModel& model, uint64_t seed)
    : model_(model), random_(seed), features_(model.classes.size()) {}

std::size_t PictureSamples::reservoirSlot(uint64_t* offered, std::size_t most) {
  ++*offered;
  return static_cast<std::size_t>(*offered <= most ? *offered - 1 : random_() % *offered);
}

void PictureSamples::add(const TerrainPipeline& pipeline, const std::vector<double>& truth) {
  const VoxelMap& map = pipeline.map();
  const std::vector<VoxelIndex> voxels = voxelsBySlot(map);
  const double h = pipeline.config().voxel_size_m;
  const auto metres = [&](int32_t voxel) { return static_cast<float>((voxel + 0.5) * h); };
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const CellId cell = pipeline.pointCells()[i];
    if (!(truth[i] >= 1.0) || cell == kNoCell) continue;
    const std::size_t slot = map.slotOf(cell);
    const int label = pipeline.pointLabels()[i].label;
    if (pipeline.saliency(slot).defined) {
      addFeatures(static_cast<std::size_t>(truth[i]), label, pipeline.features(slot));
    }
    if (clouds_.size() > kClouds) continue;
    Cloud& cloud = clouds_.back();
    const std::size_t at = reservoirSlot(&cloud.offered, kPointsPerCloud);
    if (at >= kPointsPerCloud) continue;
    if (at >= cloud.points.size()) cloud.points.resize(at + 1);
    cloud.points[at] = {metres(voxels[slot].x), metres(voxels[slot].y), metres(voxels[slot].z),
                        static_cast<float>(truth[i]), static_cast<float>(label)};
  }
}

void PictureSamples::addFeatures(std::size_t truth, int label, const float* values) {
  FeatureSamples& samples = features_[truth - 1];
  const std::size_t at = reservoirSlot(&samples.offered, kFeaturesPerClass);
  if (at >= kFeaturesPerClass) return;
  if (at >= samples.values.size()) {
    samples.values.resize(at + 1);
    samples.labels.resize(at + 1);
  }
  samples.values[at].assign(values, values + model_.features.size());
  samples.labels[at] = label;
}

void PictureSamples::write(const std::string& folder) const {
  Json json;
  json["features"] = Json::array();
  for (const Feature& feature : model_.features) json["features"].push_back(featureName(feature));
  json["mixtures"] = Json::array();
  for (const ModelClass& model_class : model_.classes) {
    json["mixtures"].push_back(mixtureJson(model_class.mixture));
  }
  json["samples"] = Json::array();
  for (const FeatureSamples& samples : features_) {
    json["samples"].push_back({{"values", samples.values}, {"labels", samples.labels}});
  }
  json["clouds"] = Json::array();
  for (std::size_t c = 0; c < clouds_.size() && c < kClouds; ++c) {
    const Cloud& cloud = clouds_[c];
    if (cloud.points.empty()) continue;
    const std::string name = "cloud_" + std::to_string(c + 1) + ".npy";
    json["clouds"].push_back({{"name", cloud.name}, {"file", name}});
    writeFile(folder + "/" + name, npyHeader(cloud.points.size(), 5),
              reinterpret_cast<const char*>(cloud.points.data()),
              cloud.points.size() * sizeof(Point));
  }
  const std::string text = json.dump() + "\n";
  writeFile(folder + "/picture_data.json", "", text.data(), text.size());
}

}  // namespace ladar_perception
