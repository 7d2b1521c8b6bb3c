// Several actors in one process, each a DDS participant of its own: joins, sends its chunks, ends when all
// are acknowledged, none of them as refused.
//
//   many_actors CONFIG FIRST_ID ACTORS CHUNKS
#include <cstdlib>
#include <memory>
#include <vector>

#include "common/config/config_yaml.h"
#include "common/dds/node.h"
#include "common/util/log.h"
#include "tests/common/io/test_run_key.h"
#include "tests/replay/service/peer_actor.h"

int main(int argc, char** argv) {
  using namespace dadrl;
  if (argc != 5) return 2;
  InitLogging("many_actors");
  Config config;
  if (const Status loaded = LoadYaml(argv[1], config); !loaded) {
    spdlog::error("{}", loaded.error().message);
    return 1;
  }
  const int first = std::atoi(argv[2]);
  const int count = std::atoi(argv[3]);
  const int chunks = std::atoi(argv[4]);
  std::vector<std::unique_ptr<dds::Node>> nodes;
  std::vector<std::unique_ptr<PeerActor>> actors;
  for (int id = first; id < first + count; ++id) {
    auto node = dds::Node::Create(config.cluster, config.replay.shards, dds::Role::kActor, id, kTestRunKey);
    if (!node) {
      spdlog::error("actor {}: {}", id, node.error().message);
      return 1;
    }
    nodes.push_back(std::move(*node));
    actors.push_back(std::make_unique<PeerActor>(*nodes.back(), static_cast<uint32_t>(id), 1));
    for (int i = 0; i < chunks; ++i) {
      actors.back()->Add({.episode = static_cast<uint64_t>(i + 1), .end = kTerminated});
    }
  }
  const bool done = Eventually(
      [&] {
        bool all = true;
        for (const auto& actor : actors) {
          actor->Pump();
          all &= actor->stored() == actor->produced() && actor->refused() == 0;
        }
        return all;
      },
      std::chrono::seconds(120));
  return done ? 0 : 1;
}
