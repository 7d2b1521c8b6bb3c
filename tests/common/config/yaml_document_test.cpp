#include "common/config/yaml_document.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>

#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

std::string ErrorOf(std::string_view text) {
  const auto document = ParseYamlDocument(text, "x");
  EXPECT_FALSE(document) << text.substr(0, 100);
  if (document) return "";
  EXPECT_EQ(document.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(document.error().message.find('\n'), std::string::npos) << "one line";
  return document.error().message;
}

std::string Repeated(std::string_view text, size_t times) {
  std::string all;
  for (size_t i = 0; i < times; ++i) all += text;
  return all;
}

TEST(YamlDocument, IsATreeWithLines) {
  const auto root = ParseYamlDocument("a: 1\nb:\n  - x\n  - {c: 'y z'}\nd:\n", "x");
  ASSERT_TRUE(root) << root.error().message;
  ASSERT_TRUE(root->IsMap());
  EXPECT_EQ(root->Find("a")->text, "1");
  const YamlNode& list = *root->Find("b");
  ASSERT_TRUE(list.IsList());
  ASSERT_EQ(list.items.size(), 2u);
  EXPECT_EQ(list.items[0].text, "x");
  EXPECT_EQ(list.items[1].Find("c")->text, "y z");
  EXPECT_EQ(list.items[1].entries[0].line, 4);
  EXPECT_EQ(root->Find("d")->kind, YamlNode::Kind::kNull);
  EXPECT_EQ(root->Find("e"), nullptr);
}

TEST(YamlDocument, NothingIsAnEmptyDocument) {
  for (const char* text : {"", "\n\n", "# only words\n", "---\n", "null\n"}) {
    const auto root = ParseYamlDocument(text, "x");
    ASSERT_TRUE(root) << root.error().message;
    EXPECT_EQ(root->kind, YamlNode::Kind::kNull) << text;
  }
}

TEST(YamlDocument, RefusesWhatCouldRecurseOrExpand) {
  EXPECT_EQ(ErrorOf("task: &t\n  reward: *t\n"), "x:1: anchors (&name) are not taken: write the value out");
  EXPECT_THAT(ErrorOf("a: &a [1]\nb: [*a, *a]\n"), HasSubstr("x:1: anchors"));
  EXPECT_THAT(ErrorOf("a: *b\n"), HasSubstr("x:1: "));
  EXPECT_THAT(ErrorOf("&a a: 1\n"), HasSubstr("anchors"));
  EXPECT_THAT(ErrorOf("a: &a\n"), HasSubstr("anchors"));
  EXPECT_EQ(ErrorOf("a: !!python/object:os.system x\n"),
            "x:1: the tag tag:yaml.org,2002:python/object:os.system is not taken: remove it");
  EXPECT_THAT(ErrorOf("a: !mine {b: 1}\n"), HasSubstr("the tag !mine"));
}

TEST(YamlDocument, RefusesWhatIsTooDeepTooLongOrTooMuch) {
  // A list may also be the key of a map, until the parser has seen its end.
  EXPECT_THAT(ErrorOf(Repeated("[", 100000)), testing::ContainsRegex("x:1: (nested deeper|a key must be)"));
  EXPECT_THAT(ErrorOf(Repeated("{a: ", 50000)), testing::ContainsRegex("x:1: (nested deeper|a key must be)"));
  EXPECT_EQ(ErrorOf(Repeated("[", 17) + Repeated("]", 17)), "x:1: nested deeper than 16 levels");
  EXPECT_THAT(ErrorOf(Repeated("- ", 100000)), HasSubstr("nested deeper"));
  EXPECT_THAT(ErrorOf(Repeated("? ", 100000)), HasSubstr("x:1: "));
  EXPECT_THAT(ErrorOf("[" + Repeated("1,", 30000) + "1]"), HasSubstr("x:1: more than 20000 values"));
  EXPECT_EQ(ErrorOf(std::string(10 << 20, 'a')), "x: 10485760 bytes of YAML, at most 262144 are read");
  EXPECT_TRUE(ParseYamlDocument(Repeated("[", kMaxYamlDepth) + Repeated("]", kMaxYamlDepth), "x"));
}

TEST(YamlDocument, RefusesWhatIsNoTextOrNoYaml) {
  EXPECT_EQ(ErrorOf(std::string_view("a: 1\nb: \0\n", 10)),
            "x:2: holds the byte 0x00: it is not a text file");
  EXPECT_THAT(ErrorOf("\x7f"
                      "ELF"),
              HasSubstr("0x7f"));
  EXPECT_THAT(ErrorOf("a: [1"), HasSubstr("not YAML"));
  EXPECT_THAT(ErrorOf("a: 1\n b: 2\n"), HasSubstr("x:2: not YAML"));
  EXPECT_THAT(ErrorOf("\xff\xfe"
                      "a"),
              HasSubstr("x"));
}

TEST(YamlDocument, RefusesKeysThatAreThereTwiceOrNoWords) {
  EXPECT_EQ(ErrorOf("a: 1\nb: 2\na: 3\n"), "x:3: the key 'a' stands here a second time");
  EXPECT_THAT(ErrorOf("a: {b: 1, b: 2}\n"), HasSubstr("the key 'b'"));
  EXPECT_THAT(ErrorOf("{[1]: 2}\n"), HasSubstr("x:1: a key must be one word"));
  EXPECT_THAT(ErrorOf("? \n: 1\n"), HasSubstr("a key must be one word"));
  EXPECT_THAT(ErrorOf("a: 1\n---\nb: 2\n"), HasSubstr("a second document"));
  EXPECT_THAT(ErrorOf("\"a\\nb\": 1\n\"a\\nb\": 1\n"), HasSubstr("'a\\x0ab'"));
}

TEST(YamlDocument, OnlyRegularFilesAreRead) {
  const TemporaryFolder folder;
  const auto fifo = folder.path() / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  for (const std::filesystem::path& path : {fifo, folder.path(), std::filesystem::path("/dev/zero")}) {
    const auto document = LoadYamlDocument(path);
    ASSERT_FALSE(document) << path;
    EXPECT_EQ(document.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(document.error().message, testing::ContainsRegex("a (regular )?file is needed"));
  }
}

}  // namespace
}  // namespace dadrl
