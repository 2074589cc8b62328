// SPDX-License-Identifier: BSD-3-Clause
#include "labelled_source.h"

#include <algorithm>
#include <stdexcept>

#include "ladar_perception/util/progress.h"
#include "package_path.h"
#include "scan_bag_reader.h"
#include "terrain_processor.h"

namespace ladar_perception {
namespace {

struct ShippedMapping {
  ScanFormat format;
  const char* path;
};
constexpr ShippedMapping kShippedMappings[] = {
    {ScanFormat::kOakland, "package://ladar_perception/config/classes/oakland_three.yaml"},
    {ScanFormat::kOakland, "package://ladar_perception/config/classes/oakland_five.yaml"},
    {ScanFormat::kKitti, "package://ladar_perception/config/classes/semantic_kitti_three.yaml"}};

std::string listOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// Says which file an error is about, unless it does so itself.
[[noreturn]] void rethrowNaming(const std::string& path, const std::runtime_error& error) {
  const std::string message = error.what();
  if (message.find(path) != std::string::npos) throw std::runtime_error(message);
  throw std::runtime_error(path + ": " + message);
}

}  // namespace

void LabelledSourceOptions::addTo(CLI::App* app) {
  app->add_option("inputs", inputs,
                  "labelled clouds (.xyz_label_conf, SemanticKITTI .bin, .ply, .pcd, .csv, .xyz), "
                  "folders of them, or bags")
      ->required()
      ->type_name("FILE|FOLDER");
  std::vector<std::string> formats = scanFormatNames();
  formats.emplace_back("bag");
  app->add_option("--format", format, "of all inputs, in place of what their extensions tell")
      ->check(CLI::IsMember(formats));
  app->add_option("--columns", columns, "names of the columns of xyz, '_' skips one: x,y,z,label")
      ->delimiter(',')
      ->allow_extra_args(false);
  app->add_option("--classes", classes,
                  "mapping of labels to classes, see config/classes; without it Oakland tiles and "
                  "SemanticKITTI scans have the shipped ones, others need a field 'truth'");
  app->add_option("--label-field", label_field, "field with the labels that --classes maps")
      ->capture_default_str();
  app->add_option("--topic", topic, "of the clouds, where a bag has several");
}

LabelledSource::LabelledSource(const LabelledSourceOptions& options)
    : options_(options), inputs_(listLabelledInputs(options.inputs, options.format)) {
  if (!options.classes.empty()) mapping_ = loadClassMapping(resolvePackagePath(options.classes));
}

TruthReader LabelledSource::truthReader(const LabelledFile& file,
                                        const std::vector<std::string>& names) const {
  if (mapping_) {
    try {
      return {*mapping_, options_.label_field, names};
    } catch (const std::runtime_error& error) {
      rethrowNaming(options_.classes, error);
    }
  }
  bool has_shipped = false;
  for (const ShippedMapping& shipped : kShippedMappings) {
    if (!file.format || *file.format != shipped.format) continue;
    has_shipped = true;
    const ClassMapping mapping = loadClassMapping(resolvePackagePath(shipped.path));
    if (std::is_permutation(names.begin(), names.end(), mapping.names.begin(),
                            mapping.names.end())) {
      return {mapping, options_.label_field, names};
    }
  }
  if (has_shipped) {
    throw std::runtime_error("no shipped mapping of its labels has the model's classes (" +
                             listOf(names) + "): give one with --classes");
  }
  return TruthReader(names);
}

void LabelledSource::forEachLabelledScan(const LabelledFile& file, Pass pass,
                                         const TerrainNodeConfig& config,
                                         const ClassifierModel& model,
                                         const LabelledScanVisitor& visit) const {
  try {
    const TruthReader reader = truthReader(file, classNames(model));
    if (!file.format) {
      playBag(file.path, reader, config, model, visit);
      return;
    }
    const Scan scan =
        readScan(file.path, *file.format,
                 *file.format == ScanFormat::kXyz ? options_.columns : std::vector<std::string>());
    if (scan.size() == 0) throw std::runtime_error("has no points");
    const auto truth = reader.read({scan.layout, scan.data.data(), scan.data.size()});
    runLabelledPass(scan, truth, pass, config.pipeline, model, file.path, visit);
  } catch (const std::runtime_error& error) {
    rethrowNaming(file.path, error);
  }
}

void LabelledSource::playBag(const std::string& path, const TruthReader& reader,
                             const TerrainNodeConfig& config, const ClassifierModel& model,
                             const LabelledScanVisitor& visit) const {
  tf2::BufferCore buffer(ros::Duration(30.0));
  ScanBagReader bag(path, options_.topic, &buffer);
  TerrainProcessor processor(config, model, &buffer);
  processor.keepFeatures(true);
  Progress progress("scans of " + path, bag.scanCount());
  ScanBagReader::Scan scan;
  bool any = false;
  std::string first_drop;
  while (bag.next(&scan)) {
    const ros::Time deadline = scan.recorded + ros::Duration(config.tf_timeout_s);
    const auto outcome = processor.process(*scan.cloud, [&](const std::function<bool()>& ready) {
      return bag.playUntil(ready, deadline);
    });
    progress.advance();
    if (outcome.drop) {
      if (first_drop.empty()) first_drop = scanDropName(*outcome.drop) + (": " + outcome.detail);
      continue;
    }
    any = true;
    visit(processor.pipeline(),
          reader.read({processor.scanLayout(), scan.cloud->data.data(), scan.cloud->data.size()}));
  }
  progress.finish();
  if (!any) {
    throw std::runtime_error("not one scan could be used" +
                             (first_drop.empty() ? "" : "; the first: " + first_drop));
  }
}

std::vector<std::string> classNames(const ClassifierModel& model) {
  std::vector<std::string> names;
  for (const ModelClass& model_class : model.classes) names.push_back(model_class.name);
  return names;
}

}  // namespace ladar_perception
