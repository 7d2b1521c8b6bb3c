// An algorithm's state by the names of its blocks, and as a whole.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "learner/algorithms/algorithm.h"

namespace dadrl {

inline std::span<std::byte> BlockOf(Algorithm& algorithm, const std::string& name) {
  for (const StateBlock& block : algorithm.state()) {
    if (block.name == name) return block.bytes;
  }
  ADD_FAILURE() << "no state " << name;
  return {};
}

inline std::span<float> FloatsOf(Algorithm& algorithm, const std::string& name) {
  const std::span<std::byte> bytes = BlockOf(algorithm, name);
  return {reinterpret_cast<float*>(bytes.data()), bytes.size() / sizeof(float)};
}

// All state in one piece.
inline std::vector<std::byte> Snapshot(Algorithm& algorithm) {
  std::vector<std::byte> all;
  for (const StateBlock& block : algorithm.state())
    all.insert(all.end(), block.bytes.begin(), block.bytes.end());
  return all;
}

inline void Restore(Algorithm& algorithm, const std::vector<std::byte>& snapshot) {
  size_t at = 0;
  for (const StateBlock& block : algorithm.state()) {
    std::memcpy(block.bytes.data(), snapshot.data() + at, block.bytes.size());
    at += block.bytes.size();
  }
  EXPECT_EQ(at, snapshot.size());
}

}  // namespace dadrl
