#include "proto/evaluation/collision_summary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/enum_array.h"

namespace dadrl {
namespace {

constexpr double kStandingSpeed = 0.5;
constexpr double kSameWay = std::numbers::pi / 4;
constexpr double kOncoming = 3 * std::numbers::pi / 4;

constexpr EnumArray<ContactSide, std::string_view, 4> kSideNames = {"front", "left", "right", "rear"};
constexpr EnumArray<LaneChanger, std::string_view, 4> kChangerNames = {"nobody", "ego", "other", "both"};

template <typename Enum>
std::optional<Enum> FromName(const EnumArray<Enum, std::string_view, 4>& names, std::string_view name) {
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return names.At(i);
  }
  return std::nullopt;
}

}  // namespace

std::string_view CollisionKind(const CollisionSummary& collision) {
  const double turn = std::abs(collision.relative_heading_rad);
  const bool same_way = turn <= kSameWay;
  if (collision.ego_speed_mps < kStandingSpeed) return "standing";
  if (same_way && collision.side == ContactSide::kRear) return "rear_ended";
  if (collision.lane_changer != LaneChanger::kNobody) return "lane_change";
  if (same_way) return collision.side == ContactSide::kFront ? "ran_into" : "side_by_side";
  return turn >= kOncoming ? "oncoming" : "crossing";
}

std::string_view ContactSideName(ContactSide side) { return kSideNames[side]; }
std::optional<ContactSide> ContactSideFromName(std::string_view name) { return FromName(kSideNames, name); }
std::string_view LaneChangerName(LaneChanger changer) { return kChangerNames[changer]; }
std::optional<LaneChanger> LaneChangerFromName(std::string_view name) {
  return FromName(kChangerNames, name);
}

}  // namespace dadrl
