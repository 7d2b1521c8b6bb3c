#include "common/dds/cluster_key.h"

#include "common/dds/address.h"
#include "common/io/run_key.h"

namespace dadrl::dds {

bool AsksForKey(const ClusterConfig& cluster) { return cluster.require_key || IsLoopback(cluster.host); }

Result<std::string> LoadClusterKey(const std::filesystem::path& run_directory, const ClusterConfig& cluster) {
  ClusterConfig resolved = cluster;
  DADRL_ASSIGN_OR_RETURN(resolved.host, ResolveHost(cluster.host));
  if (!AsksForKey(resolved)) return std::string();
  auto key = ReadRunKey(RunKeyFile(run_directory));
  if (key) return key;
  return Fail(key.error().code,
              "{}; a run {} is taken part in with its key alone: put the file back, or go on with a new one: "
              "dadrl train --resume --run-dir {}",
              key.error().message, cluster.require_key ? "with cluster.require_key" : "on " + cluster.host,
              run_directory.string());
}

}  // namespace dadrl::dds
