// SPDX-License-Identifier: BSD-3-Clause
// What is written in a policy's specification, before any policy looks at it.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace ladar_perception {

/// Ratios and factors of weights stay within these: spacing goes with the root of the density, and
/// one that varies by more than a thousand has no grid to be found on.
constexpr double kLeastFactor = 1e-6;
constexpr double kGreatestFactor = 1e6;

/// "name" or "name:key=value,key=value". What is wrong is told by std::invalid_argument that quotes
/// the whole text, the part that is wrong, and what was expected.
class PolicySpecification {
 public:
  explicit PolicySpecification(const std::string& text);

  const std::string& name() const { return name_; }
  const std::vector<std::pair<std::string, std::string>>& options() const { return options_; }

  /// Refuses keys that are not among these.
  void expectKeys(const std::vector<std::string>& keys) const;
  /// Number of that key, or `fallback` where it is not given.
  double number(const std::string& key, double fallback, double min, double max) const;
  /// Word of that key, the first of `words` where it is not given.
  std::string word(const std::string& key, const std::vector<std::string>& words) const;
  /// 0x00RRGGBB of that key, which must be given as #rrggbb.
  uint32_t color(const std::string& key) const;

  [[noreturn]] void fail(const std::string& message) const;

 private:
  const std::string* find(const std::string& key) const;

  std::string text_;
  std::string name_;
  std::vector<std::pair<std::string, std::string>> options_;
};

/// The shortest text that reads as this number.
std::string numberText(double value);
/// "a, b or c".
std::string alternatives(const std::vector<std::string>& words);

}  // namespace ladar_perception
