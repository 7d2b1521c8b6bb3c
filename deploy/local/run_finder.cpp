#include "deploy/local/run_finder.h"

#include <charconv>
#include <map>
#include <string_view>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/dds/address.h"
#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/log.h"
#include "common/util/shown.h"
#include "proto/topics.h"

namespace dadrl {
namespace {

constexpr Duration kWait = std::chrono::milliseconds(50);
// After the first answer, where there may be others: twice the interval of discovery, and then some.
constexpr Duration kForOthers = std::chrono::seconds(3);

tl::unexpected<Error> NobodyAnswers(const RunPlace& place, bool loopback) {
  const std::string where = place.port == 0 ? place.host : fmt::format("{}:{}", place.host, place.port);
  if (loopback) {
    return Fail(
        ErrorCode::kUnavailable,
        "no run answers at {}: is it running? One on this machine alone answers only who has its key, "
        "and {}: name it with --key RUN/key",
        where, place.key.empty() ? "none was given" : "the one given may be another run's");
  }
  return Fail(
      ErrorCode::kUnavailable,
      "no run answers at {}: is it running, was it started with --set cluster.host=ADDRESS that this "
      "machine reaches, do firewalls let UDP through ({} ports from cluster.port on), {}, and do "
      "packets of this interface's size get there whole (if not: --set cluster.mtu=1280 on both sides)?",
      where, dds::kPortBlock,
      place.key.empty() ? "does it ask for its key (--key)"
                        : "is the key its own, and cluster.require_key set");
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
  for (const auto& [port, config] : found) {
    ports += fmt::format(" {}:{} ({})", host, port, Shown(config.scenario));
  }
  return Fail(ErrorCode::kInvalidArgument, "{} clusters run at {}: choose one of{}", found.size(), host,
              ports);
}

}  // namespace

Result<RunPlace> ParseRunPlace(const std::string& text) {
  const size_t colon = text.find(':');
  RunPlace place{.host = text.substr(0, colon)};
  if (colon != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + colon + 1, end, place.port);
    if (error != std::errc() || stop != end || place.port < 1 || place.port > 60000) {
      return Fail(ErrorCode::kInvalidArgument,
                  "--join: '{}' is not HOST or HOST:PORT with a port of 1 to 60000", text);
    }
  }
  if (place.host.empty()) return Fail(ErrorCode::kInvalidArgument, "--join: '{}' names no host", text);
  return place;
}

Result<Config> FindRun(const RunPlace& place, Duration patience, const std::function<bool()>& stop) {
  ClusterConfig cluster;
  DADRL_ASSIGN_OR_RETURN(cluster.host, dds::ResolveHost(place.host));
  cluster.port = place.port;
  cluster.mtu = place.mtu;
  cluster.require_key = !place.key.empty();
  DADRL_ASSIGN_OR_RETURN(const auto node, dds::Node::Create(cluster, 1, dds::Role::kMonitor, 0, place.key));
  DADRL_ASSIGN_OR_RETURN(const auto reader, Reader<dadrl_idl_RunConfig>::Create(*node, kRunConfigTopic));
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
      if (found.empty()) end = clock.Now() + (place.port == 0 ? kForOthers : Duration::zero());
      config->cluster.host = cluster.host;
      found[config->cluster.port] = std::move(*config);
    });
  }
  if (!found.empty()) return TheOnly(std::move(found), place.host);
  if (!failure) return tl::unexpected(failure.error());
  return NobodyAnswers(place, dds::IsLoopback(cluster.host));
}

}  // namespace dadrl
