#include "actor/sensing/localization.h"

#include <algorithm>

namespace dadrl {
namespace {

// Far more than a vehicle drives in a step, far less than the gap between two arms of a route.
constexpr double kWindowBehind = 6.0;
constexpr double kWindowAhead = 12.0;

}  // namespace

EgoLocation Localizer::Locate(const Pose& ego, double elevation_m) {
  const Polyline& centre = route_.centre();
  route_s_ = started_ ? centre
                            .Project(ego.position, std::max(0.0, route_s_ - kWindowBehind),
                                     std::min(centre.length(), route_s_ + kWindowAhead))
                            .s
                      : centre.Project(ego.position).s;
  started_ = true;

  EgoLocation location;
  location.route_s = route_s_;
  location.remaining = std::clamp(1.0 - route_s_ / centre.length(), 0.0, 1.0);
  location.nearest = map_.NearestLane(ego.position, ego.heading, kLaneSearchRadius, elevation_m);
  if (location.nearest && location.nearest->distance <= kOnLaneDistance) {
    const Lane& lane = map_.lane(location.nearest->lane);
    location.lane_index = lane.index;
    location.speed_limit = lane.speed_limit;
  }
  return location;
}

}  // namespace dadrl
