// Episodes made by hand, whose pictures can be worked out.
#pragma once

#include <utility>

#include "actor/render/recording.h"
#include "common/step/driving_shape.h"
#include "tests/actor/test_maps.h"

namespace dadrl::test {

// The ego drives east on StraightRoad from (50, 0) with 10 m/s, a metre a step, for `steps` steps; car 3
// stands at (60, 3.2), car 7 drives beside the ego on the other lane; both reward terms and attention are the
// same at each step. It ends in success unless the caller changes it.
inline Recording StraightDrive(int steps) {
  RoadMap map = StraightRoad();
  Route route = StraightRoute(map);
  Recording recording{.scenario = "left_turn",
                      .policy = "a test",
                      .map = std::move(map),
                      .route = std::move(route),
                      .max_speed_mps = 10.0,
                      .sensor_radius_m = 30.0,
                      .moments = {},
                      .summary = {},
                      .collided_with = {}};
  for (int step = 0; step <= steps; ++step) {
    Moment moment;
    moment.world = WorldWithEgo(50.0 + step, 0.0, 0.0, 10.0);
    moment.world.step = step;
    moment.world.vehicles = {Vehicle(3, 60, 3.2), Vehicle(7, 50.0 + step, 3.2, 0.0, 10.0)};
    moment.reward.progress = step == 0 ? 0.0 : 0.25;
    moment.reward_so_far.progress = 0.25 * step;
    moment.command = DriveCommand{8.0, 1};
    moment.attention = {{3, 0.42}, {7, 0.1}};
    moment.context.assign(DrivingShape::kContextBytes, 0);
    recording.moments.push_back(std::move(moment));
  }
  recording.summary.seed = 1'000'003;
  recording.summary.steps = steps;
  recording.summary.outcome = Outcome::kSuccess;
  return recording;
}

}  // namespace dadrl::test
