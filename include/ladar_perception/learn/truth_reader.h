// SPDX-License-Identifier: BSD-3-Clause
// From the labels in a cloud to the classes of a model.
#pragma once

#include <string>
#include <vector>

#include "ladar_perception/cloud/cloud_layout.h"
#include "ladar_perception/io/class_mapping.h"

namespace ladar_perception {

/// Names of the classes that the values 1, 2, 3 of a field `truth` stand for in simulated bags.
const std::vector<std::string>& terrainClassNames();

/// Reads the true class of every point of a cloud: 0 is ignored, else 1 + its place in the model.
class TruthReader {
 public:
  /// By the labels in `label_field`. Classes are matched by name, whatever their order; the mapping
  /// may lack classes of the model. Throws std::runtime_error that lists both if it has one more.
  TruthReader(const ClassMapping& mapping, const std::string& label_field,
              const std::vector<std::string>& class_names);
  /// By the field `truth`. Its values are the places of the classes in the model, from 1, unless
  /// the model's classes are those of terrainClassNames() in another order: then they are places in
  /// that list.
  explicit TruthReader(const std::vector<std::string>& class_names);

  /// One value per point. Throws std::runtime_error if the field is missing, has a value that is no
  /// label, or a truth beyond the last class.
  std::vector<double> read(const CloudView& cloud) const;
  const std::string& field() const { return field_; }

 private:
  std::size_t truthOf(double value, std::size_t point) const;

  std::string field_;
  bool is_label_ = false;
  ClassMapping mapping_;
  std::vector<std::size_t> class_of_truth_;  // by the mapping's or the field's truth, 0 for 0
};

}  // namespace ladar_perception
