#include <cstdio>
#include <memory>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "deploy/cli/command.h"

namespace dadrl {
namespace {

struct ConfigCommandOptions {
  ConfigOptions config;
  bool explain = false;
};

}  // namespace

Command MakeConfigCommand(CLI::App& dadrl) {
  auto options = std::make_shared<ConfigCommandOptions>();
  CLI::App* app = dadrl.add_subcommand("config", "Print every configuration key with its value, as YAML");
  app->add_flag("--explain", options->explain, "With meaning and range of each key");
  options->config.AddTo(*app);
  return {app, [options]() -> Result<int> {
            DADRL_ASSIGN_OR_RETURN(const Config config, options->config.ApplyToPreset());
            DADRL_RETURN_IF_ERROR(Validate(config));
            fmt::print("{}", ToYaml(config, options->explain));
            return 0;
          }};
}

}  // namespace dadrl
