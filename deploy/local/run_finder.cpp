#include "deploy/local/run_finder.h"

#include <map>
#include <string_view>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/dds/endpoint.h"
#include "common/dds/node.h"
#include "common/util/log.h"
#include "proto/topics.h"

namespace dadrl {
namespace {

constexpr Duration kWait = std::chrono::milliseconds(50);
// After the first answer, where there may be others: twice the interval of discovery, and then some.
constexpr Duration kForOthers = std::chrono::seconds(3);

std::string Describe(const std::string& host, int port) {
  return port == 0 ? host : fmt::format("{}:{}", host, port);
}

Result<Config> Parse(const dadrl_idl_RunConfig& message) {
  Config config;
  const std::string_view yaml(reinterpret_cast<const char*>(message.yaml._buffer), message.yaml._length);
  DADRL_RETURN_IF_ERROR(ParseYaml(yaml, "the configuration of the run", config));
  DADRL_RETURN_IF_ERROR(Validate(config));
  return config;
}

Result<Config> TheOnly(std::map<int, Config> found, const std::string& host) {
  if (found.size() == 1) return std::move(found.begin()->second);
  std::string ports;
  for (const auto& [port, config] : found) ports += fmt::format(" {}:{} ({})", host, port, config.scenario);
  return Fail(ErrorCode::kInvalidArgument, "{} clusters run at {}: choose one of{}", found.size(), host,
              ports);
}

}  // namespace

Result<Config> FindRun(const std::string& host, int port, Duration patience,
                       const std::function<bool()>& stop) {
  ClusterConfig cluster;
  cluster.host = host;
  cluster.port = port;
  DADRL_ASSIGN_OR_RETURN(const auto node, dds::Node::Create(cluster, 1, dds::Role::kMonitor, 0));
  DADRL_ASSIGN_OR_RETURN(const auto reader, dds::Reader<dadrl_idl_RunConfig>::Create(*node, kRunConfigTopic));
  std::map<int, Config> found;  // by port
  Status failure;
  const SystemClock clock;
  for (TimePoint end = clock.Now() + patience; clock.Now() < end && !stop();) {
    reader->Wait(kWait);
    reader->Take(16, [&](const dadrl_idl_RunConfig& message) {
      Result<Config> config = Parse(message);
      if (!config) {
        failure = tl::unexpected(config.error());
        return;
      }
      if (found.empty()) end = clock.Now() + (port == 0 ? kForOthers : Duration::zero());
      config->cluster.host = host;
      found[config->cluster.port] = std::move(*config);
    });
  }
  if (!found.empty()) return TheOnly(std::move(found), host);
  if (!failure) return tl::unexpected(failure.error());
  return Fail(ErrorCode::kUnavailable,
              "no run answers at {}: is it running, was it started with --set cluster.host=ADDRESS that this "
              "machine reaches, and do firewalls let UDP through ({} ports from cluster.port on)?",
              Describe(host, port), dds::kPortBlock);
}

}  // namespace dadrl
