#include "actor/ego/lane_sequences.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <string>
#include <utility>

namespace dadrl {
namespace {

// How far a sequence goes on once it has left the route. An episode seldom lasts longer there.
constexpr double kOffRouteMetres = 200.0;
// A sequence that branches off another begins so far before the branch.
constexpr double kCommonMetres = 50.0;

// Through a junction: the lanes inside it, and the first one behind it.
using Way = std::vector<int>;

bool Contains(const std::vector<int>& lanes, int lane) {
  return std::find(lanes.begin(), lanes.end(), lane) != lanes.end();
}

class SequenceFinder {
 public:
  SequenceFinder(const RoadMap& map, const Route& route)
      : map_(map), route_(route), covered_(map.lanes().size(), false), expanded_(map.lanes().size(), false) {}

  std::vector<LaneSequence> Find() {
    for (int start = route_.lanes().front(); start >= 0; start = UncoveredLane()) FollowFrom(start);
    return std::move(sequences_);
  }

 private:
  struct Partial {
    std::vector<int> lanes;
    size_t first = 0;          // the sequence begins here; what lies before belongs to another
    double off_route_m = 0.0;  // since it left the route
  };

  bool OnRoute(const Way& way) const {
    return std::ranges::all_of(way, [&](int lane) { return route_.OnRoute(lane); });
  }

  void FollowFrom(int start);
  // Follows `partial` to its end; other branches go to `open`.
  void FollowToEnd(Partial partial, std::vector<Partial>& open);
  void Append(const Way& way, Partial& partial) const;
  std::vector<Way> NextWays(const Partial& partial);
  void KeepStraightest(int from, std::vector<Way>& ways) const;
  size_t BeginOfBranch(const Partial& partial) const;
  void Emit(const Partial& partial);
  int UncoveredLane() const;

  const RoadMap& map_;
  const Route& route_;
  std::vector<bool> covered_;    // by lane: a sequence drives on it
  std::vector<bool> expanded_;   // by lane: its branches have been taken
  std::set<std::string> edges_;  // whose lanes must all be covered
  std::vector<LaneSequence> sequences_;
};

void SequenceFinder::FollowFrom(int start) {
  std::vector<Partial> open;
  open.push_back({.lanes = {start}});
  while (!open.empty()) {
    Partial partial = std::move(open.back());
    open.pop_back();
    FollowToEnd(std::move(partial), open);
  }
}

void SequenceFinder::FollowToEnd(Partial partial, std::vector<Partial>& open) {
  for (std::vector<Way> ways = NextWays(partial); !ways.empty(); ways = NextWays(partial)) {
    const size_t branch = BeginOfBranch(partial);
    // The last is taken first from `open`.
    for (size_t other = ways.size(); --other > 0;) {
      Partial branched = partial;
      branched.first = branch;
      Append(ways[other], branched);
      open.push_back(std::move(branched));
    }
    Append(ways.front(), partial);
  }
  Emit(partial);
}

void SequenceFinder::Append(const Way& way, Partial& partial) const {
  const bool on_route = partial.off_route_m == 0.0 && OnRoute(way);
  partial.lanes.insert(partial.lanes.end(), way.begin(), way.end());
  if (!on_route) partial.off_route_m += map_.lane(way.back()).centre.length();
}

std::vector<Way> SequenceFinder::NextWays(const Partial& partial) {
  const int last = partial.lanes.back();
  if (partial.off_route_m > kOffRouteMetres) return {};
  std::vector<Way> ways = map_.CrossingsFrom(last);
  // A ring would be followed for ever.
  std::erase_if(ways, [&](const Way& it) { return Contains(partial.lanes, it.back()); });
  const bool any_on_route = std::ranges::any_of(ways, [&](const Way& it) { return OnRoute(it); });
  if (any_on_route) std::erase_if(ways, [&](const Way& it) { return !OnRoute(it); });
  if (!any_on_route && !route_.OnRoute(last)) KeepStraightest(last, ways);
  // Its other branches have their sequences already.
  if (expanded_[static_cast<size_t>(last)] && ways.size() > 1) ways.resize(1);
  expanded_[static_cast<size_t>(last)] = true;
  return ways;
}

void SequenceFinder::KeepStraightest(int from, std::vector<Way>& ways) const {
  if (ways.size() < 2) return;
  const Polyline& centre = map_.lane(from).centre;
  const double heading = centre.HeadingAt(centre.length());
  const auto turn = [&](const Way& way) {
    return std::abs(WrapAngle(map_.lane(way.back()).centre.HeadingAt(0.0) - heading));
  };
  const auto straightest = std::ranges::min_element(ways, {}, turn);
  ways = {std::move(*straightest)};
}

size_t SequenceFinder::BeginOfBranch(const Partial& partial) const {
  double common = 0.0;
  size_t first = partial.lanes.size();
  while (first > partial.first && (common < kCommonMetres || map_.lane(partial.lanes[first]).internal)) {
    common += map_.lane(partial.lanes[--first]).centre.length();
  }
  return first;
}

void SequenceFinder::Emit(const Partial& partial) {
  sequences_.emplace_back(partial.lanes.begin() + static_cast<std::ptrdiff_t>(partial.first),
                          partial.lanes.end());
  bool left = false;
  for (const int lane : partial.lanes) {
    covered_[static_cast<size_t>(lane)] = true;
    if (map_.lane(lane).internal || left) continue;
    edges_.insert(map_.lane(lane).edge);
    left = !route_.OnRoute(lane);
  }
}

int SequenceFinder::UncoveredLane() const {
  int lowest = -1;
  for (const std::string& edge : edges_) {
    for (const int lane : map_.LanesOfEdge(edge)) {
      if (!covered_[static_cast<size_t>(lane)] && (lowest < 0 || lane < lowest)) lowest = lane;
    }
  }
  return lowest;
}

}  // namespace

std::vector<LaneSequence> FindLaneSequences(const RoadMap& map, const Route& route) {
  return SequenceFinder(map, route).Find();
}

}  // namespace dadrl
