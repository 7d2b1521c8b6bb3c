#include "common/io/checksum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "common/io/crc32c.h"

namespace dadrl {
namespace {

std::span<const std::byte> Bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

TEST(Xxh3, MatchesTheReferenceValueOfTheEmptyInput) { EXPECT_EQ(Xxh3({}), 0x2D06800538D394C2u); }

TEST(Xxh3, StreamInPiecesEqualsOneCall) {
  const std::string text(100000, 'x');
  Xxh3Stream stream;
  for (size_t begin = 0; begin < text.size(); begin += 777) {
    stream.Add(Bytes(text).subspan(begin, std::min<size_t>(777, text.size() - begin)));
  }
  EXPECT_EQ(stream.Digest(), Xxh3(Bytes(text)));
}

TEST(Xxh3, OneFlippedBitChangesIt) {
  std::string text(1000, 'a');
  const uint64_t before = Xxh3(Bytes(text));
  text[500] = static_cast<char>(text[500] ^ 1);
  EXPECT_NE(Xxh3(Bytes(text)), before);
}

TEST(CheckedContent, IsWhatTheChecksumWasAppendedTo) {
  const auto text = Bytes("what was written");
  std::vector<std::byte> bytes(text.begin(), text.end());
  AppendChecksum(bytes);
  ASSERT_EQ(bytes.size(), text.size() + kChecksumBytes);
  const auto content = CheckedContent(bytes);
  ASSERT_TRUE(content);
  EXPECT_TRUE(std::ranges::equal(*content, text));
  for (size_t i = 0; i < bytes.size(); ++i) {
    std::vector<std::byte> bad = bytes;
    bad[i] ^= std::byte{1};
    EXPECT_FALSE(CheckedContent(bad)) << "byte " << i;
    EXPECT_FALSE(CheckedContent(std::span(bytes).first(i))) << i << " bytes";
  }
}

TEST(CheckedContent, MayBeEmpty) {
  std::vector<std::byte> bytes;
  AppendChecksum(bytes);
  ASSERT_TRUE(CheckedContent(bytes));
  EXPECT_TRUE(CheckedContent(bytes)->empty());
}

// RFC 3720, B.4, and the check value of the CRC catalogue.
TEST(Crc32c, MatchesPublishedVectors) {
  EXPECT_EQ(Crc32c(Bytes("123456789")), 0xE3069283u);
  EXPECT_EQ(Crc32c(Bytes(std::string(32, '\0'))), 0x8A9136AAu);
  EXPECT_EQ(Crc32c(Bytes(std::string(32, '\xff'))), 0x62A8AB43u);
  EXPECT_EQ(Crc32c({}), 0u);
}

TEST(Crc32c, MaskRotatesByFifteenAndAddsTheConstant) {
  const uint32_t crc = Crc32c(Bytes("123456789"));
  EXPECT_EQ(MaskedCrc32c(Bytes("123456789")), ((crc >> 15) | (crc << 17)) + 0xA282EAD8u);
}

}  // namespace
}  // namespace dadrl
