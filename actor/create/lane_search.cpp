#include "actor/create/lane_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "common/config/config_schema.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

constexpr double kLaneChangeMetres = 100.0;
constexpr double kFar = std::numeric_limits<double>::infinity();

// Dijkstra's search; a lane's distance is to its end.
class LaneSearch {
 public:
  explicit LaneSearch(const RoadMap& map)
      : map_(map), metres_(map.lanes().size(), kFar), before_(map.lanes().size(), -1) {}

  void StartAt(const std::string& edge) {
    for (const int lane : map_.LanesOfEdge(edge)) Reach(lane, LaneAt(lane).centre.length(), -1);
  }

  // The first lane of `edge` that is come to; -1 where none is.
  int SearchTo(const std::string& edge) {
    while (!open_.empty()) {
      const auto [metres, lane] = open_.top();
      open_.pop();
      if (metres > metres_[Index(lane)]) continue;
      if (LaneAt(lane).edge == edge) return lane;
      for (const int next : LaneAt(lane).successors) {
        Reach(next, metres + LaneAt(next).centre.length(), lane);
      }
      if (LaneAt(lane).internal) continue;
      for (const int beside : map_.LanesOfEdge(LaneAt(lane).edge)) {
        if (std::abs(LaneAt(beside).index - LaneAt(lane).index) == 1) {
          Reach(beside, metres + kLaneChangeMetres, lane);
        }
      }
    }
    return -1;
  }

  std::vector<std::string> WayTo(int lane) const {
    std::vector<std::string> names;
    for (; lane >= 0; lane = before_[Index(lane)]) {
      if (!LaneAt(lane).internal) names.push_back(LaneAt(lane).id);
    }
    std::ranges::reverse(names);
    return names;
  }

 private:
  static size_t Index(int lane) { return static_cast<size_t>(lane); }
  const Lane& LaneAt(int lane) const { return map_.lanes()[Index(lane)]; }

  void Reach(int lane, double metres, int before) {
    if (metres >= metres_[Index(lane)]) return;
    metres_[Index(lane)] = metres;
    before_[Index(lane)] = before;
    open_.emplace(metres, lane);
  }

  using Entry = std::pair<double, int>;
  const RoadMap& map_;
  std::vector<double> metres_;
  std::vector<int> before_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

Status CheckEdge(const RoadMap& map, const char* option, const std::string& edge) {
  if (!map.LanesOfEdge(edge).empty() && edge.front() != ':') return {};
  std::vector<std::string> edges;
  for (const Lane& lane : map.lanes()) {
    if (!lane.internal && (edges.empty() || edges.back() != lane.edge)) edges.push_back(lane.edge);
  }
  if (edges.empty()) {
    return Fail(ErrorCode::kInvalidArgument, "the network has no lane that cars may use");
  }
  std::string nearest;
  for (int i = 0; i < 3 && !edges.empty(); ++i) {
    const std::string name = NearestName(edge, edges);
    nearest += fmt::format("{}'{}'", nearest.empty() ? "" : ", ", name);
    std::erase(edges, name);
  }
  return Fail(ErrorCode::kInvalidArgument,
              "{}: the network has no edge '{}' that cars may use; the nearest names are {}", option,
              Shown(edge), nearest);
}

}  // namespace

Result<std::vector<std::string>> FindLanes(const RoadMap& map, const std::string& from,
                                           const std::string& to) {
  DADRL_RETURN_IF_ERROR(CheckEdge(map, "--from", from));
  DADRL_RETURN_IF_ERROR(CheckEdge(map, "--to", to));
  LaneSearch search(map);
  search.StartAt(from);
  const int goal = search.SearchTo(to);
  if (goal >= 0) return search.WayTo(goal);
  return Fail(ErrorCode::kInvalidArgument,
              "no way leads from edge '{}' to edge '{}' on lanes that cars may use; one-way streets and "
              "turns that are forbidden count",
              from, to);
}

}  // namespace dadrl
