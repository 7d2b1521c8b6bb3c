// Networks by name: what an algorithm trains, and what a policy file holds.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace dadrl {

// The network that acts; every algorithm has it.
constexpr std::string_view kPolicyNetwork = "policy";
// Two values of observation and action (CriticNetwork).
constexpr std::string_view kCriticNetwork = "critic";

// Borrows name and parameters.
struct NamedNetwork {
  std::string_view name;              // of up to 64 small letters, digits and underscores
  uint64_t layout_hash = 0;           // of the flat parameter vector (nn::ParamLayout)
  std::span<const float> parameters;  // all finite
};

}  // namespace dadrl
