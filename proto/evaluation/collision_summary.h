// How an episode's collision came about: what it takes to count failures by kind.
#pragma once

#include <optional>
#include <string_view>

namespace dadrl {

// Where the ego was touched, in its own frame.
enum class ContactSide { kFront, kLeft, kRight, kRear };
// Who was leaving its lane, outside junctions.
enum class LaneChanger { kNobody, kEgo, kOther, kBoth };

struct CollisionSummary {
  ContactSide side = ContactSide::kFront;
  double ego_speed_mps = 0.0;
  double other_speed_mps = 0.0;
  double relative_heading_rad = 0.0;  // of the other: 0 the same way, +-pi/2 crossing, pi oncoming
  bool junction = false;              // the ego's nearest lane is inside a junction
  LaneChanger lane_changer = LaneChanger::kNobody;

  bool operator==(const CollisionSummary&) const = default;
};

// One word for the kind of a collision. The first that applies:
//   standing      the ego was slower than 0.5 m/s: it was hit, whatever it had done before
//   rear_ended    touched from behind by a vehicle on about its own heading (within 45 degrees)
//   lane_change   someone was leaving its lane, outside junctions
//   ran_into      touched in front, both on about the same heading
//   side_by_side  touched at the side, both on about the same heading
//   oncoming      headings at least 135 degrees apart
//   crossing      the rest
std::string_view CollisionKind(const CollisionSummary& collision);

// "front", "left", "right", "rear".
std::string_view ContactSideName(ContactSide side);
std::optional<ContactSide> ContactSideFromName(std::string_view name);
// "nobody", "ego", "other", "both".
std::string_view LaneChangerName(LaneChanger changer);
std::optional<LaneChanger> LaneChangerFromName(std::string_view name);

}  // namespace dadrl
