#include "actor/sim/simulation.h"

#include <libsumo/libsumo.h>

#include <algorithm>
#include <cassert>
#include <optional>

#include "actor/sim/ego_motion.h"
#include "actor/sim/memory_file.h"
#include "actor/sim/network_crop.h"
#include "actor/sim/scenario_plan.h"
#include "actor/sim/stderr_capture.h"
#include "actor/sim/sumo_pose.h"
#include "actor/sim/sumo_traffic.h"
#include "actor/sim/traffic.h"

namespace dadrl {
namespace {

// Whose network and traffic SUMO holds: the simulation that was created or reset last.
const Simulation* sumo_holds = nullptr;

// Everything above the simulator sees its failures as values; SUMO tells the details on standard error.
template <typename Function>
auto Guard(std::string_view doing, Function function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& exception) {
    return Fail(ErrorCode::kInternal, "SUMO failed {}: {}", doing, exception.what());
  }
}

}  // namespace

class Simulation::Impl {
 public:
  // `scenario`: its network is `crop`, if there is one.
  Impl(const Scenario& scenario, const SimulationOptions& options, std::optional<MemoryFile> crop,
       MemoryFile route_file, ScenarioPlan plan)
      : scenario_(scenario),
        crop_(std::move(crop)),
        options_(options),
        plan_(std::move(plan)),
        traffic_(scenario_, scenario_.profile(options_.profile), plan_, std::move(route_file)) {}

  // SUMO judges options, driver attributes and the flows' routes only when it runs with them.
  Status TryTraffic();
  Status Reset(uint64_t seed);
  // Null: SUMO moves the ego.
  Status Step(const EgoState* ego);

  const ScenarioPlan& plan() const { return plan_; }
  bool network_is_cut() const { return crop_.has_value(); }
  const WorldState& world() const { return world_; }
  bool ego_arrived() const { return traffic_.ego_arrived(); }
  EgoDriver driver() const { return options_.ego_driver; }

 private:
  EgoTraffic EgoAsTraffic() const;
  Status StepAndRead();
  // Leaves out who drives above or below the ego.
  Status ReadTraffic();
  Status SpawnEgo();
  bool StartIsFree() const;
  void AddDrivenEgo();
  Status AddSumoEgo();
  void MoveEgo(const EgoState& ego);
  void FollowSumoEgo();

  const Scenario scenario_;
  const std::optional<MemoryFile> crop_;
  const SimulationOptions options_;
  const ScenarioPlan plan_;
  SumoTraffic traffic_;
  bool episode_runs_ = false;
  WorldState world_;
};

EgoTraffic Simulation::Impl::EgoAsTraffic() const {
  EgoTraffic ego{plan_.ego_edges, options_.ego_driver == EgoDriver::kSumo, options_.max_speed_mps,
                 options_.sumo_driver_impatience};
  // The traffic must not see where a driven ego wants to go: only its first edge is declared.
  if (!ego.sumo_drives) ego.edges.resize(1);
  return ego;
}

Status Simulation::Impl::TryTraffic() {
  const Status tried = Guard("trying the traffic", [&]() -> Status {
    DADRL_RETURN_IF_ERROR(traffic_.Load(0, EgoAsTraffic()));
    traffic_.Step();
    return {};
  });
  if (tried) return {};
  return Fail(ErrorCode::kInvalidArgument, "{}: {}", scenario_.file.string(), tried.error().message);
}

Status Simulation::Impl::Reset(uint64_t seed) {
  episode_runs_ = false;
  world_ = WorldState();
  DADRL_RETURN_IF_ERROR(Guard("starting an episode", [&]() -> Status {
    DADRL_RETURN_IF_ERROR(traffic_.Load(seed, EgoAsTraffic()));
    const long warm_up_steps = std::lround(scenario_.warm_up_s / kStepSeconds);
    for (long step = 0; step < warm_up_steps; ++step) traffic_.Step();
    return SpawnEgo();
  }));
  episode_runs_ = true;
  return {};
}

Status Simulation::Impl::StepAndRead() {
  traffic_.Step();
  return ReadTraffic();
}

Status Simulation::Impl::ReadTraffic() {
  DADRL_RETURN_IF_ERROR(traffic_.Read(world_.vehicles));
  std::erase_if(world_.vehicles, [&](const SocialVehicle& vehicle) {
    return !OnOneLevel(vehicle.elevation_m - world_.ego.elevation_m,
                       Norm(vehicle.pose.position - world_.ego.pose.position));
  });
  return {};
}

bool Simulation::Impl::StartIsFree() const {
  return std::none_of(world_.vehicles.begin(), world_.vehicles.end(), [&](const SocialVehicle& vehicle) {
    return Norm(vehicle.pose.position - plan_.start_front) < (vehicle.length_m + kVehicleLength) / 2.0;
  });
}

Status Simulation::Impl::SpawnEgo() {
  world_.ego.pose = plan_.start;
  world_.ego.elevation_m = plan_.start_elevation_m;
  DADRL_RETURN_IF_ERROR(ReadTraffic());
  for (int waited = 0; !StartIsFree(); ++waited) {
    if (waited == options_.spawn_limit_steps) {
      return Fail(ErrorCode::kUnavailable, "scenario '{}': the ego's start stayed blocked for {:.0f} s",
                  scenario_.name, waited * kStepSeconds);
    }
    DADRL_RETURN_IF_ERROR(StepAndRead());
  }
  if (options_.ego_driver == EgoDriver::kSumo) return AddSumoEgo();
  AddDrivenEgo();
  return {};
}

void Simulation::Impl::AddDrivenEgo() {
  const Lane& lane = plan_.map.lane(plan_.route.lanes().front());
  traffic_.AddDrivenEgo();
  world_.ego.speed_mps = world_.ego.velocity_lon = std::min(lane.speed_limit, options_.max_speed_mps);
}

Status Simulation::Impl::AddSumoEgo() {
  const std::vector<int>& lanes = plan_.route.lanes();
  const Lane& first = plan_.map.lane(lanes.front());
  const Lane& last = plan_.map.lane(lanes.back());
  libsumo::Vehicle::add(kEgoId, kEgoId, kEgoId, "now", std::to_string(first.index),
                        fmt::format("{}", plan_.start_offset_m), "max", std::to_string(last.index));
  for (int waited = 0; !traffic_.ego_in_network(); ++waited) {
    if (waited == options_.spawn_limit_steps) {
      return Fail(ErrorCode::kUnavailable, "scenario '{}': SUMO could not insert the ego for {:.0f} s",
                  scenario_.name, waited * kStepSeconds);
    }
    DADRL_RETURN_IF_ERROR(StepAndRead());
  }
  world_.ego.pose = PoseFromSumo(kEgoId);
  world_.ego.speed_mps = world_.ego.velocity_lon = libsumo::Vehicle::getSpeed(kEgoId);
  return {};
}

Status Simulation::Impl::Step(const EgoState* ego) {
  if (!episode_runs_) return Fail(ErrorCode::kInternal, "no episode runs: Reset first");
  if (ego != nullptr && !IsFinite(*ego)) {
    return Fail(ErrorCode::kInvalidArgument, "the ego's pose or speed is not finite");
  }
  episode_runs_ = false;
  DADRL_RETURN_IF_ERROR(Guard("in a step", [&]() -> Status {
    if (ego != nullptr) MoveEgo(*ego);
    DADRL_RETURN_IF_ERROR(StepAndRead());
    const bool left_at_its_goal = ego == nullptr && traffic_.ego_arrived();
    if (!traffic_.ego_in_network() && !left_at_its_goal) {
      return Fail(ErrorCode::kInternal, "the ego vanished from the traffic");
    }
    if (ego == nullptr) {
      FollowSumoEgo();
    } else {
      const double elevation = world_.ego.elevation_m;
      world_.ego = *ego;
      world_.ego.elevation_m = elevation;
    }
    return {};
  }));
  ++world_.step;
  episode_runs_ = true;
  return {};
}

void Simulation::Impl::MoveEgo(const EgoState& ego) {
  if (!plan_.map.has_levels()) {
    MoveInSumo(kEgoId, ego.pose, ego.speed_mps);
    return;
  }
  // From a bridge one does not get onto the road below.
  const auto under =
      plan_.map.NearestLane(ego.pose.position, ego.pose.heading, kVehicleLength, world_.ego.elevation_m);
  if (!under) {
    MoveInSumo(kEgoId, ego.pose, ego.speed_mps);
    return;
  }
  const Lane& lane = plan_.map.lane(under->lane);
  MoveInSumo(kEgoId, ego.pose, ego.speed_mps, lane.edge, lane.index);
  world_.ego.elevation_m = under->elevation;
}

void Simulation::Impl::FollowSumoEgo() {
  EgoState now = world_.ego;
  if (traffic_.ego_in_network()) {
    if (plan_.map.has_levels()) now.elevation_m = ElevationFromSumo(kEgoId);
    now.pose = PoseFromSumo(kEgoId);
    now.speed_mps = now.velocity_lon = libsumo::Vehicle::getSpeed(kEgoId);
  } else {
    // SUMO removes a vehicle in the step in which its front passes the end of its route: it drove up to
    // there, unless it left by another lane than the goal's.
    const Polyline& centre = plan_.route.centre();
    if (centre.Project(now.pose.position).distance > kVehicleWidth) return;
    now.pose.position =
        plan_.route.goal() - (kVehicleLength / 2.0) * Forward(centre.HeadingAt(centre.length()));
  }
  CompleteMotion(world_.ego, now);
  world_.ego = now;
}

Result<std::unique_ptr<Simulation>> Simulation::Create(const Scenario& scenario,
                                                       const SimulationOptions& options) {
  std::unique_ptr<Simulation> simulation(new Simulation);
  sumo_holds = simulation.get();
  DADRL_ASSIGN_OR_RETURN(MemoryFile route_file, MemoryFile::Create("dadrl-traffic"));
  DADRL_ASSIGN_OR_RETURN(StderrCapture complaints, StderrCapture::Start());
  Scenario taken = scenario;
  DADRL_ASSIGN_OR_RETURN(std::optional<MemoryFile> crop,
                         CropNetwork(scenario, scenario.profile(options.profile)));
  if (crop) taken.network = crop->path();
  Status created;
  if (auto plan = LoadPlan(taken, options.profile)) {
    simulation->impl_ =
        std::make_unique<Impl>(taken, options, std::move(crop), std::move(route_file), std::move(*plan));
    created = simulation->impl_->TryTraffic();
  } else {
    created = tl::unexpected(plan.error());
  }
  const std::string details = complaints.Finish();
  if (created) return simulation;
  return Fail(created.error().code, "{}{}{}", created.error().message, details.empty() ? "" : " ", details);
}

Simulation::Simulation() = default;

Simulation::~Simulation() {
  if (sumo_holds != this) return;
  sumo_holds = nullptr;
  // A failure to close has no one left to act on it; the next load closes first anyway.
  (void)Guard("closing", []() -> Status {
    libsumo::Simulation::close();
    return {};
  });
}

const RoadMap& Simulation::map() const { return impl_->plan().map; }
bool Simulation::network_is_cut() const { return impl_->network_is_cut(); }
const Route& Simulation::route() const { return impl_->plan().route; }
const WorldState& Simulation::world() const { return impl_->world(); }
bool Simulation::ego_arrived() const { return impl_->ego_arrived(); }

Status Simulation::Reset(uint64_t seed) {
  sumo_holds = this;
  return impl_->Reset(seed);
}

Status Simulation::CheckHeld() const {
  if (sumo_holds == this) return {};
  return Fail(ErrorCode::kInternal,
              "another simulation of this process was reset since; libsumo holds one at a time");
}

Status Simulation::Step(const EgoState& ego) {
  assert(impl_->driver() == EgoDriver::kCaller);
  DADRL_RETURN_IF_ERROR(CheckHeld());
  return impl_->Step(&ego);
}

Status Simulation::StepSumoDriver() {
  assert(impl_->driver() == EgoDriver::kSumo);
  DADRL_RETURN_IF_ERROR(CheckHeld());
  return impl_->Step(nullptr);
}

}  // namespace dadrl
