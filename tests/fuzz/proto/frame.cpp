// One frame's payload: histories and planes.
#include <cmath>
#include <cstring>

#include "proto/experience.h"
#include "tests/fuzz/harness.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl::fuzz {
namespace {
const ObservationSpec kSpec;
}  // namespace

const int kMutants = 100000;

bool Check(std::span<std::byte> input) {
  static FrameCodec codec(kSpec, FloatCoding::kFloat16);
  static FrameCodec exact(kSpec, FloatCoding::kFloat32);
  Observation observation(kSpec);
  if (!codec.Decode(input, observation.vehicles, observation.ego, observation.context)) return false;
  for (const auto* values : {&observation.vehicles, &observation.ego}) {
    for (const float value : *values) Require(std::isfinite(value));
  }
  // Whatever was decoded is an observation like any other.
  Bytes again;
  exact.Encode(observation, again);
  Require(again.size() <= exact.max_payload_bytes());
  Observation copy(kSpec);
  Require(exact.Decode(again, copy.vehicles, copy.ego, copy.context).has_value());
  Require(std::memcmp(copy.ego.data(), observation.ego.data(), copy.ego.size() * sizeof(float)) == 0);
  Require(std::memcmp(copy.vehicles.data(), observation.vehicles.data(),
                      copy.vehicles.size() * sizeof(float)) == 0);
  Require(copy.context == observation.context);
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds;
  Random random(1);
  for (const FloatCoding coding : {FloatCoding::kFloat16, FloatCoding::kFloat32}) {
    FrameCodec codec(kSpec, coding);
    for (const Observation& observation :
         {SyntheticObservation(kSpec, random), NoiseObservation(kSpec, random), Observation(kSpec)}) {
      codec.Encode(observation, seeds.accepted.emplace_back());
    }
  }
  return seeds;
}

}  // namespace dadrl::fuzz
