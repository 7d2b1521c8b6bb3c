#include "actor/render/context_planes.h"

#include <fmt/format.h>

#include <array>

#include "actor/render/palette.h"
#include "actor/sensing/birds_eye_view.h"
#include "common/step/driving_shape.h"

namespace dadrl {
namespace {

using svg::Node;

constexpr int kSize = DrivingShape::kContextSize;
constexpr size_t kMostPictures = 300;  // of a plane in one film: each is a kilobyte or two

struct Plane {
  const char* words;
  const char* colour;
};
constexpr std::array<Plane, DrivingShape::kContextPlanes> kPlanes = {
    {{"drivable area", colour::kMarking}, {"planned route", colour::kRoute}}};

bool Pixel(const std::vector<uint8_t>& context, int plane, int row, int column) {
  const int byte = (plane * kSize + row) * (kSize / 8) + column / 8;
  return (static_cast<unsigned>(context[static_cast<size_t>(byte)]) >> (column % 8) & 1U) != 0;
}

// The set pixels as horizontal strokes.
std::string Strokes(const std::vector<uint8_t>& context, int plane) {
  std::string path;
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize;) {
      const int begin = column;
      while (column < kSize && Pixel(context, plane, row, column)) ++column;
      if (column > begin) path += fmt::format("M{} {}h{}", begin, row, column - begin);
      if (column == begin) ++column;
    }
  }
  return path;
}

void DrawPlane(Node parent, const Film& film, int plane, const svg::Box& square) {
  const Node group =
      svg::Add(parent, "g",
               {{"class", "plane"},
                {"transform", fmt::format("translate({} {}) scale({:.5g})", svg::Number(square.x),
                                          svg::Number(square.y), square.width / kSize)}});
  svg::AddBox(group, {0, 0, kSize, kSize}, {{"fill", colour::kInk}});
  const size_t every = film.size() / kMostPictures + 1;
  Track paths;
  for (size_t i = 0; i < film.size(); ++i) {
    const bool drawn = i % every == 0 || i + 1 == film.size();
    paths.push_back(drawn ? Strokes(film[i].context, plane) : paths.back());
  }
  // A little wider than a pixel, so that no seams show.
  const Node pixels = svg::Add(group, "path",
                               {{"transform", "translate(0 .5)"},
                                {"stroke", kPlanes[static_cast<size_t>(plane)].colour},
                                {"stroke-width", "1.06"},
                                {"fill", "none"}});
  Animate(pixels, film, "d", paths, Motion::kSteps);
  constexpr double kCarLength = kVehicleLength / kPixelMetres;
  constexpr double kCarWidth = kVehicleWidth / kPixelMetres;
  svg::AddBox(group, {(kSize - kCarWidth) / 2, (kSize - kCarLength) / 2, kCarWidth, kCarLength},
              {{"fill", colour::kEgo}, {"stroke", colour::kPaper}, {"stroke-width", "0.8"}});
}

void DrawCaptioned(Node parent, const Film& film, int plane, const svg::Box& square) {
  DrawPlane(parent, film, plane, square);
  svg::AddText(parent, {square.centre().x, square.bottom() + 14}, kPlanes[static_cast<size_t>(plane)].words,
               {{"class", "small"}, {"text-anchor", "middle"}});
}

}  // namespace

void DrawPlanes(Node parent, const Film& film, const svg::Box& box) {
  constexpr double kGap = 14;
  const double side = (box.width - kGap) / 2;
  DrawCaptioned(parent, film, 0, {box.x, box.y, side, side});
  DrawCaptioned(parent, film, 1, {box.x + side + kGap, box.y, side, side});
}

void DrawPlanesStacked(Node parent, const Film& film, const svg::Box& box) {
  constexpr double kCaption = 20;
  const double side = std::min(box.width, box.height / 2 - kCaption);
  DrawCaptioned(parent, film, 0, {box.x, box.y, side, side});
  DrawCaptioned(parent, film, 1, {box.x, box.y + side + kCaption, side, side});
}

}  // namespace dadrl
