// How humanly, lawfully and fast an episode was driven: SMARTS' score as the paper reports it, with its two
// flaws mended: jerk is divided by the step, and the cost of near obstacles is a mean over all steps.
#pragma once

#include "actor/sensing/localization.h"
#include "actor/sim/world_state.h"
#include "actor/task/episode_summary.h"
#include "actor/task/events.h"

namespace dadrl {

// Costs of one step, each in [0, 1].
//
// Obstacle: exp(-0.05 d) of the vehicle for which it is largest, d the distance of the centres in metres,
// among those within 30 m and within three seconds of driving at the present speed, at most 40 degrees off
// the ego's heading, and not exactly oncoming (relative heading at most 179 degrees); 0 when there is none.
double ObstacleCost(const WorldState& world);
// |jerk| / |(0.9, 0.9)| m/s^3, at most 1.
double JerkCost(const EgoState& ego);
// The square of the offset from the nearest lane's centre in half lane widths, at most 1; 0 off the lanes.
double LaneOffsetCost(const EgoLocation& location, const RoadMap& map);
// The square of the excess over the limit in halves of the limit, at most 1; 0 off the lanes.
double SpeedingCost(double speed_mps, double limit);

// Adds up the steps of one episode. Borrows the map. Not thread safe.
class EpisodeMetrics {
 public:
  explicit EpisodeMetrics(const RoadMap& map) : map_(map) {}

  void Begin() { sums_ = {}; }
  void Step(const WorldState& world, const EgoLocation& location, const Events& events);
  // Fills the fields from mean_speed_mps on; reads outcome, steps and progress, which the caller has set.
  // humanness_error is the mean of obstacle, jerk and lane offset cost; rule_violation the mean of speeding
  // cost and the fraction of steps against the lane; distance_to_destination is 0 and time_cost
  // steps / max_steps on success, else the fraction left and 1; overall_score is the mean of one minus each.
  void Finish(int max_steps, EpisodeSummary& summary) const;

 private:
  struct Sums {
    int steps = 0;
    double speed = 0.0;
    double obstacle = 0.0;
    double jerk = 0.0;
    double lane_offset = 0.0;
    double speeding = 0.0;
    double wrong_way = 0.0;
  };

  const RoadMap& map_;
  Sums sums_;
};

}  // namespace dadrl
