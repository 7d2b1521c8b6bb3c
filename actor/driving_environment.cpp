#include "actor/driving_environment.h"

#include <cmath>
#include <utility>

#include "actor/mixed_environment.h"
#include "common/config/config_schema.h"
#include "common/liveness/working_thread.h"

namespace dadrl {
namespace {

// Of a network and its warm-up: the simulator cannot say that it gets on.
constexpr Duration kLongestLoad = std::chrono::minutes(10);

}  // namespace

Result<std::unique_ptr<Environment>> MakeDrivingEnvironment(const Config& config) {
  if (config.scenario == kAllScenarios) return MixedEnvironment::Create(config);
  return DrivingEnvironment::Create(config);
}

Result<std::unique_ptr<DrivingEnvironment>> DrivingEnvironment::Create(const Config& config,
                                                                       const EnvironmentOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const Scenario scenario, LoadScenario(config.scenario, options.scenarios));
  SimulationOptions simulation_options;
  simulation_options.profile = config.traffic.profile;
  simulation_options.max_speed_mps = config.task.max_speed_mps;
  simulation_options.ego_driver = options.driver;
  simulation_options.sumo_driver_impatience = options.sumo_driver_impatience;
  DADRL_ASSIGN_OR_RETURN(std::unique_ptr<Simulation> simulation,
                         Simulation::Create(scenario, simulation_options));
  return std::unique_ptr<DrivingEnvironment>(new DrivingEnvironment(config, options, std::move(simulation)));
}

DrivingEnvironment::DrivingEnvironment(const Config& config, const EnvironmentOptions& options,
                                       std::unique_ptr<Simulation> simulation)
    : config_(config),
      options_(options),
      simulation_(std::move(simulation)),
      controller_(map(), route()),
      localizer_(map(), route()),
      task_(map(), route(), config.task),
      sensor_(map(), route(), config.observation),
      observation_(DrivingShape::From(config.observation)) {}

Status DrivingEnvironment::Reset(uint64_t seed) {
  const LongWork loading(kLongestLoad);
  running_ = false;
  DADRL_RETURN_IF_ERROR(simulation_->Reset(seed));
  const EgoState& ego = world().ego;
  vehicle_.Reset(ego.pose, ego.speed_mps);
  controller_.Reset();
  localizer_.Reset();
  location_ = localizer_.Locate(ego.pose, ego.elevation_m);
  task_.Begin(config_.scenario, seed, location_);
  sensor_.Reset();
  sensor_.Update(world(), location_);
  last_step_ = {};
  observation_current_ = false;
  running_ = true;
  return {};
}

Result<StepResult> DrivingEnvironment::Step(const Action& action) {
  for (const float value : action) {
    if (!std::isfinite(value)) {
      return Fail(ErrorCode::kInvalidArgument, "the action is not finite: ({}, {})", action[0], action[1]);
    }
  }
  return Drive(CommandOf(action, config_.task.max_speed_mps), config_.task.decision_interval);
}

Result<StepResult> DrivingEnvironment::Drive(const DriveCommand& command, int steps) {
  Beat();
  if (!std::isfinite(command.target_speed_mps) || command.target_speed_mps < 0.0) {
    return Fail(ErrorCode::kInvalidArgument, "the target speed is {} m/s; it must be finite and at least 0",
                command.target_speed_mps);
  }
  if (!running_) return Fail(ErrorCode::kInternal, "no episode is running; Reset starts one");
  const double discount = std::pow(config_.algorithm.gamma, 1.0 / steps);
  double weight = 1.0;
  double reward = 0.0;
  for (int step = 0; step < steps && running_; ++step) {
    DADRL_RETURN_IF_ERROR(SimulateOneStep(command));
    reward += weight * last_step_.terms.Sum();
    weight *= discount;
  }
  observation_current_ = false;
  return StepResult{static_cast<float>(reward), last_step_.terminated, last_step_.truncated};
}

Status DrivingEnvironment::SimulateOneStep(const DriveCommand& command) {
  if (Status advanced = AdvanceSimulation(command); !advanced) {
    running_ = false;
    // Whatever the simulator found wrong, the caller's action was checked before.
    return Fail(ErrorCode::kInternal, "the episode of seed {} is lost after {} steps: {}", summary().seed,
                summary().steps, advanced.error().message);
  }
  location_ = localizer_.Locate(world().ego.pose, world().ego.elevation_m);
  last_step_ = simulation_->ego_arrived() ? task_.Leave(world(), location_) : task_.Step(world(), location_);
  sensor_.Update(world(), location_);
  running_ = !last_step_.ended();
  return {};
}

Status DrivingEnvironment::AdvanceSimulation(const DriveCommand& command) {
  if (options_.driver == EgoDriver::kSumo) return simulation_->StepSumoDriver();
  const EgoCommand control = controller_.Control(world().ego, command.target_speed_mps, command.lane);
  vehicle_.Step(control.target_speed_mps, control.target_steering_rad);
  return simulation_->Step(vehicle_.state());
}

const Observation& DrivingEnvironment::observation() const {
  if (!observation_current_) {
    sensor_.Observe(observation_);
    observation_current_ = true;
  }
  return observation_;
}

}  // namespace dadrl
