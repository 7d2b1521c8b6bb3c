// Columns as JSON, as they stand beside stored and exported experience.
#include "common/io/json_text.h"
#include "common/step/driving_shape.h"
#include "common/step/step_spec_json.h"
#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {

const int kMutants = 30000;

bool Check(std::span<std::byte> input) {
  const auto json = ParseJson(AsText(input), "columns");
  if (!Accepted(json)) return false;
  const auto spec = StepSpecFromJson(*json, "columns");
  if (!Accepted(spec)) return false;
  // What a reader takes memory for.
  size_t elements = 0;
  for (const auto* columns : {&spec->observation, &spec->decision}) {
    for (const ColumnSpec& column : *columns) {
      Require(column.name.find_first_of("./") == std::string::npos && column.bound >= 0.0f);
      elements += column.elements();
    }
  }
  Require(elements <= kMaxStepElements);
  Require(spec->decision_floats() >= 1 && spec->decision_floats() <= kMaxDecisionFloats);
  Require(StepSpecFromJson(StepSpecToJson(*spec), "columns") == *spec);
  Require(SchemaHash(*spec) == SchemaHash(*spec));
  return true;
}

Seeds MakeSeeds() {
  StepSpec spec = DrivingStepSpec(DrivingShape{});
  const std::string driving = StepSpecToJson(spec).dump();
  spec.observation.push_back({.name = "gap", .codec = ColumnCodec::kHalf, .bound = 2.0f});
  spec.decision.push_back({.name = "log_probability"});
  Seeds seeds{.accepted = {AsBytes(driving), AsBytes(StepSpecToJson(spec).dump(2))}, .refused = BadJson()};
  for (const auto& [from, to] : {std::pair{"[2]", "[1025]"},
                                 {"[2]", "[16777216]"},
                                 {"[2]", "[1,1,1,1,1,1,1,1,1]"},
                                 {"[5,20]", "[4294967297,20]"},
                                 {"[5,20]", "[18446744073709551615,1]"},
                                 {"[5,20]", "[5,1e2]"},
                                 {"\"raw\"", "\"half\""},
                                 {"\"ego\"", "\"reward\\u0000s\""},
                                 {"\"ego\"", "\"rewards\""},
                                 {"\"decision\":[", "\"decision\":[],\"other\":["}}) {
    std::string bad = driving;
    bad.replace(bad.find(from), std::string_view(from).size(), to);
    seeds.refused.push_back(AsBytes(bad));
  }
  // Each column is small enough, all of them take 32 GB.
  std::string many;
  for (int i = 0; i < 256; ++i) {
    many += fmt::format(R"({}{{"name":"c{}","type":"float32","shape":[16777216],"codec":"raw","bound":1}})",
                        i == 0 ? "" : ",", i);
  }
  seeds.refused.push_back(AsBytes(fmt::format(
      R"({{"observation":[{}],"decision":[{{"name":"a","type":"float32","shape":[],"codec":"raw","bound":1}}]}})",
      many)));
  return seeds;
}

}  // namespace dadrl::fuzz
