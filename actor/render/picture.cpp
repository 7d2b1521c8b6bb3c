#include "actor/render/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <sstream>

#include "actor/render/context_planes.h"
#include "actor/render/driver_panel.h"
#include "actor/render/film.h"
#include "actor/render/palette.h"
#include "actor/render/player_script.h"
#include "actor/render/road_picture.h"
#include "actor/render/timeline.h"
#include "actor/render/world_view.h"

namespace dadrl {
namespace {

using svg::Box;
using svg::Node;

constexpr const char* kStyle = R"(
.small{font-size:11.5px}.strong{font-weight:bold}
.halo{stroke:#fff;stroke-width:3px;paint-order:stroke;stroke-linejoin:round}
.weight{font-weight:bold}.name{stroke:#f1f2f4;stroke-width:2px;paint-order:stroke}
)";

// A document of that size with its title and what every view refers to.
Node BeginPicture(pugi::xml_document& document, const Recording& recording, double width, double height) {
  const Node root =
      svg::Add(document, "svg",
               {{"xmlns", "http://www.w3.org/2000/svg"},
                {"width", width},
                {"height", height},
                {"font-family", "'DejaVu Sans',Verdana,sans-serif"},
                {"font-size", "13px"},
                {"fill", colour::kInk},
                {"viewBox", fmt::format("0 0 {} {}", svg::Number(width), svg::Number(height))}});
  svg::Add(root, "style").text().set(kStyle);
  const Node defs = svg::Add(root, "defs");
  DefineRoad(defs, recording.map);
  AddDigitRoll(defs);
  svg::AddBox(root, {0, 0, width, height}, {{"fill", colour::kPaper}});
  return root;
}

// "roundabout_a" as a reader writes it: "Roundabout A".
std::string ScenarioTitle(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  for (size_t i = 0; i < name.size(); ++i) {
    const bool word_of_one = i + 1 == name.size() && i > 0 && name[i - 1] == ' ';
    if (i == 0 || word_of_one) name[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[i])));
  }
  return name;
}

void DrawTitle(Node root, const Recording& recording, Point at) {
  const Node text =
      svg::AddText(root, at, ScenarioTitle(recording.scenario), {{"font-size", "20"}, {"class", "strong"}});
  svg::Add(text, "tspan",
           {{"dx", "16"}, {"font-size", "13"}, {"font-weight", "normal"}, {"fill", colour::kFaint}})
      .text()
      .set(fmt::format("the blue car is driven by {}; traffic seed {}", recording.policy,
                       recording.summary.seed)
               .c_str());
}

std::string Text(const pugi::xml_document& document) {
  std::ostringstream stream;
  document.save(stream, "", pugi::format_raw | pugi::format_no_declaration);
  return stream.str();
}

// Scene left, driver right, curve below.
constexpr double kFrameWidth = 1280;
constexpr double kFrameHeight = 760;

void DrawFull(Node root, const Film& film) {
  DrawTitle(root, film.recording(), {16, 34});
  const WorldView view{.box = {16, 52, 848, 540}, .pixels_per_metre = 8.4, .names = true};
  DrawWorld(root, film, view);
  DrawOverview(root, film, {view.box.right() - 206, view.box.y + 8, 198, 118});
  constexpr double kLeft = 888;
  constexpr double kWidth = 376;
  DrawDriver(root, film, {kLeft, 52, kWidth, 150});
  svg::AddText(root, {kLeft, 224}, "What a policy sees of the road", {{"class", "strong"}});
  svg::AddText(root, {kLeft, 241}, "a square of 50 m, driving direction up", {{"class", "small"}});
  DrawPlanes(root, film, {kLeft, 250, kWidth, 200});
  DrawReward(root, film, {kLeft, 488, kWidth, 220}, "Reward");
  DrawTimeline(root, film, {16, 598, 848, 156});
}

}  // namespace

std::string FramePicture(const Recording& recording, int moment) {
  pugi::xml_document document;
  const Node root = BeginPicture(document, recording, kFrameWidth, kFrameHeight);
  DrawFull(root, Film(recording, {moment}));
  return Text(document);
}

std::string AnimatedPicture(const Recording& recording, int first, int last, int every) {
  std::vector<int> moments;
  for (int moment = first; moment < last; moment += every) moments.push_back(moment);
  moments.push_back(last);
  pugi::xml_document document;
  const Node root = BeginPicture(document, recording, kFrameWidth, kFrameHeight);
  const Film film(recording, std::move(moments));
  DrawFull(root, film);
  AddPlayer(root, film.duration());
  return Text(document);
}

std::vector<int> KeyMoments(const Recording& recording, int first, int last, int count) {
  const Outcome outcome = recording.summary.outcome;
  const bool sudden = (outcome == Outcome::kCollision || outcome == Outcome::kOffRoad) &&
                      last + 1 == std::ssize(recording.moments);
  const double power = sudden ? 2.2 : 1.0;
  std::vector<int> moments;
  for (int i = 0; i < count; ++i) {
    const double left = (count - 1.0 - i) / (count - 1);  // 1 at the first, 0 at the last
    moments.push_back(last - static_cast<int>(std::lround((last - first) * std::pow(left, power))));
  }
  moments.erase(std::unique(moments.begin(), moments.end()), moments.end());
  return moments;
}

std::string StripPicture(const Recording& recording, const std::vector<int>& moments) {
  constexpr double kMargin = 16;
  constexpr double kCellWidth = 586;
  constexpr double kWorldWidth = 448;
  constexpr double kWorldHeight = 290;
  constexpr double kCellHeight = kWorldHeight + 40;
  constexpr double kTop = 72;
  constexpr int kColumns = 2;
  const int rows = (std::ssize(moments) + kColumns - 1) / kColumns;
  const double below = kTop + rows * kCellHeight;
  pugi::xml_document document;
  const Node root = BeginPicture(document, recording, 2 * kCellWidth + 3 * kMargin, below + 212);
  DrawTitle(root, recording, {kMargin, 34});
  const bool attends = std::any_of(recording.moments.begin(), recording.moments.end(),
                                   [](const Moment& moment) { return !moment.attention.empty(); });
  svg::AddText(
      root, {kMargin, 54},
      fmt::format("{}On black: what a policy sees of the road, a square of 50 m, driving direction up.",
                  attends ? "Orange: how much of its attention each car gets; it sees as far as the "
                            "dotted circle. "
                          : ""),
      {{"class", "small"}});
  std::vector<TimelineMark> marks;
  for (size_t i = 0; i < moments.size(); ++i) {
    const Film film(recording, {moments[i]});
    const Moment& moment = film[0];
    const double x = kMargin + (i % kColumns) * (kCellWidth + kMargin);
    const double y = kTop + (i / kColumns) * kCellHeight;
    const Node cell = svg::Add(root, "g", {{"class", "cell"}, {"transform", svg::Translate({x, y})}});
    const std::string label = fmt::format("{}", i + 1);
    svg::Add(cell, "circle", {{"cx", "10"}, {"cy", "11"}, {"r", "10"}, {"fill", colour::kInk}});
    svg::AddText(cell, {10, 15.5}, label,
                 {{"class", "strong"}, {"text-anchor", "middle"}, {"fill", colour::kPaper}});
    svg::AddText(cell, {28, 16}, fmt::format("{:.1f} s", moment.world.step * kStepSeconds),
                 {{"class", "strong"}});
    std::string words = fmt::format("{:.1f} m/s", moment.world.ego.speed_mps);
    if (moment.command) {
      words += fmt::format(", asks for {:.1f} m/s, {}", moment.command->target_speed_mps,
                           moment.command->lane > 0   ? "lane left"
                           : moment.command->lane < 0 ? "lane right"
                                                      : "keep lane");
    }
    words += fmt::format("; return so far {:+.2f}", moment.reward_so_far.Sum());
    svg::AddText(cell, {84, 16}, words, {});
    DrawWorld(cell, film,
              {.box = {0, 26, kWorldWidth, kWorldHeight}, .pixels_per_metre = 6.6, .names = false});
    DrawPlanesStacked(cell, film, {kWorldWidth + 10, 26, kCellWidth - kWorldWidth - 10, kWorldHeight});
    marks.push_back({moments[i], label});
  }
  const Film end(recording, {moments.back()});
  DrawTimeline(root, end, {kMargin, below + 6, kCellWidth + 180, 200}, marks);
  DrawReward(root, end, {kMargin + kCellWidth + 210, below + 24, kCellWidth - 200, 200}, "Final reward");
  return Text(document);
}

}  // namespace dadrl
