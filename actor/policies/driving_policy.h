// Who drives the ego in an evaluation: scripted drivers and learned policies behind one interface.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "actor/drive_command.h"
#include "actor/driving_environment.h"
#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// A command and for how many simulation steps it is held.
struct Decision {
  DriveCommand command;
  int steps = 1;
};

// Not thread safe. Deterministic: the same episode seed and the same scenes give the same decisions.
class DrivingPolicy {
 public:
  virtual ~DrivingPolicy() = default;

  // After the environment's Reset(seed), before the first decision.
  virtual void BeginEpisode(uint64_t seed) { static_cast<void>(seed); }
  // For the scene the environment is in.
  virtual Decision Decide(const DrivingEnvironment& environment) = 0;
  // Of the last Decide: how much each row of the observation's vehicles weighed, sums to at most 1. Empty
  // when the driver attends to none. Valid until the next Decide.
  virtual std::span<const float> attention() const { return {}; }
};

// What an evaluation needs to know of its driver before it builds the environment.
struct PolicySetup {
  std::unique_ptr<DrivingPolicy> policy;
  EnvironmentOptions environment;  // whether SUMO drives
  Config config;                   // the caller's, with what a learned policy was trained on put in
  std::string description;         // for a reader: "rdm, which keeps its lane at 15 m/s"
};

struct PolicyOptions {
  int random_hold_steps = 10;  // of `random`: simulation steps one draw is held
  double impatience = 1.0;     // of `idm`: 0 is SUMO's careful driver, 1 takes the right of way when it must
};

// The scripted drivers:
//   random      a uniform action, held random_hold_steps
//   rdm         the paper's RDM baseline: keeps its lane at 15 m/s, yields to nobody
//   slow        creeps along the route at 4 m/s, yields to nobody
//   idm         SUMO's own driver
//   predictive  the fastest of six speeds that stays clear of everyone's constant-speed, constant-turn
//               prediction for four seconds
std::vector<std::string> ScriptedPolicyNames();

// `name` is a scripted driver, or the path of a policy file (common/model/policy_file.h), whose observation,
// model, decision interval and maximal speed replace those of `config`. kInvalidArgument: neither, or a
// policy of another layout; kCorrupt: a damaged file.
Result<PolicySetup> MakePolicy(const std::string& name, const Config& config, const PolicyOptions& options);

}  // namespace dadrl
