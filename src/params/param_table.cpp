// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/params/param_table.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include <yaml-cpp/yaml.h>

namespace ladar_perception {
namespace {

std::string number(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string rangeText(const ParamSpec& spec) {
  const std::string unit = spec.unit.empty() ? "" : " " + spec.unit;
  return "[" + number(spec.min) + ", " + number(spec.max) + "]" + unit;
}

/// Sets the target, or says why not.
std::string setTarget(const ParamSpec& spec, const ParamValue& value) {
  const auto mistyped = [&](const char* expected) {
    return spec.name + ": expected " + expected + ", got " + describeValue(value);
  };
  if (auto* const* target = std::get_if<bool*>(&spec.target)) {
    const auto* given = std::get_if<bool>(&value);
    if (given == nullptr) return mistyped("true or false");
    **target = *given;
  } else if (auto* const* text = std::get_if<std::string*>(&spec.target)) {
    const auto* given = std::get_if<std::string>(&value);
    if (given == nullptr) return mistyped("text");
    **text = *given;
  } else {
    const auto* whole = std::get_if<int>(&value);
    const auto* real = std::get_if<double>(&value);
    auto* const* int_target = std::get_if<int*>(&spec.target);
    if (whole == nullptr && (real == nullptr || int_target != nullptr)) {
      return mistyped(int_target != nullptr ? "a whole number" : "a number");
    }
    const double given = whole != nullptr ? *whole : *real;
    if (!(given >= spec.min && given <= spec.max)) {
      return spec.name + ": " + describeValue(value) + " is out of range " + rangeText(spec);
    }
    if (int_target != nullptr) {
      **int_target = *whole;
    } else {
      *std::get<double*>(spec.target) = given;
    }
  }
  return "";
}

std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

ParamValue scalarValue(const YAML::Node& node) {
  // A quoted scalar carries the tag "!".
  if (node.Tag() == "!") return node.Scalar();
  int whole = 0;
  if (YAML::convert<int>::decode(node, whole)) return whole;
  double real = 0.0;
  if (YAML::convert<double>::decode(node, real)) return real;
  const std::string& text = node.Scalar();
  if (text == "true" || text == "True" || text == "TRUE") return true;
  if (text == "false" || text == "False" || text == "FALSE") return false;
  return text;
}

}  // namespace

void ParamTable::add(const std::string& name, bool* target, const std::string& meaning) {
  specs_.push_back({name, target, 0.0, 1.0, "", meaning});
}

void ParamTable::add(const std::string& name, std::string* target, const std::string& meaning) {
  ParamSpec spec;
  spec.name = name;
  spec.target = target;
  spec.meaning = meaning;
  specs_.push_back(spec);
}

void ParamTable::add(const std::string& name, int* target, int min, int max,
                     const std::string& unit, const std::string& meaning) {
  specs_.push_back(
      {name, target, static_cast<double>(min), static_cast<double>(max), unit, meaning});
}

void ParamTable::add(const std::string& name, double* target, double min, double max,
                     const std::string& unit, const std::string& meaning) {
  specs_.push_back({name, target, min, max, unit, meaning});
}

std::vector<std::string> ParamTable::apply(const ParamMap& values) const {
  std::vector<std::string> violations;
  for (const auto& [name, value] : values) {
    const ParamSpec* spec = find(name);
    std::string violation;
    if (spec == nullptr) {
      violation = name + ": unknown parameter" + closestName(name);
    } else {
      violation = setTarget(*spec, value);
    }
    if (!violation.empty()) violations.push_back(violation);
  }
  return violations;
}

const ParamSpec* ParamTable::find(const std::string& name) const {
  const auto it = std::find_if(specs_.begin(), specs_.end(),
                               [&](const ParamSpec& spec) { return spec.name == name; });
  return it == specs_.end() ? nullptr : &*it;
}

std::string ParamTable::closestName(const std::string& name) const {
  constexpr std::size_t kFarthestTypo = 3;
  std::size_t least = kFarthestTypo + 1;
  std::string closest;
  for (const ParamSpec& spec : specs_) {
    const std::size_t distance = editDistance(name, spec.name);
    if (distance < least) {
      least = distance;
      closest = spec.name;
    }
  }
  return closest.empty() ? "" : ", did you mean '" + closest + "'?";
}

ParamMap loadParamFile(const std::string& path) {
  std::ifstream file(path);
  file.peek();  // a folder can be opened, but not read
  if (!file.is_open() || file.bad()) {
    throw std::runtime_error(path + ": configuration file cannot be opened");
  }
  std::ostringstream text;
  text << file.rdbuf();
  YAML::Node root;
  try {
    root = YAML::Load(text.str());
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(path + ":" + std::to_string(error.mark.line + 1) +
                             ": no YAML: " + error.msg);
  }
  if (root.IsNull()) return {};
  if (!root.IsMap()) throw std::runtime_error(path + ": expected a map of parameters");
  ParamMap values;
  for (const auto& entry : root) {
    const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    const YAML::Node& node = entry.second;
    const bool fresh =
        values
            .emplace(name, node.IsScalar()   ? scalarValue(node)
                           : node.IsMap()    ? ParamValue(UnsupportedValue{"a map"})
                           : node.IsSequence() ? ParamValue(UnsupportedValue{"a list"})
                                               : ParamValue(UnsupportedValue{"nothing"}))
            .second;
    if (!fresh) {
      throw std::runtime_error(path + ":" + std::to_string(entry.first.Mark().line + 1) +
                               ": parameter '" + name + "' stands twice");
    }
  }
  return values;
}

std::string describeValue(const ParamValue& value) {
  if (const auto* given = std::get_if<bool>(&value)) return *given ? "true" : "false";
  if (const auto* given = std::get_if<int>(&value)) return std::to_string(*given);
  if (const auto* given = std::get_if<double>(&value)) return number(*given) + " (a real number)";
  if (const auto* given = std::get_if<std::string>(&value)) return "the text '" + *given + "'";
  return std::get<UnsupportedValue>(value).kind;
}

}  // namespace ladar_perception
