// One frame's payload: histories and planes.
#include <cmath>
#include <cstring>
#include <limits>

#include "proto/experience.h"
#include "tests/driving_columns.h"
#include "tests/fuzz/harness.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl::fuzz {
namespace {
// Without bounds, so that everything finite is taken.
const StepSpec kSpec = [] {
  StepSpec spec = DrivingStepSpec(DrivingShape{});
  for (ColumnSpec& column : spec.observation) column.bound = std::numeric_limits<float>::max();
  return spec;
}();
}  // namespace

const int kMutants = 100000;

bool Check(std::span<std::byte> input) {
  static PayloadCodec codec(kSpec, FloatCoding::kFloat16);
  static PayloadCodec exact(kSpec, FloatCoding::kFloat32);
  Observation observation(kSpec);
  if (!codec.Decode(input, observation)) return false;
  for (const auto values : {VehiclesOf(observation), EgoOf(observation)}) {
    for (const float value : values) Require(std::isfinite(value));
  }
  // Whatever was decoded is an observation like any other.
  Bytes again;
  exact.Encode(observation, again);
  Require(again.size() <= exact.max_payload_bytes());
  Observation copy(kSpec);
  Require(exact.Decode(again, copy).has_value());
  for (const auto of :
       {+[](const Columns& c) { return VehiclesOf(c); }, +[](const Columns& c) { return EgoOf(c); }}) {
    Require(std::memcmp(of(copy).data(), of(observation).data(), of(copy).size_bytes()) == 0);
  }
  Require(std::ranges::equal(ContextOf(copy), ContextOf(observation)));
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds;
  Random random(1);
  for (const FloatCoding coding : {FloatCoding::kFloat16, FloatCoding::kFloat32}) {
    PayloadCodec codec(kSpec, coding);
    for (const Observation& observation : {SyntheticObservation(DrivingShape{}, random),
                                           NoiseObservation(DrivingShape{}, random), Observation(kSpec)}) {
      codec.Encode(observation, seeds.accepted.emplace_back());
    }
  }
  return seeds;
}

}  // namespace dadrl::fuzz
