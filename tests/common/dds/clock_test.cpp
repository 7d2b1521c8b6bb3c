// What a wall clock that jumps does to DDS.
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <atomic>

#include "common/port/port.h"
#include "dds_test_types.h"
#include "tests/common/dds/dds_fixture.h"
#include "tests/common/util/eventually.h"

namespace {

std::atomic<int64_t> wall_clock_offset_s{0};

}  // namespace

// Stands in for the system's, in the libraries too: the wall clock, set as the test says.
extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const long result = syscall(SYS_clock_gettime, clock, time);
  if (clock == CLOCK_REALTIME) time->tv_sec += wall_clock_offset_s.load();
  return static_cast<int>(result);
}

namespace dadrl::dds {
namespace {

constexpr int64_t kYear_s = 365 * 24 * 3600;

TEST(WallClock, JumpsByYearsStopNoDelivery) {
  const ClusterConfig cluster = LoopbackCluster();
  const auto replay = MakeNode(cluster, Role::kReplay);
  const auto actor = MakeNode(cluster, Role::kActor);
  const auto reader = BlobReader::Create(*replay, kStream).value();
  const auto writer = BlobWriter::Create(*actor, kStream).value();
  ASSERT_TRUE(Eventually([&] { return writer->matched() == 1; }));
  std::vector<uint8_t> bytes(1000);
  uint32_t number = 0;
  const auto deliver = [&] {
    ++number;
    if (!Eventually([&] { return writer->Write(MakeBlob(number, bytes)).has_value(); })) return false;
    uint32_t taken = 0;
    return Eventually([&] {
      reader->Take(10, [&](const dds_test_Blob& blob) { taken = blob.number; });
      return taken == number;
    });
  };
  ASSERT_TRUE(deliver());
  for (const int64_t offset_s : {kYear_s, -kYear_s, int64_t{0}}) {
    wall_clock_offset_s.store(offset_s);
    // Longer than a lease: whoever has not renewed his by then is taken for dead.
    const TimePoint end = SystemClock().Now() + 2 * FromSeconds(cluster.lease_s);
    while (SystemClock().Now() < end) ASSERT_TRUE(deliver()) << offset_s;
    EXPECT_EQ(writer->matched(), 1) << offset_s;
    EXPECT_TRUE(replay && actor);
  }
}

}  // namespace
}  // namespace dadrl::dds
