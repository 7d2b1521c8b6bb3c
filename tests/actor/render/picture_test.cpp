#include "actor/render/picture.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdio>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/actor/render/test_recordings.h"

namespace dadrl {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

// A picture, parsed.
class Parsed {
 public:
  explicit Parsed(const std::string& svg) {
    const auto result = document_.load_string(svg.c_str());
    EXPECT_TRUE(result) << result.description();
    EXPECT_STREQ(root().name(), "svg");
    EXPECT_STREQ(root().attribute("xmlns").value(), "http://www.w3.org/2000/svg");
  }
  pugi::xml_node root() const { return document_.first_child(); }
  std::vector<pugi::xml_node> All(const std::string& xpath) const {
    std::vector<pugi::xml_node> nodes;
    for (const auto& found : document_.select_nodes(xpath.c_str())) nodes.push_back(found.node());
    return nodes;
  }
  std::vector<pugi::xml_node> OfClass(const std::string& name) const {
    return All("//*[contains(concat(' ', @class, ' '), ' " + name + " ')]");
  }
  bool Says(const std::string& words) const { return !All("//text[contains(., '" + words + "')]").empty(); }

 private:
  pugi::xml_document document_;
};

Point Translation(const pugi::xml_node& node) {
  Point point;
  EXPECT_EQ(std::sscanf(node.attribute("transform").value(), "translate(%lf %lf)", &point.x, &point.y), 2);
  return point;
}

TEST(FramePicture, ShowsEachCarOfTheSceneWhereItIs) {
  const Recording recording = test::StraightDrive(10);
  const Parsed picture(FramePicture(recording, 4));
  EXPECT_THAT(picture.OfClass("car"), SizeIs(2));
  EXPECT_THAT(picture.OfClass("ego"), SizeIs(1));
  const Point camera = Translation(picture.OfClass("camera").front());
  const Point ego = Translation(picture.OfClass("ego").front());
  constexpr double kPixelsPerMetre = 8.4;
  const std::map<std::string, Point> ahead_of_ego = {{"3", {6, 3.2}}, {"7", {0, 3.2}}};  // ego at x = 54
  for (const pugi::xml_node& car : picture.OfClass("car")) {
    const Point offset = ahead_of_ego.at(car.attribute("data-car").value());
    const Point at = camera + Translation(car);
    EXPECT_NEAR(at.x, ego.x + kPixelsPerMetre * offset.x, 0.1);
    EXPECT_NEAR(at.y, ego.y - kPixelsPerMetre * offset.y, 0.1);  // north is up
  }
}

TEST(FramePicture, TurnsCarsTheWayTheyDrive) {
  Recording recording = test::StraightDrive(1);
  recording.moments[1].world.vehicles[0].pose.heading = std::numbers::pi / 2;  // north: up
  const Parsed picture(FramePicture(recording, 1));
  const pugi::xml_node car = picture.All("//g[@class='car' and @data-car='3']").front();
  EXPECT_STREQ(car.child("g").attribute("transform").value(), "rotate(-90.0)");
}

TEST(FramePicture, SaysHowMuchAttentionEachCarGets) {
  const Recording recording = test::StraightDrive(3);
  const Parsed picture(FramePicture(recording, 2));
  std::map<std::string, std::string> weights;
  for (const pugi::xml_node& text : picture.OfClass("weight")) {
    weights[text.parent().attribute("data-car").value()] = text.text().get();
  }
  EXPECT_EQ(weights, (std::map<std::string, std::string>{{"3", "42 %"}, {"7", "10 %"}}));
  EXPECT_THAT(picture.OfClass("gaze"), SizeIs(2));
}

TEST(FramePicture, HasNoAttentionWithoutALearnedPolicy) {
  Recording recording = test::StraightDrive(3);
  for (Moment& moment : recording.moments) moment.attention.clear();
  const Parsed picture(FramePicture(recording, 2));
  EXPECT_THAT(picture.OfClass("weight"), SizeIs(0));
  EXPECT_THAT(picture.OfClass("gaze"), SizeIs(0));
  EXPECT_FALSE(picture.Says("orange"));
}

TEST(FramePicture, ShowsSpeedTargetCommandAndReward) {
  const Parsed picture(FramePicture(test::StraightDrive(10), 4));
  EXPECT_TRUE(picture.Says("10.0"));    // speed
  EXPECT_TRUE(picture.Says(" 8.0"));    // asked for
  EXPECT_TRUE(picture.Says("+0.250"));  // progress of this step
  EXPECT_TRUE(picture.Says("+1.00"));   // so far
  EXPECT_TRUE(picture.Says("0.4"));     // the time
  // The command that is given stands on blue, the others on white.
  std::map<std::string, std::string> buttons;
  for (const char* words : {"lane left", "keep lane", "lane right"}) {
    const auto text = picture.All(fmt::format("//text[contains(., '{}') and @text-anchor='middle']", words));
    ASSERT_THAT(text, SizeIs(1)) << words;
    buttons[words] = text.front().previous_sibling("rect").attribute("fill").value();
  }
  EXPECT_NE(buttons["lane left"], buttons["keep lane"]);
  EXPECT_EQ(buttons["lane right"], buttons["keep lane"]);
}

TEST(FramePicture, SaysThatSumoGivesNoCommands) {
  Recording recording = test::StraightDrive(3);
  for (Moment& moment : recording.moments) moment.command.reset();
  const Parsed picture(FramePicture(recording, 1));
  EXPECT_TRUE(picture.Says("no commands"));
  EXPECT_FALSE(picture.Says("asked for"));
}

TEST(FramePicture, NamesTheOutcomeOnTheLastMomentOnly) {
  Recording recording = test::StraightDrive(73);
  recording.summary.outcome = Outcome::kCollision;
  recording.collided_with = 3;
  const Parsed last(FramePicture(recording, 73));
  EXPECT_TRUE(last.Says("collision with car 3 at 7.3 s"));
  EXPECT_THAT(last.All("//g[@class='car' and @data-car='3']//circle[@class='hit']"), SizeIs(1));
  EXPECT_THAT(last.OfClass("hit"), SizeIs(1));
  const Parsed before(FramePicture(recording, 72));
  EXPECT_FALSE(before.Says("collision with"));
  EXPECT_THAT(before.OfClass("hit"), SizeIs(0));
}

TEST(FramePicture, DrawsThePlanesPixelForPixel) {
  Recording recording = test::StraightDrive(1);
  // Plane 0, row 5, columns 8 to 11; plane 1, row 127, column 127.
  recording.moments[1].context[5 * 16 + 1] = 0x0f;
  recording.moments[1].context[128 * 16 + 127 * 16 + 15] = 0x80;
  const Parsed picture(FramePicture(recording, 1));
  const auto planes = picture.OfClass("plane");
  ASSERT_THAT(planes, SizeIs(2));
  EXPECT_STREQ(planes[0].child("path").attribute("d").value(), "M8 5h4");
  EXPECT_STREQ(planes[1].child("path").attribute("d").value(), "M127 127h1");
}

TEST(FramePicture, EscapesWhatItIsTold) {
  Recording recording = test::StraightDrive(1);
  recording.policy = "<script> & co";
  const Parsed picture(FramePicture(recording, 1));
  EXPECT_THAT(picture.All("//script"), SizeIs(0));
  EXPECT_THAT(picture.All("//tspan[contains(., '<script> & co')]"), SizeIs(1));
}

// When the last of the animations ends, seconds.
double Duration(const Parsed& picture) {
  double end = 0.0;
  for (const pugi::xml_node& animation : picture.All("//animate | //animateTransform")) {
    double begin = 0.0;
    double length = 0.0;
    std::sscanf(animation.attribute("begin").value(), "%lf", &begin);
    EXPECT_EQ(std::sscanf(animation.attribute("dur").value(), "%lf", &length), 1);
    end = std::max(end, begin + length);
  }
  return end;
}

TEST(AnimatedPicture, LastsAsLongAsTheEpisode) {
  const Recording recording = test::StraightDrive(73);
  EXPECT_NEAR(Duration(Parsed(AnimatedPicture(recording, 0, 73, 1))), 7.3, 1e-9);
  EXPECT_NEAR(Duration(Parsed(AnimatedPicture(recording, 0, 73, 5))), 7.3, 1e-9);
  EXPECT_NEAR(Duration(Parsed(AnimatedPicture(recording, 20, 50, 1))), 3.0, 1e-9);
}

TEST(AnimatedPicture, IsWholeInItself) {
  const std::string svg = AnimatedPicture(test::StraightDrive(20), 0, 20, 1);
  const Parsed picture(svg);
  for (const pugi::xml_node& node : picture.All("//*[@href]")) {
    const std::string target = node.attribute("href").value();
    ASSERT_TRUE(target.starts_with('#')) << target;
    EXPECT_THAT(picture.All("//*[@id='" + target.substr(1) + "']"), SizeIs(1)) << target;
  }
  EXPECT_THAT(picture.All("//script"), SizeIs(1));
  EXPECT_THAT(svg, Not(HasSubstr("url(")));
}

TEST(AnimatedPicture, HidesACarWhileItIsAway) {
  Recording recording = test::StraightDrive(10);
  for (int step = 3; step < 6; ++step) {
    std::vector<SocialVehicle>& vehicles = recording.moments[static_cast<size_t>(step)].world.vehicles;
    vehicles.erase(vehicles.begin());  // car 3
  }
  const Parsed picture(AnimatedPicture(recording, 0, 10, 1));
  const auto visits = picture.All("//g[@class='car' and @data-car='3']");
  ASSERT_THAT(visits, SizeIs(2));
  const auto visibility = [](const pugi::xml_node& visit) {
    const pugi::xml_node animation = visit.find_child_by_attribute("animate", "attributeName", "visibility");
    return std::string(animation.attribute("values").value()) + " at " +
           animation.attribute("keyTimes").value();
  };
  EXPECT_EQ(visibility(visits[0]), "visible;hidden at 0;0.3");
  EXPECT_EQ(visibility(visits[1]), "hidden;visible at 0;0.6");
}

TEST(AnimatedPicture, ACarThatStartsAnewDoesNotFlyThere) {
  Recording recording = test::StraightDrive(10);
  for (size_t step = 5; step <= 10; ++step) {
    SocialVehicle& car = recording.moments[step].world.vehicles[0];
    car.pose.position.x = 180;
    ++car.trip;
  }
  const Parsed picture(AnimatedPicture(recording, 0, 10, 1));
  const auto visits = picture.All("//g[@class='car' and @data-car='3']");
  ASSERT_THAT(visits, SizeIs(2));
  for (const pugi::xml_node& visit : visits) EXPECT_FALSE(visit.child("animateTransform"));
}

TEST(AnimatedPicture, IsTheSameForTheSameRecording) {
  EXPECT_EQ(AnimatedPicture(test::StraightDrive(30), 0, 30, 1),
            AnimatedPicture(test::StraightDrive(30), 0, 30, 1));
}

TEST(AnimatedPicture, ShowsTheOutcomeAtTheEnd) {
  const Parsed picture(AnimatedPicture(test::StraightDrive(20), 0, 20, 1));
  const pugi::xml_node banner = picture.OfClass("outcome").front();
  EXPECT_STREQ(banner.child("animate").attribute("values").value(), "hidden;visible");
  EXPECT_STREQ(banner.child("animate").attribute("keyTimes").value(), "0;1");
}

TEST(AnimatedPicture, AnOutcomeBeyondThePartShownIsNotTold) {
  EXPECT_THAT(Parsed(AnimatedPicture(test::StraightDrive(20), 0, 19, 1)).OfClass("outcome"), SizeIs(0));
}

TEST(StripPicture, ShowsEachMomentAndMarksItOnTheCurve) {
  const Recording recording = test::StraightDrive(100);
  const Parsed picture(StripPicture(recording, {0, 40, 100}));
  EXPECT_THAT(picture.OfClass("cell"), SizeIs(3));
  EXPECT_THAT(picture.OfClass("ego"), SizeIs(3));
  for (const char* time : {"0.0 s", "4.0 s", "10.0 s"}) EXPECT_TRUE(picture.Says(time)) << time;
  EXPECT_THAT(picture.All("//g[@class='timeline']//circle"), SizeIs(3));
  EXPECT_TRUE(picture.Says("goal reached after 10.0 s"));
}

TEST(KeyMoments, AreSpreadOverTheEpisode) {
  EXPECT_THAT(KeyMoments(test::StraightDrive(100), 0, 100, 6), ElementsAre(0, 20, 40, 60, 80, 100));
  EXPECT_THAT(KeyMoments(test::StraightDrive(100), 20, 40, 2), ElementsAre(20, 40));
}

TEST(KeyMoments, CrowdBeforeACollision) {
  Recording recording = test::StraightDrive(100);
  recording.summary.outcome = Outcome::kCollision;
  const std::vector<int> moments = KeyMoments(recording, 0, 100, 6);
  ASSERT_THAT(moments, SizeIs(6));
  EXPECT_EQ(moments.front(), 0);
  EXPECT_EQ(moments.back(), 100);
  for (size_t i = 2; i < moments.size(); ++i) {
    EXPECT_LT(moments[i] - moments[i - 1], moments[i - 1] - moments[i - 2]);
  }
  // The collision is not in this part.
  EXPECT_THAT(KeyMoments(recording, 0, 50, 6), ElementsAre(0, 10, 20, 30, 40, 50));
}

TEST(KeyMoments, AreFewerWhenThereAreNotAsMany) {
  EXPECT_THAT(KeyMoments(test::StraightDrive(2), 0, 2, 6), ElementsAre(0, 1, 2));
}

}  // namespace
}  // namespace dadrl
