// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "io_test_files.h"
#include "ladar_perception/learn/truth_reader.h"

namespace ladar_perception {
namespace {

using Values = std::vector<double>;

Scan scanWith(const std::string& field, const Values& values) {
  const Values zeros(values.size(), 0.0);
  return makeScan({{"x", ScalarType::kFloat32, zeros},
                   {"y", ScalarType::kFloat32, zeros},
                   {"z", ScalarType::kFloat32, zeros},
                   {field, ScalarType::kFloat32, values}});
}

Values read(const TruthReader& reader, const Scan& scan) {
  return reader.read({scan.layout, scan.data.data(), scan.data.size()});
}

ClassMapping mappingOf(const std::vector<std::string>& names) {
  ClassMapping mapping;
  for (const std::string& name : names) {
    mapping.names.push_back(name);
    const auto truth = static_cast<uint8_t>(mapping.names.size());
    mapping.truth_of_label[10u * truth] = truth;
  }
  return mapping;
}

TEST(LearnTruthReader, MatchesClassesByName) {
  const TruthReader reader(mappingOf({"wall", "bush"}), "label", {"bush", "pole", "wall"});
  EXPECT_EQ(read(reader, scanWith("label", {10, 20, 30, 0})), (Values{3, 1, 0, 0}));
}

TEST(LearnTruthReader, RefusesAClassTheModelDoesNotKnow) {
  expectError(
      [] {
        TruthReader(mappingOf({"wall", "lake"}), "label", {"wall", "bush"});
      },
      {"'lake'", "wall, bush"});
}

TEST(LearnTruthReader, TruthFieldCountsClassesOfTheModel) {
  const TruthReader reader({"a", "b", "c", "d"});
  EXPECT_EQ(read(reader, scanWith("truth", {0, 4, 1, 2})), (Values{0, 4, 1, 2}));
  expectError(
      [&] {
        read(reader, scanWith("truth", {1, 5}));
      },
      {"'truth'", "point 1", "5", "4 classes", "--classes"});
}

TEST(LearnTruthReader, TruthOfTerrainIsByNameToo) {
  const TruthReader reader({"linear", "surface", "scatter"});
  // 1 surface, 2 scatter, 3 linear.
  EXPECT_EQ(read(reader, scanWith("truth", {1, 2, 3, 0})), (Values{2, 3, 1, 0}));
}

TEST(LearnTruthReader, NamesWhatIsMissingOrWrong) {
  const TruthReader by_truth({"a", "b"});
  expectError([&] { read(by_truth, scanWith("label", {1})); },
              {"no field 'truth'", "--classes", "label:float32"});
  const TruthReader by_label(mappingOf({"a", "b"}), "kind", {"a", "b"});
  expectError([&] { read(by_label, scanWith("label", {1})); }, {"no field 'kind'", "label"});
  expectError(
      [&] {
        read(by_label, scanWith("kind", {10, 2.5}));
      },
      {"'kind'", "point 1", "2.5", "integer"});
  expectError([&] { read(by_label, scanWith("kind", {-1})); }, {"point 0", "-1"});
  expectError([&] { read(by_label, scanWith("kind", {std::nan("")})); }, {"point 0", "nan"});
}

}  // namespace
}  // namespace ladar_perception
