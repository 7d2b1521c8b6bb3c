// The whole configuration of a run as plain structs: defaults here, ranges and explanations in
// config_schema.cpp, YAML in config_yaml.h. Defaults are the recipe that trains in minutes;
// deploy/config/paper.yaml holds the paper's.
#pragma once

#include <cstdint>
#include <string>

namespace dadrl {

enum class TrafficProfile { kCalibrated, kPlain };
enum class EncoderSharing { kSeparate, kShared };
enum class PublishedPolicy { kAveraged, kCurrent };
// How the replay chooses an item, to be sampled or to leave.
enum class SamplerKind {
  kUniform,
  kPrioritized,
  kNewestFirst,
  kOldestFirst,
  kHighestPriority,
  kLowestPriority
};
enum class SyncMode { kNone, kInterval, kAlways };
enum class VerifyFrames { kNone, kSome, kAll };
enum class FloatCoding { kFloat32, kFloat16 };

struct TrafficConfig {
  TrafficProfile profile = TrafficProfile::kCalibrated;
};

// Signs are part of the weight; see actor/task/reward.h for the terms (paper, section IV).
struct RewardConfig {
  double crash = -1.0;
  double off_road = -1.0;
  double goal = 3.0;
  double progress = 2.0;
  double speed = 0.01;
  double off_route = -0.01;
  double wrong_way = -0.01;
  double slow = -0.2;
};

struct TaskConfig {
  int decision_interval = 3;  // simulation steps one action is held
  int max_steps = 800;        // simulation steps; the limit is a truncation, reported as stagnation
  double max_speed_mps = 10.0;
  RewardConfig reward;
};

struct ObservationConfig {
  int vehicles = 6;
  double radius_m = 30.0;
  int history = 5;         // rows, oldest first, the last is now
  int history_stride = 5;  // simulation steps between two rows
  bool polylines = false;  // the ways ahead of the ego and of each vehicle, as a column of their own
};

struct ModelConfig {
  std::string policy = "squashed_gaussian";  // what acts, and its distribution (common/model/policy_model.h)
  bool stae = true;
  bool context = true;
  bool scene = false;  // scene encoder in the place of stae
  EncoderSharing encoders = EncoderSharing::kSeparate;
  int hidden = 256;
  bool critic_layer_norm = true;
  double log_std_min = -5.0;
  double log_std_max = 2.0;
  bool log_probability = false;  // recorded with each action, in a decision column of this name
};

struct AlgorithmConfig {
  std::string name = "dadrl";
  int batch_size = 64;
  double gamma = 0.998;  // per decision
  int n_step = 3;        // decisions
  double tau = 0.005;
  double actor_learning_rate = 1e-3;
  double critic_learning_rate = 1e-3;
  double temperature_learning_rate = 1e-3;
  double adam_epsilon = 1e-8;
  double initial_temperature = 0.05;
  double target_entropy = -2.0;
  double average_decay = 0.998;    // of the averaged policy, per update
  double max_gradient_norm = 0.0;  // 0: no limit
  double weight_decay = 0.0;       // of AdamW
  int latent_steps = 1;            // that are predicted ahead
  int64_t warmup_updates = 0;      // until the learning rate is whole
  int shift_pixels = 0;            // of the bird's-eye planes in two views of each batch; 0: no views
  int rollout = 512;               // decisions of a batch on policy
  int epochs = 10;                 // over a rollout
  double gae_lambda = 0.95;
  double clip_ratio = 0.2;
  double entropy_weight = 0.01;
};

struct ReplayConfig {
  int shards = 1;
  int64_t max_memory_bytes = int64_t{2} << 30;
  int64_t max_disk_bytes = int64_t{8} << 30;
  int64_t segment_bytes = int64_t{64} << 20;
  SyncMode sync = SyncMode::kInterval;
  double sync_interval_s = 1.0;
  int64_t min_size = 2000;               // frames before the first sample
  double samples_per_insert = 8.0;       // sampling waits above it (transitions per inserted frame); 0: never
  double min_samples_per_insert = 0.0;   // actors wait below it; 0: never
  double samples_per_insert_band = 0.5;  // tolerated deviation of both, in inserts, as a multiple of min_size
  VerifyFrames verify_frames = VerifyFrames::kSome;  // decoded before they are stored
  SamplerKind sampler = SamplerKind::kUniform;
  double priority_exponent = 0.6;
  double importance_exponent = 0.4;
  int max_times_sampled = 0;                        // 0: no limit
  int max_staleness = 0;                            // policy versions; 0: no limit
  int sequence_length = 0;                          // decisions of a sequence; 0: none are sampled
  int sequence_period = 1;                          // decisions from the start of one to that of the next
  int64_t max_items = 0;                            // of a shard; 0: as many as the bytes hold
  SamplerKind remover = SamplerKind::kOldestFirst;  // of items beyond max_items
  double state_interval_s = 10.0;                   // between two writes of counters and priorities
  double snapshot_interval_s = 0.0;                 // 0: only on demand
  int snapshots_kept = 2;                           // of the automatic ones
};

inline bool ByPriority(SamplerKind kind) {
  return kind == SamplerKind::kPrioritized || kind == SamplerKind::kHighestPriority ||
         kind == SamplerKind::kLowestPriority;
}
// Whether the learner's errors decide anything in this replay.
inline bool UsesPriorities(const ReplayConfig& replay) {
  return ByPriority(replay.sampler) || (replay.max_items > 0 && ByPriority(replay.remover));
}

struct LearnerConfig {
  int threads = 1;
  int credits = 3;  // batch requests outstanding
  double publish_interval_s = 1.0;
  PublishedPolicy publish = PublishedPolicy::kAveraged;
  double checkpoint_interval_s = 30.0;
  int checkpoints_kept = 3;
  int64_t max_updates = 0;       // 0: until stopped
  double max_cpu_seconds = 0.0;  // of the learner process; 0: until stopped
};

// Whose frames an actor stores.
enum class KeptEpisodes { kAll, kSuccesses };

struct ActorConfig {
  int count = 1;
  std::string policy = "learned";  // who drives: the learner's, a scripted driver's name, or a policy file
  bool wait_for_policy = false;    // before the first one arrives; else actors drive at random until then
  KeptEpisodes keep = KeptEpisodes::kAll;
  int chunk_frames = 64;
  int64_t max_unacknowledged_bytes = int64_t{64} << 20;
  FloatCoding floats = FloatCoding::kFloat16;
};

struct EvaluationConfig {
  double interval_s = 300.0;  // between two evaluations while training; 0: none
  int episodes = 40;          // of one evaluation while training
  int processes = 1;
  int candidates = 8;            // newest policies of which a training's end chooses one; 1: the newest
  int candidate_episodes = 100;  // that each of them drives for it
};

struct ClusterConfig {
  std::string host = "127.0.0.1";  // address the replay and the learner are reached at
  int port = 0;                    // base of the DDS ports; 0: the launcher takes a free one
  double lease_s = 3.0;            // how long a network cut, or a killed peer, holds up a reliable DDS writer
  double liveliness_s = 1.0;
  int64_t receive_buffer_bytes = int64_t{4} << 20;
  int mtu = 0;               // longest IP packet off loopback, bytes; 0: that of the interface
  bool require_key = false;  // off loopback too, only who has the run's key (RUN/key) takes part
};

struct TelemetryConfig {
  bool enabled = true;
  double interval_s = 1.0;
};

struct Config {
  std::string scenario = "left_turn";
  uint64_t seed = 1;
  double minutes = 0.0;  // wall time of a training; 0: until stopped
  TrafficConfig traffic;
  TaskConfig task;
  ObservationConfig observation;
  ModelConfig model;
  AlgorithmConfig algorithm;
  ReplayConfig replay;
  LearnerConfig learner;
  ActorConfig actor;
  EvaluationConfig evaluation;
  ClusterConfig cluster;
  TelemetryConfig telemetry;
};

}  // namespace dadrl
