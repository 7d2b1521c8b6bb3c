#include "actor/render/svg.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace dadrl::svg {

std::string Number(double value) {
  const double rounded = std::round(value * 100.0) / 100.0;
  return fmt::format("{}", rounded == 0.0 ? 0.0 : rounded);  // no "-0"
}

Node Add(Node parent, const char* tag, Attributes attributes) {
  Node node = parent.append_child(tag);
  for (const Attribute& attribute : attributes) {
    node.append_attribute(attribute.name).set_value(attribute.value.c_str());
  }
  return node;
}

Node AddBox(Node parent, const Box& box, Attributes attributes) {
  Node node = Add(parent, "rect", {{"x", box.x}, {"y", box.y}, {"width", box.width}, {"height", box.height}});
  for (const Attribute& attribute : attributes) {
    node.append_attribute(attribute.name).set_value(attribute.value.c_str());
  }
  return node;
}

Node AddText(Node parent, Point at, std::string_view text, Attributes attributes) {
  Node node = Add(parent, "text", {{"x", at.x}, {"y", at.y}});
  for (const Attribute& attribute : attributes) {
    node.append_attribute(attribute.name).set_value(attribute.value.c_str());
  }
  node.text().set(std::string(text).c_str());
  return node;
}

Node AddViewport(Node parent, const Box& box) {
  return Add(
      parent, "svg",
      {{"x", box.x}, {"y", box.y}, {"width", box.width}, {"height", box.height}, {"overflow", "hidden"}});
}

std::string Points(std::span<const Point> points) {
  std::string text;
  for (const Point& point : points) {
    if (!text.empty()) text += ' ';
    text += Number(point.x) + ',' + Number(point.y);
  }
  return text;
}

std::string Translate(Point by) { return fmt::format("translate({} {})", Number(by.x), Number(by.y)); }

double Degrees(double heading) { return -heading * 180.0 / std::numbers::pi; }

}  // namespace dadrl::svg
