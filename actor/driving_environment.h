// The driving task on SUMO: simulation, ego, senses and judge put together.
#pragma once

#include <filesystem>
#include <memory>

#include "actor/drive_command.h"
#include "actor/ego/ego_controller.h"
#include "actor/ego/ego_vehicle.h"
#include "actor/environment.h"
#include "actor/sensing/sensor.h"
#include "actor/sim/scenario.h"
#include "actor/sim/simulation.h"
#include "actor/task/driving_task.h"

namespace dadrl {

// Who drives besides policies.
struct EnvironmentOptions {
  EgoDriver driver = EgoDriver::kCaller;  // kSumo: commands are ignored, SUMO's own driver takes the ego
  double sumo_driver_impatience = 0.0;    // in [0, 1]
  std::filesystem::path scenarios = ScenarioDirectory();
};

// The Environment of environment.h, and beside it what scripted policies and pictures need: raw commands and
// the scene. Not thread safe. A step allocates nothing beyond what SUMO does.
class DrivingEnvironment final : public Environment {
 public:
  // For a single scenario; errors as MakeDrivingEnvironment. Of a process's environments only the one reset
  // last can be stepped (actor/sim/simulation.h).
  static Result<std::unique_ptr<DrivingEnvironment>> Create(const Config& config,
                                                            const EnvironmentOptions& options = {});

  Status Reset(uint64_t seed) override;
  Result<StepResult> Step(const Action& action) override;
  const Observation& observation() const override;
  const EpisodeSummary& summary() const override { return task_.summary(); }
  const DrivingEnvironment* driving() const override { return this; }

  // Holds `command` for `steps` simulation steps, or until the episode ends; discounts as if that were one
  // decision. Errors as Step.
  Result<StepResult> Drive(const DriveCommand& command, int steps);

  const Config& config() const { return config_; }
  const RoadMap& map() const { return simulation_->map(); }
  const Route& route() const { return simulation_->route(); }
  bool network_is_cut() const { return simulation_->network_is_cut(); }
  bool sumo_drives() const { return options_.driver == EgoDriver::kSumo; }
  const EgoController& controller() const { return controller_; }
  const EgoVehicle& vehicle() const { return vehicle_; }
  // Of the last simulation step; valid until the next.
  const WorldState& world() const { return simulation_->world(); }
  const EgoLocation& location() const { return location_; }
  const TaskStep& last_step() const { return last_step_; }

 private:
  DrivingEnvironment(const Config& config, const EnvironmentOptions& options,
                     std::unique_ptr<Simulation> simulation);

  Status AdvanceSimulation(const DriveCommand& command);
  Status SimulateOneStep(const DriveCommand& command);

  Config config_;
  EnvironmentOptions options_;
  std::unique_ptr<Simulation> simulation_;
  EgoController controller_;
  EgoVehicle vehicle_;
  Localizer localizer_;
  DrivingTask task_;
  EgoLocation location_;
  TaskStep last_step_;
  bool running_ = false;  // between a Reset and the end of its episode

  // The observation is drawn when it is asked for: scripted drivers never look at it.
  mutable Sensor sensor_;
  mutable Observation observation_;
  mutable bool observation_current_ = false;
};

}  // namespace dadrl
