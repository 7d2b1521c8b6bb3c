#include "actor/render/film.h"

#include <gtest/gtest.h>

#include <pugixml.hpp>

#include "tests/actor/render/test_recordings.h"

namespace dadrl {
namespace {

class FilmTest : public testing::Test {
 protected:
  svg::Node Node() { return document_.append_child("rect"); }
  static std::string Text(const svg::Node& node, const char* attribute) {
    return node.attribute(attribute).value();
  }

  const Recording recording_ = test::StraightDrive(10);
  pugi::xml_document document_;
};

TEST_F(FilmTest, AStillHasNoAnimation) {
  const Film film(recording_, {4});
  const svg::Node node = Node();
  Animate(node, film, "x", {"5"}, Motion::kSmooth);
  EXPECT_EQ(Text(node, "x"), "5");
  EXPECT_FALSE(node.first_child());
  EXPECT_EQ(film.duration(), 0.0);
}

TEST_F(FilmTest, WhatDoesNotChangeIsNotAnimated) {
  const Film film(recording_, {0, 1, 2});
  const svg::Node node = Node();
  Animate(node, film, "fill", {"red", "red", "red"}, Motion::kSteps);
  EXPECT_EQ(Text(node, "fill"), "red");
  EXPECT_FALSE(node.first_child());
}

TEST_F(FilmTest, SmoothMotionPassesEachValueAtItsTime) {
  const Film film(recording_, {0, 2, 4});
  const svg::Node node = Node();
  Animate(node, film, "x", {"1", "2", "5"}, Motion::kSmooth);
  const svg::Node animation = node.child("animate");
  EXPECT_EQ(Text(animation, "attributeName"), "x");
  EXPECT_EQ(Text(animation, "dur"), "0.4s");
  EXPECT_EQ(Text(animation, "values"), "1;2;5");
  EXPECT_EQ(Text(animation, "keyTimes"), "");  // evenly spaced
  EXPECT_EQ(Text(animation, "calcMode"), "");
  EXPECT_EQ(Text(animation, "fill"), "freeze");
}

TEST_F(FilmTest, UnevenMomentsKeepTheirTimes) {
  const Film film(recording_, {0, 3, 6, 9, 10});
  const svg::Node node = Node();
  Animate(node, film, "x", {"0", "3", "6", "9", "10"}, Motion::kSmooth);
  EXPECT_EQ(Text(node.child("animate"), "keyTimes"), "0;0.3;0.6;0.9;1");
  EXPECT_EQ(Text(node.child("animate"), "dur"), "1s");
}

TEST_F(FilmTest, StepsNameOnlyTheChanges) {
  const Film film(recording_, {0, 1, 2, 3, 4});
  const svg::Node node = Node();
  Animate(node, film, "fill", {"a", "a", "b", "b", "a"}, Motion::kSteps);
  const svg::Node animation = node.child("animate");
  EXPECT_EQ(Text(animation, "calcMode"), "discrete");
  EXPECT_EQ(Text(animation, "values"), "a;b;a");
  EXPECT_EQ(Text(animation, "keyTimes"), "0;0.5;1");
}

TEST_F(FilmTest, APartBeginsWhenItsFirstMomentIsShown) {
  const Film film(recording_, {0, 1, 2, 3, 4, 5});
  const svg::Node node = Node();
  AnimateTransform(node, film, "translate", {"1 1", "2 2", "3 3"}, Motion::kSmooth, 2);
  const svg::Node animation = node.child("animateTransform");
  EXPECT_EQ(Text(node, "transform"), "translate(1 1)");
  EXPECT_EQ(Text(animation, "begin"), "0.2s");
  EXPECT_EQ(Text(animation, "dur"), "0.2s");
}

TEST_F(FilmTest, WordsAreShownOneAtATime) {
  const Film film(recording_, {0, 1, 2});
  const svg::Node group = document_.append_child("g");
  AddWords(group, film, {0, 0}, {"left", "", "right"}, {});
  std::map<std::string, std::string> visibility;
  for (const svg::Node& text : group.children("text")) {
    visibility[text.text().get()] = Text(text.child("animate"), "values");
  }
  EXPECT_EQ(visibility,
            (std::map<std::string, std::string>{{"left", "visible;hidden"}, {"right", "hidden;visible"}}));
}

TEST_F(FilmTest, DigitsThatStayAreOneText) {
  const Film film(recording_, {0});
  const svg::Node group = document_.append_child("g");
  AddDigits(group, film, {50, 20}, 10, {" 7.3"}, {});
  EXPECT_STREQ(group.child("text").text().get(), " 7.3");
  EXPECT_EQ(Text(group.child("text"), "text-anchor"), "end");
}

TEST_F(FilmTest, DigitsThatChangeTurnTheirRolls) {
  const Film film(recording_, {0, 1});
  const svg::Node parent = document_.append_child("g");
  AddDigits(parent, film, {50, 20}, 10, {"1.2", "1.4"}, {});
  const svg::Node group = parent.first_child();
  EXPECT_STREQ(group.child("text").text().get(), "1");  // of three characters one changes
  const svg::Node roll = group.child("svg").child("use");
  // Line 2 and line 4 of the roll, 1.25 em = 12.5 pixels apart each.
  EXPECT_EQ(Text(roll.child("animate"), "values"), "-25;-50");
}

}  // namespace
}  // namespace dadrl
