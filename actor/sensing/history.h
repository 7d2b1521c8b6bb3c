// The last seconds of an episode, and the two history tensors read from them.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "actor/sensing/localization.h"
#include "actor/sim/world_state.h"
#include "common/config/config.h"

namespace dadrl {

// A ring of the scenes of (history - 1) * history_stride + 1 simulation steps. Not thread
// safe; allocates only until the largest scene was seen.
class History {
 public:
  explicit History(const ObservationConfig& config);

  // An episode starts: nothing is known of the past.
  void Clear() { count_ = 0; }
  // Once a simulation step, the scene at spawn included.
  void Push(const WorldState& world, const EgoLocation& location);

  // The tensors of features.h at the scene pushed last; both spans are overwritten whole. Requires a Push.
  // [vehicles, history, 7]: those within the radius now, nearest first (ties: the smaller id first). A
  // vehicle's rows end where it was not in the network, or where it jumped (it left and started anew).
  void WriteVehicles(std::span<float> out);
  // Those of the last WriteVehicles, in its order; as long as the scene is the newest.
  size_t nearest_count() const { return nearest_.size(); }
  const SocialVehicle& nearest(size_t index) const { return *nearest_[index].second; }
  // [history, 20]; rows before the spawn are absent. `goal` is in world coordinates.
  void WriteEgo(Point goal, std::span<float> out) const;

 private:
  struct Scene {
    EgoState ego;
    EgoLocation location;
    std::vector<SocialVehicle> vehicles;
  };

  // The scene `age` steps ago, null before the spawn.
  const Scene* At(int age) const;
  void SelectNearest();
  void WriteVehicleRows(const SocialVehicle& now, const LocalFrame& frame, float* rows) const;

  ObservationConfig config_;
  std::vector<Scene> ring_;
  size_t newest_ = 0;
  size_t count_ = 0;
  std::vector<std::pair<double, const SocialVehicle*>> nearest_;  // squared distance, vehicle of the newest
};

}  // namespace dadrl
