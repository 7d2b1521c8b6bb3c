#include "actor/render/car_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "actor/render/palette.h"

namespace dadrl {
namespace {

using svg::Node;

// Rotations that never turn the long way round.
Track Rotations(const std::vector<double>& headings) {
  Track track;
  double unwrapped = headings.front();
  for (const double heading : headings) {
    unwrapped += WrapAngle(heading - unwrapped);
    track.push_back(fmt::format("{:.1f}", svg::Degrees(unwrapped)));
  }
  return track;
}

// Body and windscreen, pointing right, centred; returns the body.
Node AddBody(Node parent, Point size_m, const svg::Scale& scale, const char* stroke) {
  const double length = size_m.x * scale.pixels_per_metre;
  const double width = size_m.y * scale.pixels_per_metre;
  // A driver sits at the front, however long the vehicle is.
  const double front = (size_m.x / 2 - kVehicleLength / 2) * scale.pixels_per_metre;
  const double cab = kVehicleLength * scale.pixels_per_metre;
  const Node body = svg::AddBox(parent, {-length / 2, -width / 2, length, width},
                                {{"rx", 0.28 * std::min(width, kVehicleWidth * scale.pixels_per_metre)},
                                 {"stroke", stroke},
                                 {"stroke-width", "1.2"}});
  svg::AddBox(parent, {front + 0.14 * cab, -0.38 * width, 0.16 * cab, 0.76 * width},
              {{"rx", 0.08 * width}, {"fill", colour::kInk}, {"fill-opacity", "0.75"}});
  return body;
}

// From the colour of any car to that of attention.
std::string BodyColour(double weight) {
  constexpr std::array<int, 3> kPlain = {0xf1, 0xf2, 0xf4};
  constexpr std::array<int, 3> kAttended = {0xe6, 0x9f, 0x00};
  const double share = std::sqrt(std::clamp(weight, 0.0, 1.0));
  std::array<int, 3> mixed{};
  for (size_t i = 0; i < mixed.size(); ++i) {
    mixed[i] = std::lround(kPlain[i] + share * (kAttended[i] - kPlain[i]));
  }
  return fmt::format("#{:02x}{:02x}{:02x}", mixed[0], mixed[1], mixed[2]);
}

std::vector<bool> During(const Film& film, const VehicleVisit& visit) {
  std::vector<bool> visible(film.size());
  for (size_t i = 0; i < film.size(); ++i) visible[i] = visit.Includes(i);
  return visible;
}

// A group that goes where the vehicle goes, for as long as it is there.
Node AddFollower(Node parent, const Film& film, const VehicleVisit& visit, const CarStyle& style,
                 const char* kind) {
  Track places;
  for (const Pose& pose : visit.poses) {
    const Point at = style.scale(pose.position);
    places.push_back(fmt::format("{:.1f} {:.1f}", at.x, at.y));
  }
  const Node group = svg::Add(parent, "g", {{"class", kind}, {"data-car", fmt::format("{}", visit.vehicle)}});
  AnimateTransform(group, film, "translate", places, Motion::kSmooth, visit.first);
  return group;
}

void MarkHit(Node car, const Film& film, const VehicleVisit& visit, const CarStyle& style) {
  const double reach = 0.75 * visit.length_m * style.scale.pixels_per_metre;
  const Node ring = svg::Add(
      car, "circle",
      {{"class", "hit"}, {"r", reach}, {"fill", "none"}, {"stroke", colour::kHarm}, {"stroke-width", "3"}});
  const Node label =
      svg::AddText(car, {0, -reach - 5}, "hit by the ego",
                   {{"class", "small strong halo"}, {"text-anchor", "middle"}, {"fill", colour::kHarm}});
  std::vector<bool> visible(film.size(), false);
  visible.back() = true;
  AnimateVisibility(ring, film, visible);
  AnimateVisibility(label, film, visible);
}

}  // namespace

void DrawCar(Node parent, const Film& film, const VehicleVisit& visit, const CarStyle& style) {
  std::vector<double> headings;
  Track colours;
  for (size_t i = 0; i < visit.poses.size(); ++i) {
    headings.push_back(visit.poses[i].heading);
    colours.push_back(BodyColour(visit.weights[i]));
  }
  const Node car = AddFollower(parent, film, visit, style, "car");
  AnimateVisibility(car, film, During(film, visit));
  const Node turned = svg::Add(car, "g");
  AnimateTransform(turned, film, "rotate", Rotations(headings), Motion::kSmooth, visit.first);
  Animate(AddBody(turned, {visit.length_m, visit.width_m}, style.scale, colour::kInk), film, "fill", colours,
          Motion::kSteps, visit.first);
  if (style.names) {
    svg::AddText(car, {0, 3}, fmt::format("{}", visit.vehicle),
                 {{"class", "name"}, {"text-anchor", "middle"}, {"font-size", "9"}});
  }
  const bool hit = film.shows_end() && film.recording().collided_with == visit.vehicle;
  if (hit && visit.Includes(film.size() - 1)) MarkHit(car, film, visit, style);
}

void DrawWeight(Node parent, const Film& film, const VehicleVisit& visit, const CarStyle& style) {
  Track words(film.size());
  for (size_t i = 0; i < visit.weights.size(); ++i) {
    if (visit.weights[i] < style.attention_shown) continue;
    words[visit.first + i] = fmt::format("{:.0f} %", 100.0 * visit.weights[i]);
  }
  if (std::all_of(words.begin(), words.end(), [](const auto& word) { return word.empty(); })) return;
  const Node label = AddFollower(parent, film, visit, style, "attention");
  AddWords(label, film, {0, -0.85 * kVehicleWidth * style.scale.pixels_per_metre}, words,
           {{"class", "weight halo"}, {"text-anchor", "middle"}, {"font-size", style.names ? 13.0 : 11.0}});
}

void DrawEgo(Node parent, const Film& film, Point at, const svg::Scale& scale) {
  std::vector<double> headings;
  for (size_t i = 0; i < film.size(); ++i) headings.push_back(film[i].world.ego.pose.heading);
  const Node ego = svg::Add(parent, "g", {{"class", "ego"}, {"transform", svg::Translate(at)}});
  const Node turned = svg::Add(ego, "g");
  AnimateTransform(turned, film, "rotate", Rotations(headings), Motion::kSmooth);
  AddBody(turned, {kVehicleLength, kVehicleWidth}, scale, colour::kPaper).append_attribute("fill") =
      colour::kEgo;
  svg::AddText(ego, {0, 1.6 * kVehicleLength / 2 * scale.pixels_per_metre}, "ego",
               {{"class", "strong halo"}, {"text-anchor", "middle"}, {"fill", colour::kEgo}});
}

}  // namespace dadrl
