// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/class_mapping.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "text_table.h"

namespace ladar_perception {
namespace {

[[noreturn]] void failAt(const std::string& path, const YAML::Mark& mark,
                         const std::string& message) {
  if (mark.is_null()) throw std::runtime_error(path + ": " + message);
  failAtLine(path, static_cast<std::size_t>(mark.line) + 1, message);
}

void expectKeys(const std::string& path, const YAML::Node& map,
                const std::vector<std::string>& keys, const std::string& where) {
  std::string expected;
  for (const std::string& key : keys) expected += (expected.empty() ? "" : " and ") + key;
  if (!map.IsMap()) failAt(path, map.Mark(), where + " must be a map with " + expected);
  for (const auto& entry : map) {
    const std::string key = entry.first.Scalar();
    if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
      failAt(path, entry.first.Mark(),
             "unknown key '" + key + "' in " + where + ", expected " + expected);
    }
  }
  for (const std::string& key : keys) {
    if (!map[key]) failAt(path, map.Mark(), where + " has no '" + key + "'");
  }
}

uint32_t parseLabel(const std::string& path, const YAML::Node& node) {
  double value = -1.0;
  const bool is_number = node.IsScalar() && !node.Scalar().empty() &&
                         parseNumber(node.Scalar(), value) && value == std::floor(value);
  if (!is_number || value < 0.0 || value > std::numeric_limits<uint32_t>::max()) {
    failAt(path, node.Mark(),
           "label '" + (node.IsScalar() ? node.Scalar() : std::string("?")) +
               "' is not an integer from 0 to 4294967295");
  }
  return static_cast<uint32_t>(value);
}

void addLabel(const std::string& path, const YAML::Node& node, ClassMapping& mapping) {
  const uint32_t label = parseLabel(path, node);
  const auto truth = static_cast<uint8_t>(mapping.names.size());
  const auto [it, is_new] = mapping.truth_of_label.emplace(label, truth);
  if (is_new) return;
  failAt(path, node.Mark(),
         "label " + std::to_string(label) + " is in class '" + mapping.names[it->second - 1u] +
             "' already");
}

void addClass(const std::string& path, const YAML::Node& node, ClassMapping& mapping) {
  expectKeys(path, node, {"name", "labels"}, "a class");
  const YAML::Node name = node["name"];
  if (!name.IsScalar() || name.Scalar().empty()) {
    failAt(path, name.Mark(), "name of a class must be a word");
  }
  if (std::count(mapping.names.begin(), mapping.names.end(), name.Scalar()) != 0) {
    failAt(path, name.Mark(), "a second class is named '" + name.Scalar() + "'");
  }
  mapping.names.push_back(name.Scalar());
  const YAML::Node labels = node["labels"];
  if (!labels.IsSequence() || labels.size() == 0) {
    failAt(path, labels.Mark(), "labels of '" + name.Scalar() + "' must be a list of integers");
  }
  for (const YAML::Node& label : labels) addLabel(path, label, mapping);
}

}  // namespace

ClassMapping loadClassMapping(const std::string& path) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(path);
  } catch (const YAML::BadFile&) {
    throw std::runtime_error(path + ": cannot be opened for reading");
  } catch (const YAML::Exception& error) {
    failAt(path, error.mark, error.msg);
  }
  expectKeys(path, root, {"classes"}, "the file");
  const YAML::Node classes = root["classes"];
  constexpr std::size_t kMaxClasses = std::numeric_limits<uint8_t>::max();
  if (!classes.IsSequence() || classes.size() == 0 || classes.size() > kMaxClasses) {
    failAt(path, classes.Mark(), "classes must be a list of 1 to 255 classes");
  }
  ClassMapping mapping;
  for (const YAML::Node& node : classes) addClass(path, node, mapping);
  return mapping;
}

void addTruth(Scan& scan, const std::string& label_field, const ClassMapping& mapping) {
  Column truth{"truth", ScalarType::kUint8, readColumn(scan, label_field)};
  for (std::size_t i = 0; i < truth.values.size(); ++i) {
    const double label = truth.values[i];
    // The negated comparison also catches NaN.
    if (!(label >= 0.0 && label <= std::numeric_limits<uint32_t>::max()) ||
        label != std::floor(label)) {
      throw std::runtime_error("field '" + label_field + "' of point " + std::to_string(i) +
                               " is " + std::to_string(label) + ", expected an integer label");
    }
    truth.values[i] = mapping.truth(static_cast<uint32_t>(label));
  }
  addColumn(scan, truth);
}

}  // namespace ladar_perception
