#include "common/step/step_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/step/driving_shape.h"
#include "common/step/first_format.h"
#include "common/step/step_spec_json.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

StepSpec WithAGap() {
  StepSpec spec = DrivingStepSpec(DrivingShape{});
  spec.observation.push_back({"gap", ElementType::kFloat32, {}, ColumnCodec::kRaw, 1.0f});
  return spec;
}

// What segments of earlier versions carry.
TEST(SchemaHash, OfTheFirstFormatsStepsIsWhatItWas) {
  EXPECT_EQ(SchemaHash(DrivingShape{6, 5}), 0xf5600e3bac1cca0cU);
  EXPECT_EQ(SchemaHash(DrivingShape{1, 1}), 0x2ccc6686f3a55683U);
  const StepSpec first = SpecOfFirstFormat(0xf5600e3bac1cca0cU).value();
  EXPECT_EQ(SchemaHash(first), 0xf5600e3bac1cca0cU);
  // Whatever the columns of driving come to be.
  EXPECT_EQ(ColumnsText(first.observation),
            "vehicles float32 [6, 5, 7], ego float32 [5, 20], context bit [2, 128, 128]");
  EXPECT_EQ(ColumnsText(first.decision), "action float32 [2]");
  EXPECT_EQ(SpecOfFirstFormat(1), std::nullopt);
}

TEST(SchemaHash, FollowsEachPropertyOfEachColumnAndNotItsBound) {
  const StepSpec spec = WithAGap();
  const auto changed = [&](auto change) {
    StepSpec other = spec;
    change(other);
    return SchemaHash(other) != SchemaHash(spec);
  };
  EXPECT_FALSE(changed([](StepSpec&) {}));
  EXPECT_FALSE(changed([](StepSpec& s) { s.observation[3].bound = 7.0f; }));
  EXPECT_TRUE(changed([](StepSpec& s) { s.observation[3].name = "cap"; }));
  EXPECT_TRUE(changed([](StepSpec& s) { s.observation[3].type = ElementType::kBit; }));
  EXPECT_TRUE(changed([](StepSpec& s) { s.observation[3].shape = {1}; }));
  EXPECT_TRUE(changed([](StepSpec& s) { s.observation[3].codec = ColumnCodec::kHalf; }));
  EXPECT_TRUE(changed([](StepSpec& s) { s.observation.pop_back(); }));
  EXPECT_TRUE(changed([](StepSpec& s) { s.decision.push_back({.name = "log_probability"}); }));
  EXPECT_TRUE(changed([](StepSpec& s) { std::swap(s.observation[0], s.observation[1]); }));
}

TEST(StepSpec, ColumnsAreFoundByNameOrRefusedWithAllThatIsThere) {
  const StepSpec spec = WithAGap();
  EXPECT_EQ(FindColumn(spec.observation, "gap", ElementType::kFloat32, 0).value(), 3u);
  for (const auto& [name, type, dimensions] : {std::tuple{"cap", ElementType::kFloat32, size_t{0}},
                                               {"gap", ElementType::kBit, size_t{0}},
                                               {"gap", ElementType::kFloat32, size_t{1}}}) {
    const auto missing = FindColumn(spec.observation, name, type, dimensions);
    ASSERT_FALSE(missing);
    EXPECT_THAT(missing.error().message,
                HasSubstr("vehicles float32 [6, 5, 7], ego float32 [5, 20], context bit [2, 128, 128], gap"));
  }
}

TEST(DrivingShape, IsFoundAmongOtherColumnsAndNotWhereOneIsMissingOrOfAnotherShape) {
  StepSpec spec = DrivingStepSpec(DrivingShape{.vehicles = 3, .history = 2});
  spec.observation.insert(spec.observation.begin(), {.name = "gap"});
  const DrivingShape shape = DrivingShape::Find(spec).value();
  EXPECT_EQ(shape,
            (DrivingShape{
                .vehicles = 3, .history = 2, .vehicles_column = 1, .ego_column = 2, .context_column = 3}));
  spec.observation[2].shape = {2, 19};
  EXPECT_FALSE(DrivingShape::Find(spec));
  spec.observation[2].shape = {2, 20};
  spec.observation.erase(spec.observation.begin() + 1);
  EXPECT_FALSE(DrivingShape::Find(spec));
}

TEST(DrivingShape, HasPolylinesWhereTheStepsHaveThem) {
  StepSpec spec = DrivingStepSpec(DrivingShape{.vehicles = 3, .polylines = true});
  EXPECT_NE(SchemaHash(spec), SchemaHash(DrivingStepSpec(DrivingShape{.vehicles = 3})));
  spec.observation.insert(spec.observation.begin(), {.name = "gap"});
  const DrivingShape shape = DrivingShape::Find(spec).value();
  EXPECT_TRUE(shape.polylines);
  EXPECT_EQ(shape.polylines_column, 4u);
  spec.observation[4].shape = {8, 9, 5};
  EXPECT_FALSE(DrivingShape::Find(spec));
}

TEST(StepSpec, ImpossibleColumnsAreRefused) {
  EXPECT_TRUE(CheckSpec(WithAGap()));
  const ColumnSpec bad[] = {
      {.name = ""},
      {.name = "../gap"},
      {.name = "ego"},
      {.name = "rewards"},
      {.name = "\x1b[2J"},
      {.name = "gap", .shape = {1 << 24}},
      {.name = "gap", .shape = {0}},
      {.name = "gap", .shape = {1 << 20, 1 << 20, 1 << 20, 1 << 20}},
      {.name = "gap", .shape = {3}, .codec = ColumnCodec::kHistory},
      {.name = "gap", .shape = {65, 3}, .codec = ColumnCodec::kHistory},
      {.name = "gap", .shape = {2, 128, 128}, .codec = ColumnCodec::kBitPlanes},
      {.name = "gap", .type = ElementType::kBit, .codec = ColumnCodec::kHalf},
  };
  for (const ColumnSpec& column : bad) {
    StepSpec spec = DrivingStepSpec(DrivingShape{});
    spec.observation.push_back(column);
    EXPECT_FALSE(CheckSpec(spec)) << ColumnsText({column});
  }
  StepSpec spec = WithAGap();
  spec.decision.push_back({.name = "half", .codec = ColumnCodec::kHalf});
  EXPECT_FALSE(CheckSpec(spec));
  spec = WithAGap();
  spec.decision.push_back({.name = "many", .shape = {kMaxDecisionFloats}});
  EXPECT_FALSE(CheckSpec(spec));
  spec.decision.clear();
  EXPECT_FALSE(CheckSpec(spec));
}

TEST(StepSpecJson, ComesBackAsItWas) {
  const StepSpec spec = WithAGap();
  EXPECT_EQ(StepSpecFromJson(StepSpecToJson(spec), "x").value(), spec);
}

TEST(StepSpecJson, WhatIsNoSpecIsRefusedWithItsPlace) {
  using Json = nlohmann::ordered_json;
  const auto error = [](auto change) {
    Json json = StepSpecToJson(WithAGap());
    change(json);
    const auto read = StepSpecFromJson(json, "columns.json");
    return read ? std::string() : read.error().message;
  };
  EXPECT_THAT(error([](Json& j) { j = 5; }), HasSubstr("columns.json: describes no columns"));
  EXPECT_THAT(error([](Json& j) { j.erase("decision"); }), HasSubstr("'decision'"));
  EXPECT_THAT(error([](Json& j) { j["observation"][1]["shape"] = {-1}; }), HasSubstr("'shape'"));
  EXPECT_THAT(error([](Json& j) { j["observation"][1]["codec"] = "zip"; }), HasSubstr("'codec'"));
  EXPECT_THAT(error([](Json& j) { j["observation"][1]["type"] = 3; }), HasSubstr("'type'"));
  EXPECT_THAT(error([](Json& j) { j["observation"][1]["bound"] = -1; }), HasSubstr("'bound'"));
  EXPECT_THAT(error([](Json& j) { j["observation"][1]["name"] = "a/b"; }), HasSubstr("column name 'a/b'"));
}

}  // namespace
}  // namespace dadrl
