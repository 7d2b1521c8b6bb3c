#include "common/config/validate.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config_schema.h"
#include "common/step/driving_shape.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

// Inserted frames that may be needed for a batch: eight minutes at 2000 frames/s.
constexpr double kMostInsertsPerBatch = 1e6;
// A frame's header, flags and planes without anything in them.
constexpr int64_t kLeastFrameBytes = 64;

int64_t ObservationFloats(const Config& config) {
  const DrivingShape spec = DrivingShape::From(config.observation);
  return spec.vehicle_floats() + spec.ego_floats() + spec.polyline_floats();
}

Status CheckTask(const Config& config) {
  const RewardConfig& r = config.task.reward;
  const std::array weights = {r.crash, r.off_road,  r.goal,      r.progress,
                              r.speed, r.off_route, r.wrong_way, r.slow};
  if (std::ranges::all_of(weights, [](double weight) { return weight == 0.0; })) {
    return Fail(ErrorCode::kInvalidArgument,
                "task.reward: every weight is 0, so there is nothing to learn; give one a value");
  }
  const ObservationConfig& o = config.observation;
  const int oldest = (o.history - 1) * o.history_stride;
  if (oldest >= config.task.max_steps) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "observation.history: {} rows, {} steps apart, reach {} steps back, and no episode is longer than "
        "task.max_steps: {}; lower history or history_stride",
        o.history, o.history_stride, oldest, config.task.max_steps);
  }
  return {};
}

Status CheckModel(const Config& config) {
  const ModelConfig& model = config.model;
  if (!model.stae && !model.context && !model.scene) {
    return Fail(ErrorCode::kInvalidArgument,
                "model.stae, model.context and model.scene are all false; keep one");
  }
  if (model.scene && model.stae) {
    return Fail(ErrorCode::kInvalidArgument,
                "model.scene and model.stae are both true, and both read the vehicles; set model.stae=false");
  }
  if (model.scene && !config.observation.polylines) {
    return Fail(ErrorCode::kInvalidArgument,
                "model.scene reads polylines, and observation.polylines is false; set it to true");
  }
  if (model.log_std_min >= model.log_std_max) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "model.log_std_min: {} is not below model.log_std_max: {}; the policy could not learn its width",
        model.log_std_min, model.log_std_max);
  }
  return {};
}

Status CheckViews(const Config& config) {
  if (config.algorithm.shift_pixels == 0) return {};
  if (!config.model.context) {
    return Fail(ErrorCode::kInvalidArgument,
                "algorithm.shift_pixels: {} shifts bird's-eye planes, and model.context: false has none; set "
                "either of them",
                config.algorithm.shift_pixels);
  }
  constexpr int kMostThreads = 128;  // half of nn::kMaxGradients
  if (config.learner.threads > kMostThreads) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "learner.threads: {} is more than the {} that two views (algorithm.shift_pixels: {}) leave room for",
        config.learner.threads, kMostThreads, config.algorithm.shift_pixels);
  }
  return {};
}

// Names that are no path; what a file holds is looked at by who reads it.
Status CheckDriver(const std::string& policy) {
  const std::vector<std::string> names = {"learned", "random", "rdm", "slow", "predictive"};
  if (std::ranges::find(names, policy) != names.end()) return {};
  if (policy.find_first_of("/.") != std::string::npos) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "actor.policy: '{}' is neither the path of a policy file nor one of: {}; the nearest is '{}'",
              Shown(policy), fmt::join(names, ", "), NearestName(policy, names));
}

// Whatever the algorithm: networks work on 16 rows at a time, and each thread on its share of them.
Status CheckRows(const Config& config) {
  const int batch = config.algorithm.batch_size;
  if (batch % 16 != 0) {
    return Fail(ErrorCode::kInvalidArgument, "algorithm.batch_size: {} is not a multiple of 16", batch);
  }
  if (batch >= 16 * config.learner.threads) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "learner.threads: {} threads need algorithm.batch_size of at least {}, it is {}",
              config.learner.threads, 16 * config.learner.threads, batch);
}

Status CheckStore(const Config& config) {
  const ReplayConfig& replay = config.replay;
  if (replay.segment_bytes > replay.max_disk_bytes) {
    return Fail(ErrorCode::kInvalidArgument, "replay.segment_bytes: {} exceeds replay.max_disk_bytes: {}",
                replay.segment_bytes, replay.max_disk_bytes);
  }
  // Half a byte a number is less than any codec makes of them; a run that fits by so much has room.
  const int64_t frame = kLeastFrameBytes + ObservationFloats(config) / 2;
  const int64_t shard_min_size = (replay.min_size + replay.shards - 1) / replay.shards;
  if (shard_min_size > replay.max_disk_bytes / frame) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.min_size: {} frames in a shard take more than {} bytes each, replay.max_disk_bytes: {} "
        "holds less, so nothing would ever be sampled; lower the one or raise the other",
        shard_min_size, frame, replay.max_disk_bytes);
  }
  if (replay.max_items > 0 && replay.max_items < shard_min_size) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.max_items: {} is less than a shard's part of replay.min_size, {}; nothing would ever be "
        "sampled",
        replay.max_items, shard_min_size);
  }
  return {};
}

Status CheckRates(const Config& config) {
  const ReplayConfig& replay = config.replay;
  const int batch = config.algorithm.batch_size;
  if (replay.samples_per_insert > 0.0 && replay.min_samples_per_insert > replay.samples_per_insert) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.min_samples_per_insert: {} exceeds replay.samples_per_insert: {}; both sides would wait",
        replay.min_samples_per_insert, replay.samples_per_insert);
  }
  if (replay.samples_per_insert > 0.0 && batch / replay.samples_per_insert > kMostInsertsPerBatch) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.samples_per_insert: {} lets a batch of algorithm.batch_size: {} wait for {:.3g} frames; "
        "take at least {:g}, or 0 for no bound",
        replay.samples_per_insert, batch, batch / replay.samples_per_insert, batch / kMostInsertsPerBatch);
  }
  return {};
}

Status CheckSampling(const Config& config) {
  const ReplayConfig& replay = config.replay;
  if (replay.sequence_period > std::max(replay.sequence_length, 1)) {
    return Fail(ErrorCode::kInvalidArgument,
                "replay.sequence_period: {} exceeds replay.sequence_length: {}; frames between would never "
                "be sampled",
                replay.sequence_period, replay.sequence_length);
  }
  const int times = std::max(replay.max_times_sampled, 1);
  const int64_t items_of_a_batch = (config.algorithm.batch_size + times - 1) / times;
  if (replay.max_items > 0 && replay.max_times_sampled > 0 && replay.max_items < items_of_a_batch) {
    return Fail(ErrorCode::kInvalidArgument,
                "replay.max_items: {} items of replay.max_times_sampled: {} never make a batch of "
                "algorithm.batch_size: {}; nothing would ever be sampled",
                replay.max_items, replay.max_times_sampled, config.algorithm.batch_size);
  }
  const bool random = replay.sampler == SamplerKind::kUniform || replay.sampler == SamplerKind::kPrioritized;
  if (!random && replay.max_times_sampled == 0) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.max_times_sampled: 0 with an ordered replay.sampler samples one item for ever; set it "
        "to at least 1");
  }
  return {};
}

// 0 turns it off; shorter than a second it would never rest.
Status CheckInterval(const char* key, double interval_s) {
  if (interval_s <= 0.0 || interval_s >= 1.0) return {};
  return Fail(ErrorCode::kInvalidArgument, "{}: {} s is below 1 s; take more, or 0 for none", key,
              interval_s);
}

Status CheckCluster(const ClusterConfig& cluster) {
  constexpr int kFirstUserPort = 1024;
  if (cluster.port > 0 && cluster.port < kFirstUserPort) {
    return Fail(ErrorCode::kInvalidArgument,
                "cluster.port: {} is one of the system's; take {} to 60000, or 0 for a free one",
                cluster.port, kFirstUserPort);
  }
  constexpr int kSmallestMtu = 576;  // that every IPv4 host takes
  if (cluster.mtu != 0 && cluster.mtu < kSmallestMtu) {
    return Fail(ErrorCode::kInvalidArgument, "cluster.mtu: {} is neither 0 nor at least {}", cluster.mtu,
                kSmallestMtu);
  }
  if (cluster.lease_s < cluster.liveliness_s) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "cluster.lease_s: {} is shorter than cluster.liveliness_s: {}; a peer would be forgotten before "
        "its silence counts",
        cluster.lease_s, cluster.liveliness_s);
  }
  return {};
}

}  // namespace

Status Validate(const Config& config) {
  DADRL_RETURN_IF_ERROR(CheckTask(config));
  DADRL_RETURN_IF_ERROR(CheckModel(config));
  DADRL_RETURN_IF_ERROR(CheckViews(config));
  DADRL_RETURN_IF_ERROR(CheckDriver(config.actor.policy));
  DADRL_RETURN_IF_ERROR(CheckRows(config));
  DADRL_RETURN_IF_ERROR(CheckStore(config));
  DADRL_RETURN_IF_ERROR(CheckRates(config));
  DADRL_RETURN_IF_ERROR(CheckSampling(config));
  DADRL_RETURN_IF_ERROR(CheckInterval("replay.snapshot_interval_s", config.replay.snapshot_interval_s));
  DADRL_RETURN_IF_ERROR(CheckInterval("evaluation.interval_s", config.evaluation.interval_s));
  return CheckCluster(config.cluster);
}

}  // namespace dadrl
