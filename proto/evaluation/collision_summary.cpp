#include "proto/evaluation/collision_summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace dadrl {
namespace {

constexpr double kStandingSpeed = 0.5;
constexpr double kSameWay = std::numbers::pi / 4;
constexpr double kOncoming = 3 * std::numbers::pi / 4;

constexpr std::array<std::string_view, 4> kSideNames = {"front", "left", "right", "rear"};
constexpr std::array<std::string_view, 4> kChangerNames = {"nobody", "ego", "other", "both"};

template <typename Enum>
std::optional<Enum> FromName(const std::array<std::string_view, 4>& names, std::string_view name) {
  const auto it = std::ranges::find(names, name);
  if (it == names.end()) return std::nullopt;
  return static_cast<Enum>(it - names.begin());
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

std::string_view ContactSideName(ContactSide side) { return kSideNames[static_cast<size_t>(side)]; }
std::optional<ContactSide> ContactSideFromName(std::string_view name) {
  return FromName<ContactSide>(kSideNames, name);
}
std::string_view LaneChangerName(LaneChanger changer) { return kChangerNames[static_cast<size_t>(changer)]; }
std::optional<LaneChanger> LaneChangerFromName(std::string_view name) {
  return FromName<LaneChanger>(kChangerNames, name);
}

}  // namespace dadrl
