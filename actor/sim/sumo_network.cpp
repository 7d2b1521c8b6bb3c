#include "actor/sim/sumo_network.h"

#include <libsumo/libsumo.h>

#include <algorithm>
#include <exception>
#include <unordered_map>
#include <utility>

#include "actor/sim/stderr_capture.h"
#include "actor/sim/world_state.h"

namespace dadrl {
namespace {

constexpr double kMinLength = 1e-3;

std::vector<Point> ToPoints(const libsumo::TraCIPositionVector& shape) {
  std::vector<Point> points;
  points.reserve(shape.value.size());
  for (const libsumo::TraCIPosition& position : shape.value) points.push_back({position.x, position.y});
  return points;
}

std::vector<double> Elevations(const libsumo::TraCIPositionVector& shape) {
  std::vector<double> elevations;
  elevations.reserve(shape.value.size());
  for (const libsumo::TraCIPosition& position : shape.value) elevations.push_back(position.z);
  return elevations;
}

bool HasLength(const std::vector<Point>& points) {
  return std::any_of(points.begin(), points.end(),
                     [&](Point point) { return Norm(point - points.front()) >= kMinLength; });
}

// The first lane of each connection that leaves `lane`: inside the junction where there is one.
std::vector<std::string> Followers(const std::string& lane) {
  std::vector<std::string> followers;
  for (const libsumo::TraCIConnection& link : libsumo::Lane::getLinks(lane)) {
    followers.push_back(link.approachedInternal.empty() ? link.approachedLane : link.approachedInternal);
  }
  return followers;
}

// Knows which of SUMO's lanes are part of the map, and where those lead that are not.
class LaneIndex {
 public:
  void Add(const std::string& id, bool has_length) {
    if (has_length) {
      index_.emplace(id, std::ssize(index_));
    } else {
      points_.push_back(id);
    }
  }

  // The lanes of the map that `id` leads into, those without length passed through.
  std::vector<int> Successors(const std::string& id) const {
    std::vector<int> successors;
    std::vector<std::string> passed{id};
    for (size_t next = 0; next < passed.size(); ++next) {
      for (const std::string& follower : Followers(passed[next])) {
        const auto found = index_.find(follower);
        if (found != index_.end()) {
          successors.push_back(found->second);
        } else if (Contains(points_, follower) && !Contains(passed, follower)) {
          passed.push_back(follower);
        }
      }
    }
    return successors;
  }

 private:
  static bool Contains(const std::vector<std::string>& ids, const std::string& id) {
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  }

  std::unordered_map<std::string, int> index_;
  std::vector<std::string> points_;
};

Lane ReadLane(const std::string& id, const libsumo::TraCIPositionVector& shape) {
  Lane lane;
  lane.id = id;
  lane.edge = libsumo::Lane::getEdgeID(id);
  lane.index = std::stoi(id.substr(id.rfind('_') + 1));
  lane.internal = id.front() == ':';
  lane.width = libsumo::Lane::getWidth(id);
  lane.speed_limit = libsumo::Lane::getMaxSpeed(id);
  lane.centre = Polyline(ToPoints(shape), Elevations(shape));
  return lane;
}

std::vector<std::vector<Point>> ReadJunctions() {
  std::vector<std::vector<Point>> junctions;
  for (const std::string& id : libsumo::Junction::getIDList()) {
    std::vector<Point> outline = ToPoints(libsumo::Junction::getShape(id));
    // Waiting points inside a junction and the ends of dead ends have no area.
    if (id.front() == ':' || outline.size() < 3) continue;
    const bool closed = Norm(outline.front() - outline.back()) < 1e-6;
    if (closed) outline.pop_back();
    if (outline.size() >= 3) junctions.push_back(std::move(outline));
  }
  return junctions;
}

}  // namespace

bool LaneAllows(const std::string& lane, const std::string& vehicle_class) {
  const std::vector<std::string> allowed = libsumo::Lane::getAllowed(lane);
  if (!allowed.empty()) return std::find(allowed.begin(), allowed.end(), vehicle_class) != allowed.end();
  const std::vector<std::string> closed = libsumo::Lane::getDisallowed(lane);
  return std::find(closed.begin(), closed.end(), vehicle_class) == closed.end();
}

RoadMap ReadSumoNetwork() {
  LaneIndex index;
  std::vector<Lane> lanes;
  for (const std::string& id : libsumo::Lane::getIDList()) {
    if (!LaneAllows(id, kCarClass)) continue;
    const libsumo::TraCIPositionVector shape = libsumo::Lane::getShape(id);
    const bool has_length = HasLength(ToPoints(shape));
    index.Add(id, has_length);
    if (has_length) lanes.push_back(ReadLane(id, shape));
  }
  for (Lane& lane : lanes) lane.successors = index.Successors(lane.id);
  return RoadMap(std::move(lanes), ReadJunctions());
}

Status LoadSumoNetwork(const std::filesystem::path& network) {
  std::string why = "SUMO loaded nothing";
  try {
    libsumo::Simulation::load({"--net-file", network.string(), "--xml-validation", "never",
                               "--xml-validation.net", "never", "--no-step-log", "true", "--no-warnings",
                               "true"});
    if (libsumo::Simulation::isLoaded()) return {};
  } catch (const std::exception& exception) {
    why = exception.what();
  }
  return Fail(
      ErrorCode::kInvalidArgument,
      "{} is not a network that netconvert wrote (`dadrl scenario new` makes one from plain XML or an "
      "OpenStreetMap extract): {}",
      network.string(), why);
}

Result<RoadMap> LoadRoadMap(const std::filesystem::path& network) {
  DADRL_ASSIGN_OR_RETURN(StderrCapture complaints, StderrCapture::Start());
  const Status loaded = LoadSumoNetwork(network);
  const std::string details = complaints.Finish();
  if (loaded) return ReadSumoNetwork();
  return Fail(loaded.error().code, "{} {}", loaded.error().message, details);
}

std::string StreetName(const std::string& edge) { return libsumo::Edge::getStreetName(edge); }

}  // namespace dadrl
