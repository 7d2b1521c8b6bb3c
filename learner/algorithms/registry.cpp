#include "learner/algorithms/registry.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "common/config/config_schema.h"
#include "common/config/validate.h"
#include "common/model/policy_model.h"
#include "common/step/step_spec_of.h"
#include "common/util/shown.h"
#include "learner/algorithms/bc/behaviour_cloning.h"
#include "learner/algorithms/dt/decision_transformer_learner.h"
#include "learner/algorithms/ppo/ppo.h"
#include "learner/algorithms/sac.h"
#include "learner/algorithms/slt/slt.h"
#include "proto/payload_codec.h"

namespace dadrl {
namespace {

template <typename Kind>
std::unique_ptr<Algorithm> Make(const Config& config) {
  return std::make_unique<Kind>(config);
}

constexpr std::array kAlgorithms = {
    AlgorithmEntry{"bc", "Behaviour cloning of recorded experience, by default of the predictive driver's",
                   BehaviourCloning::SpecOf, Make<BehaviourCloning>},
    AlgorithmEntry{"dadrl", "Soft actor-critic on the attention encoder and bird's-eye planes (the paper's)",
                   Sac::SpecOf, Make<Sac>},
    AlgorithmEntry{"drq",
                   "Soft actor-critic as sac, whose critics see the bird's-eye planes shifted at random",
                   Sac::SpecOf, Make<Sac>},
    AlgorithmEntry{
        "dt", "Decision transformer: clones, from an episode's history, by default the predictive driver",
        DecisionTransformerLearner::SpecOf, Make<DecisionTransformerLearner>},
    AlgorithmEntry{"mst", "Soft actor-critic on a scene encoder: attention over histories and lane polylines",
                   Sac::SpecOf, Make<Sac>},
    AlgorithmEntry{"ppo",
                   "Proximal policy optimisation: on policy, by rollouts that are trained on once, fresh",
                   Ppo::SpecOf, Make<Ppo>},
    AlgorithmEntry{"sac", "Soft actor-critic on bird's-eye planes and raw vehicle rows, without attention",
                   Sac::SpecOf, Make<Sac>},
    AlgorithmEntry{"slt", "The same as mst, whose encoder also learns to predict what it will say next",
                   Slt::SpecOf, Make<Slt>},
};

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const AlgorithmEntry& entry : kAlgorithms) names.emplace_back(entry.name);
  return names;
}

Status CheckEncoder(const Config& config, const AlgorithmSpec& spec) {
  if (!spec.trains_scene || config.model.scene) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "algorithm.name: {} trains the scene encoder, and model.scene is false; set it to true",
              config.algorithm.name);
}

Status CheckPriorities(const Config& config, const AlgorithmSpec& spec) {
  if (spec.gives_priorities || !UsesPriorities(config.replay)) return {};
  const char* const key = ByPriority(config.replay.sampler) ? "replay.sampler" : "replay.remover";
  return Fail(ErrorCode::kInvalidArgument,
              "{} goes by priorities, and algorithm.name: {} gives none; set it to uniform or oldest_first",
              key, config.algorithm.name);
}

// A batch that may be too long for a reply would be refused only when one is.
Status CheckBatch(const Config& config, const TrajectoryShape& batch) {
  const PayloadCodec codec(StepSpecOf(config), config.actor.floats);
  const int64_t observations = int64_t{batch.count} * batch.observations();
  const int64_t bytes = observations * static_cast<int64_t>(codec.max_payload_bytes());
  if (bytes <= kMaxBatchBytes) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "algorithm.batch_size: {} observations of a batch of algorithm.name: {} may take {} bytes, at "
              "most {} are sent at once; lower it, observation.history or observation.vehicles",
              observations, config.algorithm.name, bytes, kMaxBatchBytes);
}

// Actors that wait for a policy that only experience brings, and random experience where there must be none.
Status CheckActors(const Config& config, const AlgorithmSpec& spec) {
  if (spec.acts_from_start && config.actor.policy != "learned") {
    return Fail(ErrorCode::kInvalidArgument,
                "actor.policy: algorithm.name: {} learns from what its own policy does; set it to learned",
                config.algorithm.name);
  }
  if (spec.acts_from_start == config.actor.wait_for_policy) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "actor.wait_for_policy: {} does not suit algorithm.name: {}, whose first policy comes {} "
              "experience; set it to {}",
              config.actor.wait_for_policy, config.algorithm.name,
              spec.acts_from_start ? "before any" : "out of", spec.acts_from_start);
}

Status CheckDecisions(const Config& config, const AlgorithmSpec& spec) {
  const StepSpec steps = StepSpecOf(config);
  for (const std::string_view name : spec.decisions) {
    if (std::ranges::find(steps.decision, name, &ColumnSpec::name) != steps.decision.end()) continue;
    return Fail(
        ErrorCode::kInvalidArgument,
        "algorithm.name: {} reads the decision column {}, and this run records: {}; set model.{}=true",
        config.algorithm.name, name, ColumnsText(steps.decision), name);
  }
  return {};
}

// What would let it train on anything else, with what it should be.
Status CheckOnPolicy(const Config& config, const AlgorithmSpec& spec) {
  if (!spec.on_policy) return {};
  const ReplayConfig& replay = config.replay;
  struct Need {
    bool met;
    std::string_view key;
    std::string value;
    std::string_view remedy;
  };
  const Need needs[] = {
      {replay.max_times_sampled == 1, "replay.max_times_sampled", fmt::to_string(replay.max_times_sampled),
       "1"},
      {replay.max_staleness > 0, "replay.max_staleness", fmt::to_string(replay.max_staleness), "4"},
      {replay.min_samples_per_insert > 0.0, "replay.min_samples_per_insert",
       fmt::to_string(replay.min_samples_per_insert), "2, so that actors wait rather than go stale"},
      {replay.sequence_length > 0, "replay.sequence_length", fmt::to_string(replay.sequence_length), "32"},
      {replay.sequence_period == replay.sequence_length, "replay.sequence_period",
       fmt::to_string(replay.sequence_period), "replay.sequence_length, so that no step is drawn twice"},
      {config.algorithm.rollout >= replay.sequence_length, "algorithm.rollout",
       fmt::to_string(config.algorithm.rollout), "at least replay.sequence_length"},
  };
  for (const Need& need : needs) {
    if (need.met) continue;
    return Fail(ErrorCode::kInvalidArgument,
                "algorithm.name: {} trains on policy, and {}: {} is not for that; "
                "set it to {}",
                config.algorithm.name, need.key, need.value, need.remedy);
  }
  return {};
}

}  // namespace

std::span<const AlgorithmEntry> Algorithms() { return kAlgorithms; }

Result<const AlgorithmEntry*> FindAlgorithm(std::string_view name) {
  const auto* const found = std::ranges::find(kAlgorithms, name, &AlgorithmEntry::name);
  if (found != kAlgorithms.end()) return found;
  return Fail(ErrorCode::kInvalidArgument,
              "algorithm.name: '{}' is unknown; the nearest is '{}' (there are: {})", Shown(name),
              NearestName(name, Names()), fmt::join(Names(), ", "));
}

Status CheckNeeds(const Config& config, const AlgorithmSpec& spec) {
  DADRL_RETURN_IF_ERROR(CheckEncoder(config, spec));
  DADRL_RETURN_IF_ERROR(CheckPriorities(config, spec));
  DADRL_RETURN_IF_ERROR(CheckBatch(config, spec.batch));
  DADRL_RETURN_IF_ERROR(CheckActors(config, spec));
  DADRL_RETURN_IF_ERROR(CheckDecisions(config, spec));
  return CheckOnPolicy(config, spec);
}

Status CheckTrainsPolicy(const Config& config, const NamedNetwork& trained) {
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<PolicyModel> policy,
                         MakePolicyModel(StepSpecOf(config), config.model));
  const nn::ParamLayout& acting = policy->layout();
  if (acting.hash() == trained.layout_hash) return {};
  return Fail(
      ErrorCode::kInvalidArgument,
      "algorithm.name: {} trains a network of {} parameters (layout {:#x}), and model.policy: {} acts "
      "with one of {} (layout {:#x}); choose a model.policy that it trains",
      config.algorithm.name, trained.parameters.size(), trained.layout_hash, config.model.policy,
      acting.size(), acting.hash());
}

Result<std::unique_ptr<Algorithm>> MakeAlgorithm(const Config& config) {
  DADRL_ASSIGN_OR_RETURN(const AlgorithmEntry* const entry, FindAlgorithm(config.algorithm.name));
  DADRL_RETURN_IF_ERROR(CheckNeeds(config, entry->spec(config)));
  std::unique_ptr<Algorithm> algorithm = entry->make(config);
  DADRL_RETURN_IF_ERROR(CheckTrainsPolicy(config, algorithm->published_policy()));
  return algorithm;
}

}  // namespace dadrl
