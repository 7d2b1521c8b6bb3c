#include "actor/sim/network_crop.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <pugixml.hpp>
#include <sstream>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "actor/sim/sumo_options.h"

namespace dadrl {
namespace {

using Node = pugi::xml_node;
using Names = std::unordered_set<std::string>;

struct Box {
  double low_x = std::numeric_limits<double>::max();
  double low_y = std::numeric_limits<double>::max();
  double high_x = std::numeric_limits<double>::lowest();
  double high_y = std::numeric_limits<double>::lowest();

  bool Near(const Box& other, double metres) const {
    return low_x <= other.high_x + metres && high_x >= other.low_x - metres &&
           low_y <= other.high_y + metres && high_y >= other.low_y - metres;
  }
};

// Of "x,y x,y,z ..." of each of its lanes.
Box BoxOf(Node edge) {
  Box box;
  for (const Node lane : edge.children("lane")) {
    std::istringstream shape(lane.attribute("shape").value());
    for (std::string point; shape >> point;) {
      const size_t comma = std::min(point.find(','), point.size() - 1);
      const double x = std::strtod(point.c_str(), nullptr);
      const double y = std::strtod(point.c_str() + comma + 1, nullptr);
      box = {std::min(box.low_x, x), std::min(box.low_y, y), std::max(box.high_x, x),
             std::max(box.high_y, y)};
    }
  }
  return box;
}

bool IsInside(std::string_view id) { return id.starts_with(':'); }

// "J" of ":J_4": of edges inside it, its crossings and pavements.
std::string JunctionOf(std::string_view edge) {
  return std::string(edge.substr(1, std::max<size_t>(edge.rfind('_'), 1) - 1));
}

std::string WithoutIndex(std::string_view lane) { return std::string(lane.substr(0, lane.rfind('_'))); }

// Which edges stay, and which junctions stay as they are.
class Selection {
 public:
  // False: an edge is not in the network.
  bool Select(Node net, const std::vector<std::string>& edges, double metres) {
    std::unordered_map<std::string, Box> boxes;
    for (const Node edge : net.children("edge")) {
      const std::string id = edge.attribute("id").value();
      if (!IsInside(id)) boxes.emplace(id, BoxOf(edge));
    }
    std::vector<Box> wanted;
    for (const std::string& edge : edges) {
      const auto found = boxes.find(edge);
      if (found == boxes.end()) return false;
      wanted.push_back(found->second);
    }
    for (const auto& entry : boxes) {
      const auto is_near = [&](const Box& box) { return entry.second.Near(box, metres); };
      if (std::ranges::any_of(wanted, is_near)) edges_.insert(entry.first);
    }
    for (const Node edge : net.children("edge")) {
      const std::string id = edge.attribute("id").value();
      if (IsInside(id)) continue;
      const std::string from = edge.attribute("from").value();
      const std::string to = edge.attribute("to").value();
      end_of_[id] = to;
      (edges_.contains(id) ? touched_ : cut_).insert({from, to});
    }
    return true;
  }

  bool KeepsEdge(const std::string& id) const {
    return IsInside(id) ? KeepsWhole(JunctionOf(id)) : edges_.contains(id);
  }
  bool KeepsJunction(const std::string& id) const {
    return IsInside(id) ? KeepsEdge(WithoutIndex(id)) : touched_.contains(id);
  }
  // With everything that leads into it and out of it.
  bool KeepsWhole(const std::string& junction) const {
    return touched_.contains(junction) && !cut_.contains(junction);
  }
  bool KeepsConnection(Node connection) const {
    const std::string from = connection.attribute("from").value();
    if (!KeepsEdge(from) || !KeepsEdge(connection.attribute("to").value())) return false;
    return IsInside(from) || KeepsWhole(end_of_.at(from));
  }

 private:
  Names edges_;
  Names touched_;  // junctions with an edge that stays
  Names cut_;      // junctions with one that does not
  std::unordered_map<std::string, std::string> end_of_;
};

template <typename Keep>
void RemoveUnless(Node net, const char* tag, Keep keep) {
  for (Node child = net.child(tag); child;) {
    const Node next = child.next_sibling(tag);
    if (!keep(child)) net.remove_child(child);
    child = next;
  }
}

std::string Id(Node node) { return node.attribute("id").value(); }

void MakeDeadEnd(Node junction, const Selection& selection) {
  std::string lanes;
  std::istringstream all(junction.attribute("incLanes").value());
  for (std::string lane; all >> lane;) {
    if (selection.KeepsEdge(WithoutIndex(lane))) lanes += (lanes.empty() ? "" : " ") + lane;
  }
  junction.attribute("incLanes").set_value(lanes.c_str());
  junction.attribute("intLanes").set_value("");
  junction.attribute("type").set_value("dead_end");
  while (junction.remove_child("request")) continue;
}

void Cut(Node net, const Selection& selection) {
  RemoveUnless(net, "edge", [&](Node edge) { return selection.KeepsEdge(Id(edge)); });
  for (const Node edge : net.children("edge")) {
    for (Node lane : edge.children("lane")) {
      RemoveUnless(lane, "neigh", [&](Node neighbour) {
        return selection.KeepsEdge(WithoutIndex(neighbour.attribute("lane").value()));
      });
    }
  }
  RemoveUnless(net, "junction", [&](Node junction) { return selection.KeepsJunction(Id(junction)); });
  for (const Node junction : net.children("junction")) {
    if (!IsInside(Id(junction)) && !selection.KeepsWhole(Id(junction))) MakeDeadEnd(junction, selection);
  }
  RemoveUnless(net, "connection", [&](Node connection) { return selection.KeepsConnection(connection); });
  Names lights;
  for (const Node connection : net.children("connection")) lights.insert(connection.attribute("tl").value());
  RemoveUnless(net, "tlLogic", [&](Node logic) { return lights.contains(Id(logic)); });
  RemoveUnless(net, "roundabout", [&](Node roundabout) {
    std::istringstream nodes(roundabout.attribute("nodes").value());
    for (std::string node; nodes >> node;) {
      if (!selection.KeepsWhole(node)) return false;
    }
    return true;
  });
}

struct StringWriter : pugi::xml_writer {
  void write(const void* data, size_t size) override { text.append(static_cast<const char*>(data), size); }
  std::string text;
};

std::vector<std::string> EdgesOf(const Scenario& scenario) {
  std::vector<std::string> edges;
  for (const std::string& lane : scenario.ego_lanes) edges.push_back(WithoutIndex(lane));
  for (const TrafficFlow& flow : scenario.flows)
    edges.insert(edges.end(), flow.edges.begin(), flow.edges.end());
  return edges;
}

bool HasOwnFiles(const ProfileSettings& profile) {
  return std::ranges::any_of(profile.sumo_options, [](const auto& option) {
    return option.first == kRouteFiles || option.first == kAdditionalFiles;
  });
}

}  // namespace

bool CropNetworkXml(std::string& network, const std::vector<std::string>& edges, double metres) {
  pugi::xml_document document;
  if (!document.load_buffer(network.data(), network.size())) return false;
  const Node net = document.child("net");
  Selection selection;
  if (!net || !selection.Select(net, edges, metres)) return false;
  Cut(net, selection);
  StringWriter writer;
  document.save(writer, "", pugi::format_raw);
  network = std::move(writer.text);
  return true;
}

Result<std::optional<MemoryFile>> CropNetwork(const Scenario& scenario, const ProfileSettings& profile) {
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(scenario.network, error);
  if (error || size < kCropBytes || HasOwnFiles(profile)) return std::nullopt;
  std::ifstream stream(scenario.network, std::ios::binary);
  std::string text(size, '\0');
  if (!stream.read(text.data(), static_cast<std::streamsize>(size))) return std::nullopt;
  if (!CropNetworkXml(text, EdgesOf(scenario), kCropMetres)) return std::nullopt;
  DADRL_ASSIGN_OR_RETURN(MemoryFile file, MemoryFile::Create("dadrl-network"));
  DADRL_RETURN_IF_ERROR(file.Write(text));
  return std::optional<MemoryFile>(std::move(file));
}

}  // namespace dadrl
