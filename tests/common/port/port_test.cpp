#include "common/port/port.h"

#include <gmock/gmock.h>

#include <numeric>
#include <thread>

#include "common/port/memory_transport.h"
#include "tests/common/dds/dds_fixture.h"

namespace dadrl::dds {
namespace {

enum class Body { kDds, kMemory };

class PortTest : public ::testing::TestWithParam<Body> {
 protected:
  PortTest() {
    if (GetParam() == Body::kMemory) return;
    const ClusterConfig cluster = LoopbackCluster();
    replay_ = MakeNode(cluster, Role::kReplay);
    actor_ = MakeNode(cluster, Role::kActor);
  }
  const Transport& replay() const { return replay_ ? static_cast<const Transport&>(*replay_) : memory_; }
  const Transport& actor() const { return actor_ ? static_cast<const Transport&>(*actor_) : memory_; }

 private:
  const MemoryTransport memory_;
  std::unique_ptr<Node> replay_;
  std::unique_ptr<Node> actor_;
};

INSTANTIATE_TEST_SUITE_P(Transports, PortTest, ::testing::Values(Body::kDds, Body::kMemory),
                         [](const auto& info) { return info.param == Body::kDds ? "Dds" : "Memory"; });

std::vector<uint32_t> TakeNumbers(BlobReader& reader, int max = 1000) {
  std::vector<uint32_t> numbers;
  reader.Take(max, [&](const dds_test_Blob& blob) { numbers.push_back(blob.number); });
  return numbers;
}

TEST_P(PortTest, DeliversEverySampleWholeAndInOrder) {
  const auto reader = BlobReader::Create(replay(), kStream).value();
  const auto writer = BlobWriter::Create(actor(), kStream).value();
  ASSERT_TRUE(Eventually([&] { return writer->matched() == 1; }));
  constexpr uint32_t kSamples = 40;
  std::vector<uint8_t> sent(300000);
  std::iota(sent.begin(), sent.end(), uint8_t{0});
  std::thread sender([&] {
    for (uint32_t i = 0; i < kSamples;) i += writer->Write(MakeBlob(i, sent)) ? 1 : 0;
  });
  uint32_t expected = 0;
  EXPECT_TRUE(Eventually([&] {
    reader->Wait(std::chrono::milliseconds(100));
    reader->Take(100, [&](const dds_test_Blob& blob) {
      EXPECT_EQ(blob.number, expected++);
      EXPECT_TRUE(
          std::equal(sent.begin(), sent.end(), blob.bytes._buffer, blob.bytes._buffer + blob.bytes._length));
    });
    return expected == kSamples;
  }));
  sender.join();
}

uint32_t last_number = 0;
void KeepNumber(const dds_test_Blob& blob) { last_number = blob.number; }

TEST_P(PortTest, TakesAnyCallable) {
  const auto writer = BlobWriter::Create(replay(), kNewest).value();
  std::vector<uint8_t> bytes(10);
  ASSERT_TRUE(writer->Write(MakeBlob(7, bytes)));
  uint32_t number = 0;
  auto visit = [&number](const dds_test_Blob& blob) mutable { number = blob.number; };
  const auto constant = [&number](const dds_test_Blob& blob) { number = blob.number; };
  const auto take = [&](auto&& visitor) {
    const auto reader = BlobReader::Create(actor(), kNewest).value();
    EXPECT_TRUE(reader->Wait(std::chrono::seconds(20)));
    EXPECT_EQ(reader->Take(1, visitor), 1);
    return std::exchange(number, 0);
  };
  EXPECT_EQ(take(visit), 7u);
  EXPECT_EQ(take(constant), 7u);
  take(KeepNumber);
  EXPECT_EQ(last_number, 7u);
}

TEST_P(PortTest, GivesALateReaderTheNewestSampleOnly) {
  const auto writer = BlobWriter::Create(replay(), kNewest).value();
  std::vector<uint8_t> bytes(2000000);
  for (uint32_t version = 1; version <= 3; ++version) ASSERT_TRUE(writer->Write(MakeBlob(version, bytes)));
  const auto reader = BlobReader::Create(actor(), kNewest).value();
  EXPECT_TRUE(reader->Wait(std::chrono::seconds(20)));
  EXPECT_THAT(TakeNumbers(*reader), ::testing::ElementsAre(3));
}

TEST_P(PortTest, PushesBackWhenTheReaderIsFull) {
  const auto reader = BlobReader::Create(replay(), kStream).value();
  const auto writer = BlobWriter::Create(actor(), kStream).value();
  ASSERT_TRUE(Eventually([&] { return writer->matched() == 1; }));
  std::vector<uint8_t> bytes(100000);
  uint32_t sent = 0;
  Status status;
  while ((status = writer->Write(MakeBlob(sent, bytes))) && sent < 1000) ++sent;
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kUnavailable);
  // What was accepted arrives; what was refused was not sent.
  std::vector<uint32_t> received;
  EXPECT_TRUE(Eventually([&] {
    for (const uint32_t number : TakeNumbers(*reader)) received.push_back(number);
    return received.size() >= sent;
  }));
  EXPECT_TRUE(Eventually([&] { return writer->Write(MakeBlob(sent, bytes)).has_value(); }));
  EXPECT_TRUE(Eventually([&] {
    for (const uint32_t number : TakeNumbers(*reader)) received.push_back(number);
    return received.size() == sent + 1;
  }));
  for (uint32_t i = 0; i < received.size(); ++i) EXPECT_EQ(received[i], i);
}

TEST_P(PortTest, AFullReaderLeavesTheOtherPlaneAlone) {
  const auto full = BlobReader::Create(replay(), kStream).value();
  const auto newest = BlobReader::Create(replay(), kNewest).value();
  const auto stream = BlobWriter::Create(actor(), kStream).value();
  const auto control = BlobWriter::Create(actor(), kNewest).value();
  ASSERT_TRUE(Eventually([&] { return stream->matched() == 1 && control->matched() == 1; }));
  std::vector<uint8_t> bytes(100000);
  while (stream->Write(MakeBlob(0, bytes))) {
  }
  for (uint32_t i = 1; i <= 20; ++i) {
    ASSERT_TRUE(control->Write(MakeBlob(i, bytes)));
    ASSERT_TRUE(Eventually([&] { return TakeNumbers(*newest) == std::vector<uint32_t>{i}; }));
  }
}

// A reader that comes late, to a writer that has written before, is served on another path inside Cyclone
// than one that was there from the start.
TEST_P(PortTest, AFullReaderCanLeaveWhileItsWriterGoesOn) {
  const auto writer = BlobWriter::Create(actor(), kStream).value();
  std::atomic<bool> stop{false};
  std::atomic<int> refused{0};
  std::thread sender([&] {
    std::vector<uint8_t> bytes(1000);
    while (!stop) refused += writer->Write(MakeBlob(0, bytes)) ? 0 : 1;
  });
  for (int i = 0; i < 3; ++i) {
    auto reader = BlobReader::Create(replay(), kStream).value();
    const int before = refused;
    EXPECT_TRUE(Eventually([&] { return refused > before; }));
    reader = nullptr;
    EXPECT_TRUE(Eventually([&] { return writer->matched() == 0; }));
  }
  stop = true;
  sender.join();
}

TEST_P(PortTest, PartitionsMatchOnlyTheirOwn) {
  TopicSpec zero = kStream;
  zero.partition = 0;
  TopicSpec one = kStream;
  one.partition = 1;
  const auto reader_zero = BlobReader::Create(replay(), zero).value();
  const auto reader_one = BlobReader::Create(replay(), one).value();
  const auto writer = BlobWriter::Create(actor(), one).value();
  ASSERT_TRUE(Eventually([&] { return writer->matched() == 1; }));
  EXPECT_TRUE(Eventually([&] { return reader_one->matched() == 1; }));
  EXPECT_EQ(reader_zero->matched(), 0);
}

TEST_P(PortTest, WakeEndsAWaitWithoutASample) {
  const auto reader = BlobReader::Create(replay(), kStream).value();
  reader->Wake();
  EXPECT_FALSE(reader->Wait(std::chrono::hours(1)));
  std::thread waker([&] { reader->Wake(); });
  EXPECT_FALSE(reader->Wait(std::chrono::hours(1)));
  waker.join();
  EXPECT_FALSE(reader->Wait(Duration::zero()));
}

TEST_P(PortTest, CountsEachNewReaderAsAGeneration) {
  const auto writer = BlobWriter::Create(actor(), kStream).value();
  uint64_t generation = writer->match_generation();
  for (int i = 0; i < 2; ++i) {
    auto reader = BlobReader::Create(replay(), kStream).value();
    ASSERT_TRUE(Eventually([&] { return writer->matched() == 1; }));
    EXPECT_GT(writer->match_generation(), generation);
    generation = writer->match_generation();
    reader = nullptr;
    ASSERT_TRUE(Eventually([&] { return writer->matched() == 0; }));
  }
}

}  // namespace
}  // namespace dadrl::dds
