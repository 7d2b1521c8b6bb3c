#include "deploy/open_model/act.h"

#include <cstdio>
#include <memory>

#include "common/step/step_spec_of.h"
#include "deploy/cli/command.h"
#include "deploy/local/shipped_policies.h"
#include "deploy/open_model/recorded_observations.h"

namespace dadrl {
namespace {

struct ActOptions {
  std::string policy;
  std::string observations;
  bool json = false;
};

Result<int> RunAct(const ActOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const std::string file, ResolvePolicy(options.policy));
  DADRL_ASSIGN_OR_RETURN(const PolicyFile policy, LoadPolicy(file));
  DADRL_ASSIGN_OR_RETURN(const Columns observations,
                         LoadRecordedObservations(options.observations, StepSpecOf(policy.config)));
  DADRL_ASSIGN_OR_RETURN(const ActReport report, ActOn(observations, policy, options.policy));
  if (options.json) {
    fmt::print("{}\n", ActJson(report));
  } else {
    fmt::print("{}", ActTable(report));
  }
  return 0;
}

}  // namespace

Command MakeActCommand(CLI::App& dadrl) {
  auto options = std::make_shared<ActOptions>();
  CLI::App* app = dadrl.add_subcommand("act", "Say what a policy does on recorded observations");
  app->add_option("--policy", options->policy, "Policy file, or pretrained:NAME")->required();
  app->add_option("--observations", options->observations,
                  "Folder with vehicles.npy, ego.npy and context.npy (docs/open_models.md)")
      ->required()
      ->type_name("DIR");
  app->add_flag("--json", options->json, "One JSON object on standard output");
  return {app, [options] { return RunAct(*options); }};
}

}  // namespace dadrl
