#include <cstdio>
#include <memory>

#include "deploy/cli/command.h"
#include "deploy/local/shipped_policies.h"
#include "deploy/open_model/export_policy.h"

namespace dadrl {
namespace {

struct ExportOptions {
  std::string policy;
  std::string out;
};

Result<int> RunExport(const ExportOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const std::string file, ResolvePolicy(options.policy));
  DADRL_ASSIGN_OR_RETURN(const PolicyFile policy, LoadPolicy(file));
  DADRL_RETURN_IF_ERROR(ExportPolicy(policy, options.policy, options.out));
  std::vector<std::string> names;
  for (const StoredNetwork& network : policy.networks) names.push_back(network.name);
  fmt::print("{}/index.json: {}\n", options.out, fmt::join(names, ", "));
  return 0;
}

}  // namespace

Command MakeExportCommand(CLI::App& dadrl) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* app = dadrl.add_subcommand(
      "export", "Write a policy's networks as NumPy arrays with an index (docs/open_models.md)");
  app->add_option("--policy", options->policy, "Policy file, or pretrained:NAME")->required();
  app->add_option("--out", options->out, "New or empty folder")->required()->type_name("DIR");
  return {app, [options] { return RunExport(*options); }};
}

}  // namespace dadrl
