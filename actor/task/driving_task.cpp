#include "actor/task/driving_task.h"

#include "actor/task/collision_report.h"

namespace dadrl {
namespace {

Outcome OutcomeOf(const Events& events) {
  if (events.collision) return Outcome::kCollision;
  if (events.off_road) return Outcome::kOffRoad;
  return events.goal ? Outcome::kSuccess : Outcome::kStagnation;
}

}  // namespace

void DrivingTask::Begin(const std::string& scenario, uint64_t seed, const EgoLocation& location) {
  summary_ = EpisodeSummary{};
  summary_.scenario = scenario;
  summary_.seed = seed;
  reward_.Begin(location.remaining);
  metrics_.Begin();
}

TaskStep DrivingTask::Step(const WorldState& world, const EgoLocation& location) {
  return Judge(world, location, detector_.Detect(world, location));
}

TaskStep DrivingTask::Leave(const WorldState& world, const EgoLocation& location) {
  Events events = detector_.Detect(world, location);
  events.off_road = events.off_road || !events.goal;
  return Judge(world, location, events);
}

TaskStep DrivingTask::Judge(const WorldState& world, const EgoLocation& location, const Events& events) {
  TaskStep step;
  step.events = events;
  step.terms = reward_.Step(world.ego.speed_mps, location, events);
  metrics_.Step(world, location, events);
  summary_.steps += 1;
  summary_.episode_return += step.terms.Sum();
  summary_.progress = 1.0 - location.remaining;
  step.terminated = events.collision || events.off_road || events.goal;
  step.truncated = !step.terminated && summary_.steps >= config_.max_steps;
  if (step.ended()) {
    summary_.outcome = OutcomeOf(events);
    if (events.collision) summary_.collision = DescribeCollision(world, location, map_);
    metrics_.Finish(config_.max_steps, summary_);
  }
  return step;
}

}  // namespace dadrl
