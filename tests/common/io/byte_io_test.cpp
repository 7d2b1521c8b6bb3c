#include "common/io/byte_io.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

TEST(ByteIo, ReadsBackWhatWasWritten) {
  std::vector<std::byte> buffer;
  ByteWriter writer(buffer);
  writer.Put<uint16_t>(0x1234);
  writer.Put(-2.5);
  writer.PutText("name");
  EXPECT_EQ(buffer[0], std::byte{0x34});  // little endian
  ByteReader reader(buffer);
  EXPECT_EQ(reader.Get<uint16_t>(), 0x1234);
  EXPECT_EQ(reader.Get<double>(), -2.5);
  EXPECT_EQ(reader.GetText(), "name");
  EXPECT_TRUE(reader.ok());
  EXPECT_EQ(reader.remaining(), 0u);
}

TEST(ByteIo, EveryTruncationIsNoticedAndReadsNothing) {
  std::vector<std::byte> buffer;
  ByteWriter writer(buffer);
  writer.Put<uint64_t>(7);
  writer.PutText("some text");
  for (size_t length = 0; length < buffer.size(); ++length) {
    ByteReader reader(std::span<const std::byte>(buffer).first(length));
    reader.Get<uint64_t>();
    EXPECT_TRUE(reader.GetText().empty());
    EXPECT_FALSE(reader.ok()) << length;
  }
}

TEST(ByteIo, LengthBeyondTheEndIsRefusedAndStaysRefused) {
  std::vector<std::byte> buffer;
  ByteWriter writer(buffer);
  writer.Put<uint32_t>(0xFFFFFFFFu);
  writer.Put<uint32_t>(1);
  ByteReader reader(buffer);
  EXPECT_TRUE(reader.GetText().empty());
  EXPECT_EQ(reader.Get<uint32_t>(), 0u);
  EXPECT_FALSE(reader.ok());
}

}  // namespace
}  // namespace dadrl
