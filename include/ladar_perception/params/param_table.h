// SPDX-License-Identifier: BSD-3-Clause
// Strict reading of parameters: one table names them, and whatever does not fit it is reported.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace ladar_perception {

/// A value of a kind no parameter has (a list, a map, nothing); holds the kind's name.
struct UnsupportedValue {
  std::string kind;
};

/// A parameter as it was given.
using ParamValue = std::variant<bool, int, double, std::string, UnsupportedValue>;
using ParamMap = std::map<std::string, ParamValue>;

/// One parameter: where its value goes and what is allowed.
struct ParamSpec {
  std::string name;
  std::variant<bool*, int*, double*, std::string*> target;
  double min = -std::numeric_limits<double>::infinity();  ///< of numbers, inclusive
  double max = std::numeric_limits<double>::infinity();
  std::string unit;
  std::string meaning;
};

/// The parameters of a configuration.
class ParamTable {
 public:
  void add(const std::string& name, bool* target, const std::string& meaning);
  void add(const std::string& name, std::string* target, const std::string& meaning);
  void add(const std::string& name, int* target, int min, int max, const std::string& unit,
           const std::string& meaning);
  void add(const std::string& name, double* target, double min, double max,
           const std::string& unit, const std::string& meaning);

  const std::vector<ParamSpec>& specs() const { return specs_; }
  /// Sets the targets of the parameters given; the others keep their values. Returns every
  /// violation as a sentence (unknown name, wrong type, out of range); the targets of those
  /// parameters are untouched. A whole number is a fine real number, not the other way round.
  std::vector<std::string> apply(const ParamMap& values) const;

 private:
  const ParamSpec* find(const std::string& name) const;
  std::string closestName(const std::string& name) const;

  std::vector<ParamSpec> specs_;
};

/// Reads a flat YAML file. Plain scalars are bool, int, real or text as YAML has it, quoted ones
/// are text. Throws std::runtime_error with file and line if it is no map of names to values.
ParamMap loadParamFile(const std::string& path);

/// The value as messages put it: "true", "2", "1.5 (a real number)", "the text 'x'", "a list".
std::string describeValue(const ParamValue& value);

}  // namespace ladar_perception
