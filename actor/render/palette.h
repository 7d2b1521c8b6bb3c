// Colours of the pictures: Okabe and Ito's set for the things that mean something, which colour-blind readers
// can tell apart, and greys for the rest. Nothing is said by colour alone.
#pragma once

namespace dadrl::colour {

inline constexpr const char* kEgo = "#0072b2";        // blue: the ego, what it does
inline constexpr const char* kRoute = "#56b4e9";      // sky blue: where it should go
inline constexpr const char* kAttention = "#e69f00";  // orange: what the policy looks at
inline constexpr const char* kHarm = "#d55e00";       // vermilion: collisions, negative reward
inline constexpr const char* kGood = "#009e73";       // green: the goal

inline constexpr const char* kInk = "#1f2329";
inline constexpr const char* kFaint = "#6d747d";
inline constexpr const char* kLine = "#c9ced4";
inline constexpr const char* kPaper = "#ffffff";
inline constexpr const char* kGround = "#e9ece6";
inline constexpr const char* kAsphalt = "#7b828a";
inline constexpr const char* kMarking = "#f4f5f2";
inline constexpr const char* kCentreLine = "#f0c75e";
inline constexpr const char* kCar = "#f1f2f4";

}  // namespace dadrl::colour
