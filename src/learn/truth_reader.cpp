// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/learn/truth_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "ladar_perception/cloud/point_reader.h"

namespace ladar_perception {
namespace {

std::string listOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

std::string textOf(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// For every class of `names`, from 1, its place in `model_names`, from 1; 0 stays 0.
std::vector<std::size_t> matchNames(const std::vector<std::string>& names,
                                    const std::vector<std::string>& model_names) {
  std::vector<std::size_t> places = {0};
  for (const std::string& name : names) {
    const auto it = std::find(model_names.begin(), model_names.end(), name);
    if (it == model_names.end()) {
      throw std::runtime_error("class '" + name + "' of the mapping is none of the model's (" +
                               listOf(model_names) + ")");
    }
    places.push_back(1 + static_cast<std::size_t>(it - model_names.begin()));
  }
  return places;
}

}  // namespace

const std::vector<std::string>& terrainClassNames() {
  static const std::vector<std::string> kNames = {"surface", "scatter", "linear"};
  return kNames;
}

TruthReader::TruthReader(const ClassMapping& mapping, const std::string& label_field,
                         const std::vector<std::string>& class_names)
    : field_(label_field),
      is_label_(true),
      mapping_(mapping),
      class_of_truth_(matchNames(mapping.names, class_names)) {}

TruthReader::TruthReader(const std::vector<std::string>& class_names) : field_("truth") {
  const std::vector<std::string>& terrain = terrainClassNames();
  const bool permuted =
      std::is_permutation(class_names.begin(), class_names.end(), terrain.begin(), terrain.end());
  class_of_truth_ = matchNames(permuted ? terrain : class_names, class_names);
}

std::vector<double> TruthReader::read(const CloudView& cloud) const {
  const Field* field = cloud.layout.find(field_);
  if (field == nullptr) {
    throw std::runtime_error("has no field '" + field_ + "', which tells the true class" +
                             (is_label_ ? "" : " where no mapping of labels (--classes) is given") +
                             "; fields present: " + cloud.layout.describeFields());
  }
  std::vector<double> values;
  readScalars(cloud, *field, &values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<double>(truthOf(values[i], i));
  }
  return values;
}

std::size_t TruthReader::truthOf(double value, std::size_t point) const {
  // The negated comparison also catches NaN.
  if (!(value >= 0.0 && value <= std::numeric_limits<uint32_t>::max()) ||
      value != std::floor(value)) {
    throw std::runtime_error("field '" + field_ + "' of point " + std::to_string(point) + " is " +
                             textOf(value) + ", expected an integer label");
  }
  const auto label = static_cast<uint32_t>(value);
  const std::size_t truth = is_label_ ? mapping_.truth(label) : label;
  if (truth < class_of_truth_.size()) return class_of_truth_[truth];
  throw std::runtime_error("field 'truth' of point " + std::to_string(point) + " is " +
                           textOf(value) + ", but the model has " +
                           std::to_string(class_of_truth_.size() - 1) +
                           " classes; name the labels' classes with --classes");
}

}  // namespace ladar_perception
