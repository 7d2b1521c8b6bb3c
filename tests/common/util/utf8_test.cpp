#include "common/util/utf8.h"

#include <gtest/gtest.h>

#include <string>

namespace dadrl {
namespace {

TEST(Utf8, TakesPrintableTextOnly) {
  for (const char* good : {"", "left turn", "Mündung", "東京", "\xf0\x9f\x9a\x97"}) {
    EXPECT_TRUE(IsPrintableUtf8(good)) << good;
  }
  for (const char* bad : {"\n", "\x7f", "\xc2\x9b",               // control characters
                          "\xff", "\x80", "\xc3", "\xe6\x9d",     // not whole
                          "\xc0\xaf", "\xe0\x80\xaf",             // longer than need be
                          "\xed\xa0\x80", "\xf4\x90\x80\x80"}) {  // no characters
    EXPECT_FALSE(IsPrintableUtf8(std::string("a") + bad)) << bad;
  }
}

TEST(Utf8, PrefixCutsBetweenCharacters) {
  EXPECT_EQ(Utf8Prefix("Mündung", 1), "M");
  EXPECT_EQ(Utf8Prefix("Mündung", 2), "M");
  EXPECT_EQ(Utf8Prefix("Mündung", 3), "Mü");
  EXPECT_EQ(Utf8Prefix("Mündung", 99), "Mündung");
  EXPECT_EQ(Utf8Prefix("\x80\x80", 1), "");
}

}  // namespace
}  // namespace dadrl
