// Building blocks of a picture: SVG elements as nodes of an XML document.
#pragma once

#include <initializer_list>
#include <pugixml.hpp>
#include <span>
#include <string>
#include <string_view>

#include "actor/sim/geometry.h"

namespace dadrl::svg {

using Node = pugi::xml_node;

// Shortest decimal form, to a hundredth.
std::string Number(double value);

struct Attribute {
  const char* name;
  std::string value;
  Attribute(const char* attribute, double number) : name(attribute), value(Number(number)) {}
  Attribute(const char* attribute, std::string_view text) : name(attribute), value(text) {}
};
using Attributes = std::initializer_list<Attribute>;

// Pixels, y down.
struct Box {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  double height = 0.0;
  double right() const { return x + width; }
  double bottom() const { return y + height; }
  Point centre() const { return {x + width / 2, y + height / 2}; }
};

Node Add(Node parent, const char* tag, Attributes attributes = {});
Node AddBox(Node parent, const Box& box, Attributes attributes = {});
Node AddText(Node parent, Point at, std::string_view text, Attributes attributes = {});
// A viewport of its own coordinates, origin at the corner of `box`, that cuts off what lies outside.
Node AddViewport(Node parent, const Box& box);

// "x,y x,y" for polyline and polygon.
std::string Points(std::span<const Point> points);
std::string Translate(Point by);

// World metres to pixels: north up, so y is mirrored and angles turn clockwise.
struct Scale {
  double pixels_per_metre = 1.0;
  Point operator()(Point world) const { return {world.x * pixels_per_metre, -world.y * pixels_per_metre}; }
};
double Degrees(double heading);

}  // namespace dadrl::svg
