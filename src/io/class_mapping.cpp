// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/io/class_mapping.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "text_table.h"

namespace ladar_perception {
namespace {

constexpr std::size_t kMinClasses = 2;
constexpr std::size_t kMaxClasses = 16;  // of a classifier

struct NamedColor {
  const char* name;
  uint32_t rgb;
};
constexpr std::array<NamedColor, 3> kNamedColors = {
    {{"surface", 0xdc2828}, {"scatter", 0x28b43c}, {"linear", 0x3264ff}}};
// The first seven are those of Okabe and Ito (2008). The others are the ones, among several such
// palettes, that stay farthest (in CIELAB, as seen with and without red-green blindness) from one
// another, from black, and from the grey of unknown.
constexpr std::array<uint32_t, kMaxClasses> kPalette = {
    0x0072b2, 0xe69f00, 0x009e73, 0xd55e00, 0x56b4e9, 0xcc79a7, 0xf0e442, 0x661100,
    0x222255, 0xcceeff, 0xddcc77, 0x490092, 0x004949, 0x1e90ff, 0xffaabb, 0x117733};

bool contains(const std::vector<uint32_t>& colors, uint32_t color) {
  return std::find(colors.begin(), colors.end(), color) != colors.end();
}

[[noreturn]] void failAt(const std::string& path, const YAML::Mark& mark,
                         const std::string& message) {
  if (mark.is_null()) throw std::runtime_error(path + ": " + message);
  failAtLine(path, static_cast<std::size_t>(mark.line) + 1, message);
}

void expectKeys(const std::string& path, const YAML::Node& map,
                const std::vector<std::string>& keys, const std::string& optional_key,
                const std::string& where) {
  std::string expected;
  for (const std::string& key : keys) expected += (expected.empty() ? "" : " and ") + key;
  if (!optional_key.empty()) expected += " and, if wanted, " + optional_key;
  if (!map.IsMap()) failAt(path, map.Mark(), where + " must be a map with " + expected);
  for (const auto& entry : map) {
    const std::string key = entry.first.Scalar();
    if (key != optional_key && std::find(keys.begin(), keys.end(), key) == keys.end()) {
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

/// Of a class, from "#rrggbb"; kNoColor if it has none.
uint32_t parseColor(const std::string& path, const YAML::Node& node, const ClassMapping& mapping) {
  if (!node.IsDefined()) return kNoColor;
  const std::string text = node.IsScalar() ? node.Scalar() : "";
  const bool is_color = text.size() == 7 && text[0] == '#' &&
                        text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
  if (!is_color) failAt(path, node.Mark(), "color '" + text + "', expected \"#rrggbb\" in quotes");
  const auto rgb = static_cast<uint32_t>(std::stoul(text.substr(1), nullptr, 16));
  if (contains(mapping.colors, rgb)) {
    failAt(path, node.Mark(), "a second class has the color '" + text + "'");
  }
  return rgb;
}

void addClass(const std::string& path, const YAML::Node& node, ClassMapping& mapping) {
  expectKeys(path, node, {"name", "labels"}, "color", "a class");
  const YAML::Node name = node["name"];
  if (!name.IsScalar() || name.Scalar().empty()) {
    failAt(path, name.Mark(), "name of a class must be a word");
  }
  if (std::count(mapping.names.begin(), mapping.names.end(), name.Scalar()) != 0) {
    failAt(path, name.Mark(), "a second class is named '" + name.Scalar() + "'");
  }
  if (name.Scalar() == "unknown") {
    failAt(path, name.Mark(), "'unknown' is what points without a class are called");
  }
  mapping.names.push_back(name.Scalar());
  mapping.colors.push_back(parseColor(path, node["color"], mapping));
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
  expectKeys(path, root, {"classes"}, "", "the file");
  const YAML::Node classes = root["classes"];
  if (!classes.IsSequence() || classes.size() < kMinClasses || classes.size() > kMaxClasses) {
    failAt(path, classes.Mark(), "classes must be a list of 2 to 16 classes");
  }
  ClassMapping mapping;
  for (const YAML::Node& node : classes) addClass(path, node, mapping);
  mapping.colors = classColors(mapping.names, mapping.colors);
  return mapping;
}

std::vector<uint32_t> classColors(const std::vector<std::string>& names,
                                  std::vector<uint32_t> colors) {
  colors.resize(names.size(), kNoColor);
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (const NamedColor& named : kNamedColors) {
      const bool fits = colors[i] == kNoColor && names[i] == named.name;
      if (fits && !contains(colors, named.rgb)) colors[i] = named.rgb;
    }
  }
  for (uint32_t& color : colors) {
    for (auto it = kPalette.begin(); color == kNoColor && it != kPalette.end(); ++it) {
      if (!contains(colors, *it)) color = *it;
    }
  }
  return colors;
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
