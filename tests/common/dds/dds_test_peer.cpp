// A second process for tests: an actor that beats on kBeat until it is killed. Arguments: port, liveliness.
#include <cstdlib>
#include <string>

#include "tests/common/dds/dds_fixture.h"

int main(int argc, char** argv) {
  using namespace dadrl;
  if (argc != 3) return 2;
  ClusterConfig cluster;
  cluster.port = std::atoi(argv[1]);
  cluster.lease_s = 60.0;
  cluster.liveliness_s = std::atof(argv[2]);
  const auto node = dds::Node::Create(cluster, 1, dds::Role::kActor, 0);
  if (!node) return 1;
  const auto writer = dds::BlobWriter::Create(**node, dds::kBeat);
  if (!writer) return 1;
  SystemClock clock;
  std::vector<uint8_t> bytes(4);
  for (uint32_t beat = 1;; ++beat) {
    if (!(*writer)->Write(dds::MakeBlob(beat, bytes))) return 1;
    clock.SleepFor(FromSeconds(cluster.liveliness_s / 5.0));
  }
}
