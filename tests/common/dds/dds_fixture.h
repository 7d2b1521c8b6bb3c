// A cluster's nodes in one test process, over real DDS on loopback.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "common/dds/node.h"
#include "common/port/port.h"
#include "dds_test_types.h"
#include "tests/common/util/eventually.h"

namespace dadrl::dds {

inline ClusterConfig LoopbackCluster() {
  ClusterConfig cluster;
  cluster.port = FindFreePort().value();
  cluster.lease_s = 3.0;
  return cluster;
}

inline std::unique_ptr<Node> MakeNode(const ClusterConfig& cluster, Role role, int index = 0) {
  auto node = Node::Create(cluster, 1, role, index);
  EXPECT_TRUE(node) << node.error().message;
  return node ? std::move(*node) : nullptr;
}

inline dds_test_Blob MakeBlob(uint32_t number, std::vector<uint8_t>& bytes) {
  dds_test_Blob blob{};
  blob.source = 1;
  blob.number = number;
  blob.bytes._maximum = blob.bytes._length = static_cast<uint32_t>(bytes.size());
  blob.bytes._buffer = bytes.data();
  blob.bytes._release = false;
  return blob;
}

inline const TopicSpec kStream{.name = "test/stream",
                               .type = &dds_test_Blob_desc,
                               .plane = Plane::kExperience,
                               .reader_max_samples = 8,
                               .max_blocking_ms = 50};
inline const TopicSpec kNewest{.name = "test/newest",
                               .type = &dds_test_Blob_desc,
                               .plane = Plane::kControl,
                               .keep_all = false,
                               .transient_local = true};
using BlobWriter = Writer<dds_test_Blob>;
using BlobReader = Reader<dds_test_Blob>;

}  // namespace dadrl::dds
