// SPDX-License-Identifier: BSD-3-Clause
// Labelled inputs of any kind, bags among them, as scans that have gone through the pipeline.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ladar_perception/io/class_mapping.h"
#include "ladar_perception/learn/labelled_inputs.h"
#include "ladar_perception/learn/labelled_pass.h"
#include "ladar_perception/learn/truth_reader.h"
#include "terrain_node_config.h"

namespace ladar_perception {

/// What the command line says of the inputs.
struct LabelledSourceOptions {
  std::vector<std::string> inputs;
  std::string format;
  std::vector<std::string> columns;
  std::string classes;
  std::string label_field = "label";
  std::string topic;

  void addTo(CLI::App* app);
};

/// Feeds labelled files and bags to a visitor.
class LabelledSource {
 public:
  /// Throws std::runtime_error that names the option or input that is wrong.
  explicit LabelledSource(const LabelledSourceOptions& options);

  const std::vector<LabelledInput>& inputs() const { return inputs_; }
  /// The mapping that was given with --classes, if one was.
  const std::optional<ClassMapping>& mapping() const { return mapping_; }

  /// One pass over a file, for a model that fits `config`; see LabelledScanVisitor. Without
  /// --classes, Oakland tiles and SemanticKITTI scans have the shipped mapping whose classes are
  /// the model's; of others the field `truth` is taken. Throws std::runtime_error that names the
  /// file.
  void forEachLabelledScan(const LabelledFile& file, Pass pass, const TerrainNodeConfig& config,
                           const ClassifierModel& model, const LabelledScanVisitor& visit) const;

 private:
  TruthReader truthReader(const LabelledFile& file, const std::vector<std::string>& names) const;
  void playBag(const std::string& path, const TruthReader& reader, const TerrainNodeConfig& config,
               const ClassifierModel& model, const LabelledScanVisitor& visit) const;

  LabelledSourceOptions options_;
  std::vector<LabelledInput> inputs_;
  std::optional<ClassMapping> mapping_;
};

/// "names" of a model's classes.
std::vector<std::string> classNames(const ClassifierModel& model);

}  // namespace ladar_perception
