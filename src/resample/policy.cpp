// SPDX-License-Identifier: BSD-3-Clause
#include "ladar_perception/resample/policy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "policy_specification.h"

namespace ladar_perception {
namespace {

constexpr double kMaxRange_m = 1e6;
constexpr double kMaxSoftness = 1e3;  // the colours farthest apart are at 442

/// Multiplies a weight, which stays a float greater than 0 whatever comes together.
void scale(double factor, float* weight) {
  constexpr double kLeast = std::numeric_limits<float>::min();
  constexpr double kGreatest = std::numeric_limits<float>::max();
  *weight =
      static_cast<float>(std::clamp(factor * static_cast<double>(*weight), kLeast, kGreatest));
}

/// Refuses a cloud in which not every point has the field.
void expectField(const Policy& policy, const PointAttributes& points, const char* field,
                 std::size_t size) {
  if (size == points.size()) return;
  std::string there = "x, y, z";
  if (!points.rgb.empty()) there += ", rgb";
  if (!points.labels.empty()) there += ", label";
  throw std::runtime_error("policy '" + policy.describe() + "' needs the field '" + field +
                           "' of every point; the cloud has " + there);
}

class UniformPolicy : public Policy {
 public:
  std::string describe() const override { return "uniform"; }
  void multiply(const PointAttributes& /*points*/, std::vector<float>* /*weights*/) const override {
  }
};

class RangePolicy : public Policy {
 public:
  explicit RangePolicy(double min_m) : min_m_(min_m) {}

  std::string describe() const override { return "range:min=" + numberText(min_m_); }

  void multiply(const PointAttributes& points, std::vector<float>* weights) const override {
    if (!points.sensor_m.allFinite()) {
      throw std::runtime_error("policy '" + describe() +
                               "' needs the sensor's place, which is not finite");
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double squared_range = (points.positions_m[i] - points.sensor_m).squaredNorm();
      scale(1.0 / std::max(squared_range, min_m_ * min_m_), &(*weights)[i]);
    }
  }

 private:
  double min_m_;
};

/// Counts of values by their leading bits: floats that are not negative are in the order of their
/// bits. Values of one bin, which differ by less than 1 in 2000, count as equal.
class RankHistogram {
 public:
  RankHistogram() : below_(kBins, 0) {}

  void add(float value) {
    ++below_[bin(value)];
    ++count_;
  }
  /// From counts to the doubled mean rank of each bin's values.
  void finish() {
    uint64_t below = 0;
    for (uint64_t& entry : below_) {
      const uint64_t here = entry;
      entry = 2 * below + here - (here > 0 ? 1 : 0);
      below += here;
    }
  }
  /// Mean rank of the values that are equal to this one, from 0 for the least to 1.
  double rank(float value) const {
    if (count_ < 2) return 0.5;
    return static_cast<double>(below_[bin(value)]) / (2.0 * static_cast<double>(count_ - 1));
  }

 private:
  static constexpr int kDroppedBits = 12;
  static constexpr std::size_t kBins = std::size_t{1} << (31 - kDroppedBits);

  static std::size_t bin(float value) {
    const float not_negative = std::max(0.0f, value);
    uint32_t bits = 0;
    std::memcpy(&bits, &not_negative, sizeof bits);
    return bits >> kDroppedBits;
  }

  std::vector<uint64_t> below_;
  uint64_t count_ = 0;
};

/// The variation is histogram-equalised: otherwise a few points that vary much would use up the
/// range of the weights and leave all the others with nearly the same.
class NormalVariationPolicy : public Policy {
 public:
  NormalVariationPolicy(bool attract, double ratio) : attract_(attract), ratio_(ratio) {}

  std::string describe() const override {
    return std::string("normal_variation:mode=") + (attract_ ? "attract" : "inhibit") +
           ",ratio=" + numberText(ratio_);
  }
  bool needsNormals() const override { return true; }

  void multiply(const PointAttributes& points, std::vector<float>* weights) const override {
    expectField(*this, points, "normal", points.normals.size());
    expectField(*this, points, "normal_variation", points.normal_variation.size());
    RankHistogram histogram;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (hasVariation(points, i)) histogram.add(points.normal_variation[i]);
    }
    histogram.finish();
    for (std::size_t i = 0; i < points.size(); ++i) {
      // Where there is no normal nobody knows how it varies: the weight of the middle.
      const double rank =
          hasVariation(points, i) ? histogram.rank(points.normal_variation[i]) : 0.5;
      scale(1.0 + (ratio_ - 1.0) * (attract_ ? rank : 1.0 - rank), &(*weights)[i]);
    }
  }

 private:
  static bool hasVariation(const PointAttributes& points, std::size_t i) {
    return std::isfinite(points.normal_variation[i]) && !points.normals[i].isZero(0.0f);
  }

  bool attract_;
  double ratio_;
};

class ColorPolicy : public Policy {
 public:
  ColorPolicy(uint32_t target, double softness, double ratio)
      : target_(target), softness_(softness), ratio_(ratio) {}

  std::string describe() const override {
    constexpr const char* kDigits = "0123456789abcdef";
    std::string hex;
    for (int shift = 20; shift >= 0; shift -= 4) hex += kDigits[(target_ >> shift) & 0xfu];
    return "color:target=#" + hex + ",softness=" + numberText(softness_) +
           ",ratio=" + numberText(ratio_);
  }

  void multiply(const PointAttributes& points, std::vector<float>* weights) const override {
    expectField(*this, points, "rgb", points.rgb.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double x =
          static_cast<double>(squaredDistance(points.rgb[i])) / (softness_ * softness_);
      // Flat at the target and far from it, steepest near the softness, where half is left. Not an
      // exponential: its bits differ from one C library to another.
      scale(1.0 + (ratio_ - 1.0) / (1.0 + x * x), &(*weights)[i]);
    }
  }

 private:
  int squaredDistance(uint32_t rgb) const {
    int sum = 0;
    for (int shift = 0; shift <= 16; shift += 8) {
      const int difference =
          static_cast<int>((rgb >> shift) & 0xffu) - static_cast<int>((target_ >> shift) & 0xffu);
      sum += difference * difference;
    }
    return sum;
  }

  uint32_t target_;
  double softness_;
  double ratio_;
};

class LabelPolicy : public Policy {
 public:
  /// Factors by label; those of labels that have a name.
  LabelPolicy(std::string description, std::vector<double> factors)
      : description_(std::move(description)), factors_(std::move(factors)) {}

  std::string describe() const override { return description_; }

  void multiply(const PointAttributes& points, std::vector<float>* weights) const override {
    expectField(*this, points, "label", points.labels.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::size_t label = points.labels[i];
      // Labels of another classifier would be taken for classes that they are not.
      if (label >= factors_.size()) {
        throw std::runtime_error("policy '" + describe() + "': point " + std::to_string(i) +
                                 " has the label " + std::to_string(label) + ", but only " +
                                 std::to_string(factors_.size() - 1) + " classes have names");
      }
      scale(factors_[label], &(*weights)[i]);
    }
  }

 private:
  std::string description_;
  std::vector<double> factors_;
};

class CallablePolicy : public Policy {
 public:
  using Weight = std::function<double(const PointAttributes&, std::size_t)>;

  CallablePolicy(std::string name, Weight weight, bool needs_normals)
      : name_(std::move(name)), weight_(std::move(weight)), needs_normals_(needs_normals) {}

  std::string describe() const override { return name_; }
  bool needsNormals() const override { return needs_normals_; }

  void multiply(const PointAttributes& points, std::vector<float>* weights) const override {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double weight = weight_(points, i);
      // The negated comparison also catches NaN.
      if (!(weight > 0.0 && std::isfinite(weight))) {
        throw std::runtime_error("policy '" + name_ + "': the weight of point " +
                                 std::to_string(i) + " is " + numberText(weight) +
                                 ", expected a finite number greater than 0");
      }
      scale(weight, &(*weights)[i]);
    }
  }

 private:
  std::string name_;
  Weight weight_;
  bool needs_normals_;
};

std::shared_ptr<const Policy> makeLabelPolicy(const PolicySpecification& specification,
                                              const std::vector<std::string>& class_names) {
  std::vector<std::string> names = {"unknown"};
  names.insert(names.end(), class_names.begin(), class_names.end());
  specification.expectKeys(names);
  if (specification.options().empty()) {
    specification.fail("no factors, expected class=factor of " + alternatives(names));
  }
  std::string description = "label:";
  std::vector<double> factors;
  for (const std::string& name : names) {
    factors.push_back(specification.number(name, 1.0, kLeastFactor, kGreatestFactor));
  }
  for (const auto& [name, value] : specification.options()) {
    const auto label = std::find(names.begin(), names.end(), name) - names.begin();
    if (description.back() != ':') description += ',';
    description += name + "=" + numberText(factors[static_cast<std::size_t>(label)]);
  }
  return std::make_shared<LabelPolicy>(description, std::move(factors));
}

}  // namespace

std::shared_ptr<const Policy> makePolicy(const std::string& specification,
                                         const std::vector<std::string>& class_names) {
  const PolicySpecification given(specification);
  if (given.name() == "uniform") {
    given.expectKeys({});
    return std::make_shared<UniformPolicy>();
  }
  if (given.name() == "range") {
    given.expectKeys({"min"});
    return std::make_shared<RangePolicy>(given.number("min", 3.0, 1e-3, kMaxRange_m));
  }
  if (given.name() == "normal_variation") {
    given.expectKeys({"mode", "ratio"});
    const bool attract = given.word("mode", {"attract", "inhibit"}) == "attract";
    return std::make_shared<NormalVariationPolicy>(
        attract, given.number("ratio", 16.0, 1.0, kGreatestFactor));
  }
  if (given.name() == "color") {
    given.expectKeys({"target", "softness", "ratio"});
    return std::make_shared<ColorPolicy>(
        given.color("target"), given.number("softness", 40.0, 1.0, kMaxSoftness),
        given.number("ratio", 16.0, kLeastFactor, kGreatestFactor));
  }
  if (given.name() == "label") return makeLabelPolicy(given, class_names);
  given.fail("unknown policy '" + given.name() + "', expected " +
             alternatives({"uniform", "range", "normal_variation", "color", "label"}));
}

std::shared_ptr<const Policy> makePolicy(
    std::string name, std::function<double(const PointAttributes&, std::size_t)> weight,
    bool needs_normals) {
  if (name.empty()) throw std::invalid_argument("policy of a callable: it needs a name");
  if (!weight) throw std::invalid_argument("policy '" + name + "': the callable is empty");
  return std::make_shared<CallablePolicy>(std::move(name), std::move(weight), needs_normals);
}

}  // namespace ladar_perception
