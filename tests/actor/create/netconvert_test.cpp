#include "actor/create/netconvert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "actor/create/root_element.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kTown = DADRL_SOURCE_DIR "/tests/actor/create/town.osm";

class Netconvert : public testing::Test {
 protected:
  std::filesystem::path File(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name) << text;
    return folder_.path() / name;
  }
  std::string Refusal(const RoadSource& source) {
    const Status built = BuildNetwork(source, folder_.path() / "out.net.xml");
    EXPECT_FALSE(built);
    return built ? "" : built.error().message;
  }

  const TemporaryFolder folder_;
};

TEST_F(Netconvert, RootElementSeesThroughWhatStandsBeforeIt) {
  const auto root = [&](const std::string& text) { return RootElement(File("x.xml", text)).value(); };
  EXPECT_EQ(root("<?xml version=\"1.0\"?>\n<!-- a > b <net> -->\n<osm version=\"0.6\">"), "osm");
  EXPECT_EQ(root("\xef\xbb\xbf<!DOCTYPE x><net/>"), "net");
  EXPECT_EQ(root("<nodes>"), "nodes");
  EXPECT_EQ(root("\x1f\x8b\x08"), "?");
  EXPECT_EQ(root("hello"), "");
  EXPECT_EQ(root("<!-- never ends <net>"), "");
  EXPECT_EQ(root("<"), "");
  EXPECT_EQ(root(""), "");
  EXPECT_EQ(RootElement(folder_.path() / "none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(RootElement(folder_.path()).error().code, ErrorCode::kInvalidArgument);
}

TEST_F(Netconvert, SaysWhatAFileIsThatIsNoRoad) {
  const auto net = File("a.net.xml", "<net version=\"1.9\"/>");
  EXPECT_THAT(Refusal({.file = net, .osm = true}),
              HasSubstr("its root is <net>, not <osm>; give it as --net"));
  EXPECT_THAT(Refusal({.file = kTown}), HasSubstr("an OpenStreetMap extract; give it as --osm"));
  EXPECT_THAT(Refusal({.file = File("t.pbf", "no xml"), .osm = true}), HasSubstr("it is not XML"));
  EXPECT_THAT(Refusal({.file = File("t.txt", "hello")}), HasSubstr("it is not XML"));
  EXPECT_THAT(Refusal({.file = File("nodes.xml", "<nodes/>")}), HasSubstr("call its files NAME.nod.xml"));
  EXPECT_THAT(Refusal({.file = File("a.nod.xml", "<nodes/>")}), HasSubstr("a.edg.xml beside it"));
  EXPECT_THAT(Refusal({.file = folder_.path() / "none.osm", .osm = true}), HasSubstr("there is no file"));
  EXPECT_THAT(Refusal({.file = net, .left_hand = true}), HasSubstr("is built already"));
}

TEST_F(Netconvert, ItsOwnWordsSayWhatIsWrongWithPlainXml) {
  File("b.nod.xml", R"(<nodes><node id="A" x="0" y="0"/></nodes>)");
  const auto edges = File("b.edg.xml", R"(<edges><edge id="E" from="A" to="B"/></edges>)");
  EXPECT_THAT(Refusal({.file = edges}), AllOf(HasSubstr("netconvert"), HasSubstr("'B'")));
}

TEST_F(Netconvert, ThatIsNotInstalledIsNamedWithItsPackage) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder_.path().c_str(), 1);
  const Status built = BuildNetwork({.file = kTown, .osm = true}, folder_.path() / "out.net.xml");
  setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(built.error().message, AllOf(HasSubstr("netconvert"), HasSubstr("apt-get install")));
}

}  // namespace
}  // namespace dadrl
