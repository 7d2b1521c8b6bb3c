#include "common/io/json_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dadrl {
namespace {

using testing::HasSubstr;

std::string Nested(int levels) {
  return std::string(static_cast<size_t>(levels), '[') + std::string(static_cast<size_t>(levels), ']');
}

TEST(JsonText, IsReadAsDeepAsTheLimit) {
  EXPECT_TRUE(ParseJson(Nested(kMaxJsonDepth), "x"));
  for (const int levels : {kMaxJsonDepth + 1, 100000}) {
    const auto json = ParseJson(Nested(levels), "x");
    ASSERT_FALSE(json) << levels;
    EXPECT_EQ(json.error().message, "x is nested deeper than 16 levels");
  }
}

// Millions of fields would take hours, and of a key that is there twice either may be meant.
TEST(JsonText, AnObjectHasAThousandFieldsEachOnce) {
  std::string text;
  for (size_t i = 0; i < kMaxJsonKeys; ++i) text += fmt::format("{}\"k{}\":{{}}", i == 0 ? "" : ",", i);
  EXPECT_TRUE(ParseJson("[{" + text + "},{" + text + "}]", "x"));
  const auto wide = ParseJson("{" + text + ",\"more\":0}", "x");
  ASSERT_FALSE(wide);
  EXPECT_EQ(wide.error().message, "x has an object of more than 1000 fields");
  const auto twice = ParseJson(R"({"b": {"a\n": 1, "b": 0, "a\n": 2}})", "x");
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().message, "x names 'a\\x0a' twice");
}

TEST(JsonText, WhatIsNoneIsNamedInOneLine) {
  for (const char* text : {"", "{", "[1,]", "nan", "1e999", "\"\xff\"", "{\"a\":\n\n1"}) {
    const auto json = ParseJson(text, "x.json");
    ASSERT_FALSE(json) << text;
    EXPECT_EQ(json.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(json.error().message, HasSubstr("x.json is not JSON"));
    EXPECT_EQ(json.error().message.find('\n'), std::string::npos);
  }
}

TEST(JsonFields, TakesWhatIsThereAndNamesTheFirstThatIsNot) {
  const auto json = ParseJson(R"({"n": 7, "x": -1.5, "b": true, "t": "text"})", "x").value();
  JsonFields fields(json);
  EXPECT_EQ(fields.Whole("n", 7), 7);
  EXPECT_EQ(fields.Number("x", -2, 0), -1.5);
  EXPECT_TRUE(fields.Boolean("b"));
  EXPECT_EQ(fields.Text("t", 4), "text");
  EXPECT_TRUE(fields.ok());
  EXPECT_EQ(fields.Whole("missing", 7), 0);
  EXPECT_EQ(fields.Text("t", 3), "");
  EXPECT_EQ(fields.bad(), "missing");
}

TEST(JsonFields, NeverTruncatesANumber) {
  const auto json =
      ParseJson(R"({"big": 1e300, "half": 0.5, "negative": -1, "text": "1", "null": null})", "x").value();
  for (const char* key : {"big", "half", "negative", "text", "null"}) {
    JsonFields fields(json);
    fields.Whole(key, UINT64_MAX);
    EXPECT_EQ(fields.bad(), key);
  }
  JsonFields fields(json);
  fields.Number("big", 0, 1e9);
  EXPECT_EQ(fields.bad(), "big");
  const auto list = ParseJson("[1]", "x").value();
  JsonFields none(list);
  EXPECT_FALSE(none.Has("0"));
}

}  // namespace
}  // namespace dadrl
