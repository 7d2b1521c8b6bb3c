#include "actor/sim/simulation.h"

#include <libsumo/libsumo.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <map>
#include <numbers>

#include "actor/sim/ego_motion.h"
#include "actor/sim/memory_file.h"
#include "actor/sim/scenario_plan.h"
#include "actor/sim/stderr_capture.h"
#include "actor/sim/traffic.h"
#include "common/util/random.h"

namespace dadrl {
namespace {

constexpr double kHalfLength = kVehicleLength / 2.0;
// Streams of an episode's seed.
enum SeedStream : uint64_t { kDriverStream, kSumoStream, kLoopStream };
// moveToXY maps the ego to lanes at most this far away; beyond it the ego is off the road, at the same place.
constexpr double kMatchThreshold = 5.0;
constexpr int kKeepExactPosition = 2;

std::atomic<bool> process_has_simulation{false};

double HeadingFromSumo(double degrees) { return WrapAngle((90.0 - degrees) * std::numbers::pi / 180.0); }
double HeadingToSumo(double heading) {
  const double degrees = 90.0 - WrapAngle(heading) * 180.0 / std::numbers::pi;
  return degrees < 0.0 ? degrees + 360.0 : degrees;
}

// SUMO places vehicles by their front, the task by their centre.
Pose PoseFromSumo(const std::string& id) {
  const libsumo::TraCIPosition front = libsumo::Vehicle::getPosition(id);
  const double heading = HeadingFromSumo(libsumo::Vehicle::getAngle(id));
  return {Point{front.x, front.y} - kHalfLength * Forward(heading), heading};
}

bool IsFinite(const EgoState& ego) {
  return std::isfinite(ego.pose.position.x) && std::isfinite(ego.pose.position.y) &&
         std::isfinite(ego.pose.heading) && std::isfinite(ego.speed_mps);
}

// Everything above the simulator sees its failures as values; SUMO tells the details on standard error.
template <typename Function>
auto Guard(std::string_view doing, Function function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& exception) {
    return Fail(ErrorCode::kInternal, "SUMO failed {}: {}", doing, exception.what());
  }
}

Result<ScenarioPlan> LoadPlan(const Scenario& scenario) {
  return Guard("loading " + scenario.network.string(), [&]() -> Result<ScenarioPlan> {
    libsumo::Simulation::load({"--net-file", scenario.network.string(), "--xml-validation", "never",
                               "--xml-validation.net", "never", "--no-step-log", "true", "--no-warnings",
                               "true"});
    if (!libsumo::Simulation::isLoaded()) return Fail(ErrorCode::kInternal, "SUMO loaded no network");
    return PlanScenario(scenario);
  });
}

}  // namespace

class Simulation::Impl {
 public:
  Impl(Scenario scenario, SimulationOptions options, MemoryFile traffic_file, ScenarioPlan plan)
      : scenario_(std::move(scenario)),
        options_(options),
        traffic_file_(std::move(traffic_file)),
        plan_(std::move(plan)) {}

  // SUMO judges options, driver attributes and the flows' routes only when it runs with them.
  Status TryTraffic();
  Status Reset(uint64_t seed);
  // Null: SUMO moves the ego.
  Status Step(const EgoState* ego);

  const ScenarioPlan& plan() const { return plan_; }
  const WorldState& world() const { return world_; }
  bool ego_arrived() const { return ego_arrived_; }
  EgoDriver driver() const { return options_.ego_driver; }

 private:
  // A vehicle waits before it first enters, and again whenever it has finished its loop.
  enum class Presence { kWaiting, kInNetwork };

  std::vector<std::string> SumoOptions(uint64_t seed) const;
  Status Load(uint64_t seed);
  void StepTraffic();
  void ReenterTraffic(const std::string& id);
  Status ReadVehicles();
  Status CheckNoneVanished();
  Status SpawnEgo();
  bool StartIsFree() const;
  void AddDrivenEgo();
  Status AddSumoEgo();
  void MoveEgo(const EgoState& ego);
  void FollowSumoEgo();

  const Scenario scenario_;
  const SimulationOptions options_;
  MemoryFile traffic_file_;
  const ScenarioPlan plan_;

  bool episode_runs_ = false;
  Random loop_random_{0};
  std::vector<Presence> presence_;
  bool ego_in_network_ = false;
  bool ego_arrived_ = false;
  WorldState world_;
};

std::vector<std::string> Simulation::Impl::SumoOptions(uint64_t seed) const {
  // A map, because SUMO refuses an option that is given twice.
  std::map<std::string, std::string> options{
      {"net-file", scenario_.network.string()},
      {"route-files", traffic_file_.path()},
      {"step-length", fmt::format("{}", kStepSeconds)},
      {"seed", fmt::format("{}", DeriveSeed(seed, kSumoStream) & 0x7fffffff)},
      {"time-to-teleport", "-1"},
      {"collision.action", "none"},
      {"no-step-log", "true"},
      {"no-warnings", "true"},
      {"xml-validation", "never"},
      {"xml-validation.net", "never"},
  };
  for (const auto& [name, value] : scenario_.profile(options_.profile).sumo_options) options[name] = value;
  std::vector<std::string> arguments;
  for (const auto& [name, value] : options) {
    arguments.push_back("--" + name);
    arguments.push_back(value);
  }
  return arguments;
}

Status Simulation::Impl::Load(uint64_t seed) {
  Random driver_random(DeriveSeed(seed, kDriverStream));
  const std::vector<DriverType> types = DrawDriverTypes(scenario_.driver_types, driver_random);
  loop_random_ = Random(DeriveSeed(seed, kLoopStream));
  presence_.assign(static_cast<size_t>(scenario_.population()), Presence::kWaiting);
  ego_in_network_ = ego_arrived_ = false;
  world_ = WorldState();
  EgoTraffic ego{plan_.ego_edges, options_.ego_driver == EgoDriver::kSumo, options_.max_speed_mps,
                 options_.sumo_driver_impatience};
  // The traffic must not see where a driven ego wants to go: only its first edge is declared.
  if (!ego.sumo_drives) ego.edges.resize(1);
  DADRL_RETURN_IF_ERROR(traffic_file_.Write(
      TrafficXml(scenario_, scenario_.profile(options_.profile), types, plan_.lane_end_m, ego)));
  libsumo::Simulation::load(SumoOptions(seed));
  return {};
}

Status Simulation::Impl::TryTraffic() {
  const Status tried = Guard("trying the traffic", [&]() -> Status {
    DADRL_RETURN_IF_ERROR(Load(0));
    StepTraffic();
    return {};
  });
  if (tried) return {};
  return Fail(ErrorCode::kInvalidArgument, "scenario '{}': {}", scenario_.name, tried.error().message);
}

Status Simulation::Impl::Reset(uint64_t seed) {
  episode_runs_ = false;
  DADRL_RETURN_IF_ERROR(Guard("starting an episode", [&]() -> Status {
    DADRL_RETURN_IF_ERROR(Load(seed));
    const long warm_up_steps = std::lround(scenario_.warm_up_s / kStepSeconds);
    for (long step = 0; step < warm_up_steps; ++step) StepTraffic();
    return SpawnEgo();
  }));
  episode_runs_ = true;
  return {};
}

bool Simulation::Impl::StartIsFree() const {
  return std::none_of(world_.vehicles.begin(), world_.vehicles.end(), [&](const SocialVehicle& vehicle) {
    return Norm(vehicle.pose.position - plan_.start_front) < kVehicleLength;
  });
}

Status Simulation::Impl::SpawnEgo() {
  DADRL_RETURN_IF_ERROR(ReadVehicles());
  for (int waited = 0; !StartIsFree(); ++waited) {
    if (waited == options_.spawn_limit_steps) {
      return Fail(ErrorCode::kUnavailable, "scenario '{}': the ego's start stayed blocked for {:.0f} s",
                  scenario_.name, waited * kStepSeconds);
    }
    StepTraffic();
    DADRL_RETURN_IF_ERROR(ReadVehicles());
  }
  world_.ego.pose = plan_.start;
  world_.ego.speed_mps = world_.ego.velocity_lon = std::min(plan_.start_limit_mps, options_.max_speed_mps);
  if (options_.ego_driver == EgoDriver::kSumo) return AddSumoEgo();
  AddDrivenEgo();
  return {};
}

void Simulation::Impl::AddDrivenEgo() {
  const Lane& lane = plan_.map.lanes()[static_cast<size_t>(plan_.route.lanes().front())];
  libsumo::Vehicle::add(kEgoId, kEgoId, kEgoId, "now", std::to_string(lane.index), "0", "0");
  // No check of SUMO's may keep the ego from what it is told.
  libsumo::Vehicle::setSpeedMode(kEgoId, 0);
  libsumo::Vehicle::setLaneChangeMode(kEgoId, 0);
}

Status Simulation::Impl::AddSumoEgo() {
  const std::vector<int>& lanes = plan_.route.lanes();
  const Lane& first = plan_.map.lanes()[static_cast<size_t>(lanes.front())];
  const Lane& last = plan_.map.lanes()[static_cast<size_t>(lanes.back())];
  libsumo::Vehicle::add(kEgoId, kEgoId, kEgoId, "now", std::to_string(first.index),
                        fmt::format("{}", plan_.start_offset_m), "max", std::to_string(last.index));
  for (int waited = 0; !ego_in_network_; ++waited) {
    if (waited == options_.spawn_limit_steps) {
      return Fail(ErrorCode::kUnavailable, "scenario '{}': SUMO could not insert the ego for {:.0f} s",
                  scenario_.name, waited * kStepSeconds);
    }
    StepTraffic();
    DADRL_RETURN_IF_ERROR(ReadVehicles());
  }
  world_.ego.pose = PoseFromSumo(kEgoId);
  world_.ego.speed_mps = world_.ego.velocity_lon = libsumo::Vehicle::getSpeed(kEgoId);
  return {};
}

void Simulation::Impl::StepTraffic() {
  libsumo::Simulation::step();
  for (const std::string& id : libsumo::Simulation::getArrivedIDList()) {
    if (id == kEgoId) {
      ego_arrived_ = true;
    } else {
      ReenterTraffic(id);
    }
  }
}

void Simulation::Impl::ReenterTraffic(const std::string& id) {
  const int vehicle = SocialIndex(id);
  const int flow = vehicle / scenario_.driver_types;
  const int lanes = plan_.departure_lanes[static_cast<size_t>(flow)];
  libsumo::Vehicle::add(id, FlowId(flow), TypeId(vehicle % scenario_.driver_types), "now",
                        std::to_string(loop_random_.Below(static_cast<uint64_t>(lanes))), "0", "0");
  presence_[static_cast<size_t>(vehicle)] = Presence::kWaiting;
}

Status Simulation::Impl::ReadVehicles() {
  world_.vehicles.clear();
  ego_in_network_ = false;
  for (const std::string& id : libsumo::Vehicle::getIDList()) {
    const int vehicle = SocialIndex(id);
    if (vehicle < 0) {
      ego_in_network_ = true;
      continue;
    }
    world_.vehicles.push_back({vehicle, PoseFromSumo(id), libsumo::Vehicle::getSpeed(id),
                               plan_.map.FindLane(libsumo::Vehicle::getLaneID(id))});
  }
  std::sort(world_.vehicles.begin(), world_.vehicles.end(),
            [](const SocialVehicle& a, const SocialVehicle& b) { return a.id < b.id; });
  return CheckNoneVanished();
}

Status Simulation::Impl::CheckNoneVanished() {
  auto next = world_.vehicles.begin();
  for (size_t vehicle = 0; vehicle < presence_.size(); ++vehicle) {
    if (next != world_.vehicles.end() && next->id == static_cast<int>(vehicle)) {
      ++next;
      presence_[vehicle] = Presence::kInNetwork;
    } else if (presence_[vehicle] == Presence::kInNetwork) {
      return Fail(ErrorCode::kInternal, "vehicle {} vanished from the traffic",
                  SocialId(static_cast<int>(vehicle)));
    }
  }
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
    StepTraffic();
    DADRL_RETURN_IF_ERROR(ReadVehicles());
    const bool ego_left_at_its_goal = ego == nullptr && ego_arrived_;
    if (ego_in_network_ || ego_left_at_its_goal) return {};
    return Fail(ErrorCode::kInternal, "the ego vanished from the traffic");
  }));
  if (ego != nullptr) {
    world_.ego = *ego;
  } else {
    DADRL_RETURN_IF_ERROR(Guard("reading the ego", [&]() -> Status {
      FollowSumoEgo();
      return {};
    }));
  }
  ++world_.step;
  episode_runs_ = true;
  return {};
}

void Simulation::Impl::MoveEgo(const EgoState& ego) {
  const Point front = ego.pose.position + kHalfLength * Forward(ego.pose.heading);
  libsumo::Vehicle::setSpeed(kEgoId, ego.speed_mps);
  libsumo::Vehicle::moveToXY(kEgoId, "", 0, front.x, front.y, HeadingToSumo(ego.pose.heading),
                             kKeepExactPosition, kMatchThreshold);
}

void Simulation::Impl::FollowSumoEgo() {
  EgoState now = world_.ego;
  if (ego_in_network_) {
    now.pose = PoseFromSumo(kEgoId);
    now.speed_mps = now.velocity_lon = libsumo::Vehicle::getSpeed(kEgoId);
  } else {
    // SUMO removes a vehicle in the step in which its front passes the end of its route: it drove up to
    // there, unless it left by another lane than the goal's.
    const Polyline& centre = plan_.route.centre();
    if (centre.Project(now.pose.position).distance > kVehicleWidth) return;
    now.pose.position = plan_.route.goal() - kHalfLength * Forward(centre.HeadingAt(centre.length()));
  }
  CompleteMotion(world_.ego, now);
  world_.ego = now;
}

Result<std::unique_ptr<Simulation>> Simulation::Create(const Scenario& scenario,
                                                       const SimulationOptions& options) {
  if (process_has_simulation.exchange(true)) {
    return Fail(ErrorCode::kInternal, "this process already has a simulation; libsumo holds only one");
  }
  // Gives the process back when anything below fails.
  std::unique_ptr<Simulation> simulation(new Simulation);
  DADRL_ASSIGN_OR_RETURN(MemoryFile traffic_file, MemoryFile::Create("dadrl-traffic"));
  DADRL_ASSIGN_OR_RETURN(StderrCapture complaints, StderrCapture::Start());
  Status created;
  if (auto plan = LoadPlan(scenario)) {
    simulation->impl_ = std::make_unique<Impl>(scenario, options, std::move(traffic_file), std::move(*plan));
    created = simulation->impl_->TryTraffic();
  } else {
    created = tl::unexpected(plan.error());
  }
  const std::string details = complaints.Finish();
  if (created) return simulation;
  return Fail(created.error().code, "{} {}", created.error().message, details);
}

Simulation::Simulation() = default;

Simulation::~Simulation() {
  // A failure to close has no one left to act on it; the next load closes first anyway.
  (void)Guard("closing", []() -> Status {
    libsumo::Simulation::close();
    return {};
  });
  process_has_simulation = false;
}

const RoadMap& Simulation::map() const { return impl_->plan().map; }
const Route& Simulation::route() const { return impl_->plan().route; }
const WorldState& Simulation::world() const { return impl_->world(); }
bool Simulation::ego_arrived() const { return impl_->ego_arrived(); }
Status Simulation::Reset(uint64_t seed) { return impl_->Reset(seed); }

Status Simulation::Step(const EgoState& ego) {
  assert(impl_->driver() == EgoDriver::kCaller);
  return impl_->Step(&ego);
}

Status Simulation::StepSumoDriver() {
  assert(impl_->driver() == EgoDriver::kSumo);
  return impl_->Step(nullptr);
}

}  // namespace dadrl
