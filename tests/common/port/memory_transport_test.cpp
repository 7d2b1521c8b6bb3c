#include "common/port/memory_transport.h"

#include <gmock/gmock.h>

#include "proto/topics.h"
#include "tests/common/dds/dds_fixture.h"

namespace dadrl::dds {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::Pair;

using Numbers = std::vector<std::pair<uint32_t, uint32_t>>;  // source, number

class MemoryTransportTest : public testing::Test {
 protected:
  Status Write(BlobWriter& writer, uint32_t source, uint32_t number) {
    dds_test_Blob blob = MakeBlob(number, bytes_);
    blob.source = source;
    return writer.Write(blob);
  }
  static Numbers Take(BlobReader& reader) {
    Numbers numbers;
    reader.Take(100, [&](const dds_test_Blob& blob) { numbers.emplace_back(blob.source, blob.number); });
    return numbers;
  }

  ManualClock clock_;
  const MemoryTransport transport_{clock_};
  std::vector<uint8_t> bytes_{1, 2, 3};
};

TEST_F(MemoryTransportTest, ASampleOwnsWhatItsSequencesHold) {
  const auto reader = BlobReader::Create(transport_, kStream).value();
  const auto writer = BlobWriter::Create(transport_, kStream).value();
  ASSERT_TRUE(Write(*writer, 1, 7));
  bytes_.assign(3, 9);
  std::vector<uint8_t> received;
  EXPECT_EQ(reader->Take(1,
                         [&](const dds_test_Blob& blob) {
                           received.assign(blob.bytes._buffer, blob.bytes._buffer + blob.bytes._length);
                         }),
            1);
  EXPECT_THAT(received, ElementsAre(1, 2, 3));
}

TEST_F(MemoryTransportTest, AReaderKeepsTheNewestOfEachKey) {
  TopicSpec topic = kStream;
  topic.reader_max_samples = 0;
  topic.reader_keeps_last = 2;
  const auto newest = BlobReader::Create(transport_, kNewest).value();
  const auto two = BlobReader::Create(transport_, topic).value();
  const auto to_newest = BlobWriter::Create(transport_, kNewest).value();
  const auto to_two = BlobWriter::Create(transport_, topic).value();
  for (uint32_t number = 1; number <= 3; ++number) {
    for (uint32_t source = 1; source <= 2; ++source) {
      ASSERT_TRUE(Write(*to_newest, source, number));
      ASSERT_TRUE(Write(*to_two, source, number));
    }
  }
  EXPECT_THAT(Take(*newest), ElementsAre(Pair(1, 3), Pair(2, 3)));
  EXPECT_THAT(Take(*two), ElementsAre(Pair(1, 2), Pair(2, 2), Pair(1, 3), Pair(2, 3)));
}

TEST_F(MemoryTransportTest, ALateReaderGetsTheNewestOfEachKeyAndOfWritersThatAreThere) {
  const auto writer = BlobWriter::Create(transport_, kNewest).value();
  auto gone = BlobWriter::Create(transport_, kNewest).value();
  for (uint32_t number = 1; number <= 3; ++number) ASSERT_TRUE(Write(*writer, number % 2, number));
  ASSERT_TRUE(Write(*gone, 5, 50));
  gone.reset();
  const auto reader = BlobReader::Create(transport_, kNewest).value();
  EXPECT_THAT(Take(*reader), ElementsAre(Pair(0, 2), Pair(1, 3)));
}

TEST_F(MemoryTransportTest, WhoeverWaitsOnAManualClockLetsTheTimePass) {
  const auto reader = BlobReader::Create(transport_, kStream).value();
  const auto writer = BlobWriter::Create(transport_, kStream).value();
  EXPECT_FALSE(reader->Wait(3s));
  EXPECT_EQ(clock_.Now(), TimePoint{3s});
  for (int i = 0; i < kStream.reader_max_samples; ++i) ASSERT_TRUE(Write(*writer, 1, 1));
  const Status full = Write(*writer, 1, 2);
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(clock_.Now(), TimePoint{3s + std::chrono::milliseconds(kStream.max_blocking_ms)});
  EXPECT_TRUE(reader->Wait(3s)) << "and not when there is something to take";
  reader->Take(1, [](const dds_test_Blob&) {});
  EXPECT_TRUE(Write(*writer, 1, 2));
  EXPECT_EQ(Take(*reader).size(), static_cast<size_t>(kStream.reader_max_samples));
}

TEST_F(MemoryTransportTest, CarriesEveryTopicOfTheCluster) {
  for (const TopicSpec& topic :
       {ChunkTopic(0), AcknowledgementTopic(0), kBatchRequestTopic, kBatchReplyTopic, kPriorityTopic,
        kReplayCommandTopic, kReplayAnswerTopic, kWeightsTopic, kRunConfigTopic, kRunStateTopic,
        kLeaseRequestTopic, LeaseAnswerTopic({}), kTelemetryTopic}) {
    const auto writer = transport_.OpenWriter(topic);
    EXPECT_TRUE(writer) << topic.name << ": " << writer.error().message;
  }
}

TEST_F(MemoryTransportTest, RefusesATypeThatItCannotCopyWhole) {
  TopicSpec topic = kStream;
  topic.type = &dds_test_Note_desc;
  const auto writer = transport_.OpenWriter(topic);
  ASSERT_FALSE(writer);
  EXPECT_THAT(writer.error().message, testing::HasSubstr("dds_test::Note"));
}

}  // namespace
}  // namespace dadrl::dds
