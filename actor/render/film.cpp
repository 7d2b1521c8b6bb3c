#include "actor/render/film.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

namespace dadrl {
namespace {

using svg::Node;

constexpr std::string_view kRoll = "0123456789.+- ";
constexpr double kRollLine = 1.25;      // em from digit to digit
constexpr double kDigitAdvance = 0.64;  // em, of the fonts in use

bool IsConstant(const Track& track) {
  return std::all_of(track.begin(), track.end(), [&](const auto& value) { return value == track.front(); });
}

// Values with the times at which they start, where a film is not evenly spaced or values repeat.
struct Keys {
  std::string values;
  std::string times;
};

Keys MakeKeys(const Film& film, const Track& track, Motion motion, size_t first) {
  const double begin = film.StartOf(first);
  const double length = film.StartOf(first + track.size() - 1) - begin;
  Keys keys;
  for (size_t i = 0; i < track.size(); ++i) {
    if (motion == Motion::kSteps && i > 0 && track[i] == track[i - 1]) continue;
    if (i > 0) {
      keys.values += ';';
      keys.times += ';';
    }
    keys.values += track[i];
    keys.times += fmt::format("{:.5g}", (film.StartOf(first + i) - begin) / length);
  }
  return keys;
}

bool EvenlySpaced(const Film& film, size_t first, size_t count) {
  const int gap = film.index(first + 1) - film.index(first);
  for (size_t i = first + 1; i < first + count; ++i) {
    if (film.index(i) - film.index(i - 1) != gap) return false;
  }
  return true;
}

void FillAnimation(Node animation, const Film& film, const Track& track, Motion motion, size_t first) {
  const Keys keys = MakeKeys(film, track, motion, first);
  const double begin = film.StartOf(first);
  const double duration = film.StartOf(first + track.size() - 1) - begin;
  if (first > 0) animation.append_attribute("begin") = fmt::format("{}s", svg::Number(begin)).c_str();
  animation.append_attribute("dur") = fmt::format("{}s", svg::Number(duration)).c_str();
  animation.append_attribute("fill") = "freeze";
  if (motion == Motion::kSteps) animation.append_attribute("calcMode") = "discrete";
  animation.append_attribute("values") = keys.values.c_str();
  if (motion == Motion::kSteps || !EvenlySpaced(film, first, track.size())) {
    animation.append_attribute("keyTimes") = keys.times.c_str();
  }
}

}  // namespace

Film::Film(const Recording& recording, std::vector<int> moments)
    : recording_(recording), moments_(std::move(moments)) {
  assert(!moments_.empty());
}

void Animate(Node node, const Film& film, const char* attribute, const Track& track, Motion motion,
             size_t first) {
  assert(!track.empty() && first + track.size() <= film.size());
  node.append_attribute(attribute) = track.front().c_str();
  if (IsConstant(track)) return;
  FillAnimation(svg::Add(node, "animate", {{"attributeName", attribute}}), film, track, motion, first);
}

void AnimateTransform(Node node, const Film& film, const char* type, const Track& track, Motion motion,
                      size_t first) {
  assert(!track.empty() && first + track.size() <= film.size());
  node.append_attribute("transform") = fmt::format("{}({})", type, track.front()).c_str();
  if (IsConstant(track)) return;
  FillAnimation(svg::Add(node, "animateTransform", {{"attributeName", "transform"}, {"type", type}}), film,
                track, motion, first);
}

void AnimateVisibility(Node node, const Film& film, const std::vector<bool>& visible) {
  Track track;
  track.reserve(visible.size());
  for (const bool shown : visible) track.emplace_back(shown ? "visible" : "hidden");
  if (IsConstant(track) && visible.front()) return;
  Animate(node, film, "visibility", track, Motion::kSteps);
}

void AddWords(Node parent, const Film& film, Point at, const Track& words, svg::Attributes attributes) {
  Track distinct = words;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  for (const std::string& word : distinct) {
    if (word.empty()) continue;
    std::vector<bool> visible;
    visible.reserve(words.size());
    for (const std::string& value : words) visible.push_back(value == word);
    AnimateVisibility(svg::AddText(parent, at, word, attributes), film, visible);
  }
}

void AddDigits(Node parent, const Film& film, Point at, double font_size, const Track& numbers,
               svg::Attributes attributes) {
  if (IsConstant(numbers)) {
    Node text = svg::AddText(parent, at, numbers.front(), attributes);
    text.append_attribute("font-size") = svg::Number(font_size).c_str();
    text.append_attribute("text-anchor") = "end";
    return;
  }
  Node group = svg::Add(parent, "g", attributes);
  group.append_attribute("font-size") = svg::Number(font_size).c_str();
  const size_t length = numbers.front().size();
  const double advance = kDigitAdvance * font_size;
  for (size_t column = 0; column < length; ++column) {
    Track glyphs;
    Track offsets;
    for (const std::string& number : numbers) {
      assert(number.size() == length);
      const size_t place = kRoll.find(number[column]);
      assert(place != std::string_view::npos);
      glyphs.emplace_back(1, number[column]);
      offsets.push_back(svg::Number(-static_cast<double>(place) * kRollLine * font_size));
    }
    const double left = at.x - (length - column) * advance;
    if (IsConstant(glyphs)) {
      if (glyphs.front() == " ") continue;
      svg::AddText(group, {left + advance / 2, at.y}, glyphs.front(), {{"text-anchor", "middle"}});
      continue;
    }
    const Node window = svg::AddViewport(group, {left, at.y - font_size, advance, kRollLine * font_size});
    const Node roll = svg::Add(window, "use", {{"href", "#digits"}, {"x", advance / 2}});
    Animate(roll, film, "y", offsets, Motion::kSteps);
  }
}

void AddDigitRoll(Node defs) {
  const Node roll = svg::Add(defs, "text", {{"id", "digits"}, {"text-anchor", "middle"}});
  double line = 1.0;
  for (const char glyph : kRoll) {
    svg::Add(roll, "tspan", {{"x", "0"}, {"y", fmt::format("{}em", svg::Number(line))}})
        .text()
        .set(std::string(1, glyph).c_str());
    line += kRollLine;
  }
}

}  // namespace dadrl
