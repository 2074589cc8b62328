// SPDX-License-Identifier: BSD-3-Clause
#include "policy_specification.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace ladar_perception {

PolicySpecification::PolicySpecification(const std::string& text) : text_(text) {
  const std::size_t colon = text.find(':');
  name_ = text.substr(0, colon);
  if (colon == std::string::npos) return;
  std::size_t begin = colon + 1;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string option = text.substr(begin, end - begin);
    const std::size_t equals = option.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == option.size()) {
      fail("'" + option + "' is no option, expected key=value");
    }
    const std::string key = option.substr(0, equals);
    if (find(key) != nullptr) fail("'" + key + "' is given twice");
    options_.emplace_back(key, option.substr(equals + 1));
    begin = end + 1;
  }
}

void PolicySpecification::expectKeys(const std::vector<std::string>& keys) const {
  for (const auto& [key, value] : options_) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    fail("unknown key '" + key + "', expected " +
         (keys.empty() ? "no options" : alternatives(keys)));
  }
}

double PolicySpecification::number(const std::string& key, double fallback, double min,
                                   double max) const {
  const std::string* given = find(key);
  if (given == nullptr) return fallback;
  double value = std::numeric_limits<double>::quiet_NaN();
  const char* const end = given->data() + given->size();
  const auto result = std::from_chars(given->data(), end, value);
  // The negated comparison also catches NaN.
  if (result.ec != std::errc() || result.ptr != end || !(value >= min && value <= max)) {
    fail(key + " is '" + *given + "', expected a number from " + numberText(min) + " to " +
         numberText(max));
  }
  return value;
}

std::string PolicySpecification::word(const std::string& key,
                                      const std::vector<std::string>& words) const {
  const std::string* given = find(key);
  if (given == nullptr) return words.front();
  if (std::find(words.begin(), words.end(), *given) == words.end()) {
    fail(key + " is '" + *given + "', expected " + alternatives(words));
  }
  return *given;
}

uint32_t PolicySpecification::color(const std::string& key) const {
  const std::string* given = find(key);
  if (given == nullptr) fail("'" + key + "' is missing, expected " + key + "=#rrggbb");
  const bool is_color = given->size() == 7 && given->front() == '#' &&
                        given->find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
  if (!is_color) fail(key + " is '" + *given + "', expected #rrggbb in hexadecimal digits");
  return static_cast<uint32_t>(std::stoul(given->substr(1), nullptr, 16));
}

void PolicySpecification::fail(const std::string& message) const {
  throw std::invalid_argument("policy '" + text_ + "': " + message);
}

const std::string* PolicySpecification::find(const std::string& key) const {
  const auto it = std::find_if(options_.begin(), options_.end(),
                               [&](const auto& option) { return option.first == key; });
  return it == options_.end() ? nullptr : &it->second;
}

std::string numberText(double value) {
  std::array<char, 32> text{};
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), result.ptr};
}

std::string alternatives(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += words[i];
  }
  return text;
}

}  // namespace ladar_perception
