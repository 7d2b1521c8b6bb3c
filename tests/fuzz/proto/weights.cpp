// The broadcast policy. Input: version, layout, checksum flag, parameters.
#include "proto/weights.h"

#include <cmath>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

constexpr size_t kParameters = 16;
constexpr uint64_t kLayout = 0x1234;

Bytes Input(uint32_t version, uint64_t layout, const std::vector<float>& parameters) {
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.Put(version);
  writer.Put(layout);
  writer.Put(uint8_t{1});
  writer.PutBytes(std::as_bytes(std::span(parameters)));
  return bytes;
}

}  // namespace

const int kMutants = 100000;

bool Check(std::span<std::byte> input) {
  ByteReader reader(input);
  dadrl_idl_Weights weights{};
  weights.version = reader.Get<uint32_t>();
  weights.layout_hash = reader.Get<uint64_t>();
  const bool fits = reader.Get<uint8_t>() == 1;
  if (!reader.ok()) return false;
  const auto parameters = input.last(reader.remaining());
  weights.checksum = Xxh3(parameters) ^ (fits ? 0 : 1);
  weights.parameters._buffer = reinterpret_cast<uint8_t*>(parameters.data());
  weights.parameters._length = static_cast<uint32_t>(parameters.size());
  if (!CheckWeights(weights, kParameters, kLayout)) return false;
  Require(weights.version > 0 && weights.layout_hash == kLayout && fits);
  ByteReader values(parameters);
  for (size_t i = 0; i < kParameters; ++i) Require(std::abs(values.Get<float>()) <= kMaxParameter);
  Require(values.ok() && values.remaining() == 0);
  return true;
}

Seeds MakeSeeds() {
  std::vector<float> parameters(kParameters, 0.25f);
  Seeds seeds{.accepted = {Input(7, kLayout, parameters)},
              .refused = {Input(0, kLayout, parameters), Input(7, kLayout + 1, parameters)}};
  for (const float impossible : {static_cast<float>(NAN), 3e38f}) {
    parameters.back() = impossible;
    seeds.refused.push_back(Input(7, kLayout, parameters));
  }
  return seeds;
}

}  // namespace dadrl::fuzz
