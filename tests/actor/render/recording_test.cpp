#include "actor/render/recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "actor/evaluation/evaluation.h"
#include "actor/render/picture.h"
#include "actor/task/collision.h"

namespace dadrl {
namespace {

constexpr uint64_t kSeed = 1'000'000;

std::unique_ptr<DrivingEnvironment> MakeEnvironment(const PolicySetup& setup) {
  auto environment = DrivingEnvironment::Create(setup.config, setup.environment);
  EXPECT_TRUE(environment) << environment.error().message;
  return std::move(*environment);
}

PolicySetup SetupOf(const std::string& policy) {
  Config config;
  config.scenario = "left_turn";
  return *MakePolicy(policy, config, {});
}

TEST(RecordEpisode, KeepsEachStepOfTheEpisodeThatAnEvaluationDrives) {
  const PolicySetup setup = SetupOf("rdm");
  const auto environment = MakeEnvironment(setup);
  const auto driven = DriveEpisode(*environment, *setup.policy, kSeed);
  ASSERT_TRUE(driven) << driven.error().message;
  const auto recording = RecordEpisode(*environment, *setup.policy, setup.description, kSeed);
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->summary, *driven);
  ASSERT_EQ(static_cast<int>(recording->moments.size()), driven->steps + 1);
  for (size_t step = 0; step < recording->moments.size(); ++step) {
    EXPECT_EQ(recording->moments[step].world.step, static_cast<int>(step));
  }
  EXPECT_EQ(recording->moments.front().reward.Sum(), 0.0);
  EXPECT_NEAR(recording->moments.back().reward_so_far.Sum(), driven->episode_return, 1e-9);
  EXPECT_EQ(recording->moments.front().command->target_speed_mps, 15.0);
  EXPECT_TRUE(recording->moments.front().attention.empty());
}

TEST(RecordEpisode, KnowsWhoWasHit) {
  const PolicySetup setup = SetupOf("rdm");
  const auto environment = MakeEnvironment(setup);
  const auto recording = RecordEpisode(*environment, *setup.policy, setup.description, kSeed);
  ASSERT_TRUE(recording);
  ASSERT_EQ(recording->summary.outcome, Outcome::kCollision);
  ASSERT_TRUE(recording->collided_with);
  const WorldState& last = recording->moments.back().world;
  const auto hit = std::find_if(last.vehicles.begin(), last.vehicles.end(),
                                [&](const auto& vehicle) { return vehicle.id == *recording->collided_with; });
  ASSERT_NE(hit, last.vehicles.end());
  EXPECT_TRUE(BoxesWithin(EgoBox(last.ego.pose), hit->box(), kContactDistance));
  EXPECT_EQ(OutcomeSentence(*recording), fmt::format("collision with car {} at {:.1f} s", hit->id,
                                                     recording->summary.steps * kStepSeconds));
}

TEST(RecordEpisode, SumosDriverGivesNoCommands) {
  const PolicySetup setup = SetupOf("idm");
  const auto environment = MakeEnvironment(setup);
  const auto recording = RecordEpisode(*environment, *setup.policy, setup.description, kSeed);
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_FALSE(recording->moments.empty());
  for (const Moment& moment : recording->moments) EXPECT_FALSE(moment.command);
}

// Stands for three seconds and attends to the rows of the observation in a known way.
class StandingPolicy final : public DrivingPolicy {
 public:
  Decision Decide(const DrivingEnvironment&) override { return {{0.0, 0}, 3}; }
  std::span<const float> attention() const override { return weights_; }

 private:
  std::vector<float> weights_ = {0.3f, 0.25f, 0.2f, 0.1f, 0.05f, 0.01f};
};

TEST(RecordEpisode, NamesTheVehiclesThatGetAttention) {
  PolicySetup setup = SetupOf("rdm");
  setup.config.task.max_steps = 30;
  const auto environment = MakeEnvironment(setup);
  StandingPolicy policy;
  const auto recording = RecordEpisode(*environment, policy, "a test", kSeed);
  ASSERT_TRUE(recording) << recording.error().message;
  int named = 0;
  for (size_t step = 0; step + 1 < recording->moments.size(); step += 3) {
    const Moment& moment = recording->moments[step];
    // Row i of an observation is the i-th nearest vehicle within the sensor's radius.
    std::vector<std::pair<double, int>> nearest;
    for (const SocialVehicle& vehicle : moment.world.vehicles) {
      const double distance = Norm(vehicle.pose.position - moment.world.ego.pose.position);
      if (distance <= recording->sensor_radius_m) nearest.emplace_back(distance, vehicle.id);
    }
    std::sort(nearest.begin(), nearest.end());
    ASSERT_EQ(moment.attention.size(), std::min<size_t>(6, nearest.size()));
    for (size_t row = 0; row < moment.attention.size(); ++row) {
      EXPECT_EQ(moment.attention[row].vehicle, nearest[row].second);
      EXPECT_FLOAT_EQ(static_cast<float>(moment.attention[row].weight), policy.attention()[row]);
      ++named;
    }
    // Held until the next decision.
    EXPECT_EQ(recording->moments[step + 1].attention.size(), moment.attention.size());
  }
  EXPECT_GT(named, 10);
}

TEST(RecordEpisode, SameSeedGivesTheSamePicture) {
  const PolicySetup setup = SetupOf("random");
  const auto environment = MakeEnvironment(setup);
  std::vector<std::string> pictures;
  for (const uint64_t seed : {kSeed, kSeed + 1, kSeed}) {
    const auto recording = RecordEpisode(*environment, *setup.policy, setup.description, seed);
    ASSERT_TRUE(recording) << recording.error().message;
    pictures.push_back(AnimatedPicture(*recording, 0, recording->summary.steps, 1));
  }
  EXPECT_EQ(pictures[0], pictures[2]);
  EXPECT_NE(pictures[0], pictures[1]);
}

}  // namespace
}  // namespace dadrl
