#include "common/config/config_schema.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <numeric>

#include "common/util/shown.h"

namespace dadrl {
namespace {

constexpr double kHuge = 1e15;
constexpr const char* kLearns = "with 0 nothing is learnt, with more than 0.1 the weights run away";

class SchemaBuilder {
 public:
  void Add(std::string key, bool& value, std::string help) { Push(std::move(key), std::move(help), &value); }
  void Add(std::string key, std::string& value, std::string help) {
    Push(std::move(key), std::move(help), &value);
  }
  template <typename Number>
  void Add(std::string key, Number& value, double min, double max, std::string help) {
    Push(std::move(key), std::move(help), &value);
    fields_.back().min = min;
    fields_.back().max = max;
  }
  // Of the range of the field added last.
  void Because(std::string reason) { fields_.back().reason = std::move(reason); }
  template <typename Enum>
  void AddChoice(std::string key, Enum& value, std::vector<std::string> choices, std::string help) {
    Push(std::move(key), std::move(help),
         ConfigField::EnumTarget{
             &value, [](const void* target) { return static_cast<int>(*static_cast<const Enum*>(target)); },
             [](void* target, int index) { *static_cast<Enum*>(target) = static_cast<Enum>(index); }});
    fields_.back().choices = std::move(choices);
  }
  std::vector<ConfigField> Take() { return std::move(fields_); }

 private:
  template <typename Target>
  void Push(std::string key, std::string help, Target target) {
    ConfigField field;
    field.key = std::move(key);
    field.help = std::move(help);
    field.target = target;
    fields_.push_back(std::move(field));
  }
  std::vector<ConfigField> fields_;
};

void AddTask(SchemaBuilder& b, Config& c) {
  b.AddChoice("traffic.profile", c.traffic.profile, {"calibrated", "plain"},
              "Driver settings: calibrated restores the paper's difficulty, plain is SUMO's kind default");
  b.Add("task.decision_interval", c.task.decision_interval, 1, 20,
        "Simulation steps (0.1 s) one action is held");
  b.Add("task.max_steps", c.task.max_steps, 1, 100000, "Simulation steps before an episode is truncated");
  b.Add("task.max_speed_mps", c.task.max_speed_mps, 1, 40, "Target speed of action +1, m/s");
  RewardConfig& r = c.task.reward;
  b.Add("task.reward.crash", r.crash, -100, 100, "Once, on a collision");
  b.Add("task.reward.off_road", r.off_road, -100, 100, "Once, on leaving the road");
  b.Add("task.reward.goal", r.goal, -100, 100, "Once, on reaching the goal");
  b.Add("task.reward.progress", r.progress, -100, 100, "Times the fraction of the route driven, each step");
  b.Add("task.reward.speed", r.speed, -100, 100,
        "Times speed / limit, each step; the excess counts negative");
  b.Add("task.reward.off_route", r.off_route, -100, 100, "Each step off the route");
  b.Add("task.reward.wrong_way", r.wrong_way, -100, 100, "Each step against the lane");
  b.Add("task.reward.slow", r.slow, -100, 100, "Every ten seconds spent below a tenth of the limit");
  b.Add("observation.vehicles", c.observation.vehicles, 1, 64, "Nearest vehicles the ego sees");
  b.Add("observation.radius_m", c.observation.radius_m, 1, 500, "How far it sees, m");
  b.Add("observation.history", c.observation.history, 1, 50, "Rows of history, the last is now");
  b.Add("observation.history_stride", c.observation.history_stride, 1, 50,
        "Simulation steps between two rows");
  b.Add("observation.polylines", c.observation.polylines,
        "Two ways ahead of the ego and of each vehicle, ten points each, as another column");
}

void AddOnPolicy(SchemaBuilder& b, AlgorithmConfig& a) {
  b.Add("algorithm.rollout", a.rollout, 16, 1 << 20, "Decisions of a batch, on policy");
  b.Add("algorithm.epochs", a.epochs, 1, 1000, "Passes over a batch, on policy");
  b.Add("algorithm.gae_lambda", a.gae_lambda, 0, 1,
        "Decay of the generalised advantage estimate, per decision: 0 trusts the values, 1 the rewards");
  b.Add("algorithm.clip_ratio", a.clip_ratio, 1e-3, 10,
        "How far an update may change an action's probability, as a fraction of it");
  b.Because("with 0 no update would change anything");
  b.Add("algorithm.entropy_weight", a.entropy_weight, 0, 100, "Reward of a nat of entropy, on policy");
}

void AddTraining(SchemaBuilder& b, Config& c) {
  b.Add("model.policy", c.model.policy, "What acts: squashed_gaussian is a Gaussian through tanh");
  b.Add("model.stae", c.model.stae, "Spatio-temporal attention encoder; false is the paper's ablation");
  b.Add("model.context", c.model.context, "Bird's-eye context encoder; false is the paper's ablation");
  b.Add("model.scene", c.model.scene,
        "Scene encoder: attention over histories and polylines, in the place of model.stae");
  b.AddChoice("model.encoders", c.model.encoders, {"separate", "shared"},
              "Whether actor and critics own an encoder each, or share one trained by the critic loss");
  b.Add("model.hidden", c.model.hidden, 16, 1024, "Width of the two hidden layers of policy and critics");
  b.Add("model.critic_layer_norm", c.model.critic_layer_norm, "Layer norm in the critics' hidden layers");
  b.Add("model.log_std_min", c.model.log_std_min, -20, 0,
        "Lower clamp of the policy's log standard deviation");
  b.Add("model.log_std_max", c.model.log_std_max, 0, 10,
        "Upper clamp of the policy's log standard deviation");
  b.Add("model.log_probability", c.model.log_probability,
        "Actors record the log-probability of each action, as methods on policy need");
  AlgorithmConfig& a = c.algorithm;
  b.Add("algorithm.name", a.name,
        "Learning algorithm (dadrl algorithms lists them); its preset stands between the defaults and "
        "--config");
  b.Add("algorithm.batch_size", a.batch_size, 16, 4096, "Transitions an update; a multiple of 16");
  b.Add("algorithm.gamma", a.gamma, 0, 1, "Discount per decision");
  b.Add("algorithm.n_step", a.n_step, 1, 32, "Decisions summed before bootstrapping");
  b.Add("algorithm.tau", a.tau, 1e-6, 1, "Polyak step of the target critics, per update");
  b.Because("with 0 the target would never move");
  b.Add("algorithm.actor_learning_rate", a.actor_learning_rate, 1e-9, 0.1, "Adam step of the policy");
  b.Because(kLearns);
  b.Add("algorithm.critic_learning_rate", a.critic_learning_rate, 1e-9, 0.1, "Adam step of the critics");
  b.Because(kLearns);
  b.Add("algorithm.temperature_learning_rate", a.temperature_learning_rate, 0, 0.1,
        "Adam step of the temperature; 0 keeps it");
  b.Add("algorithm.adam_epsilon", a.adam_epsilon, 1e-15, 1,
        "Adam's guard against division by zero; larger damps small gradients");
  b.Because("with 0 a weight without a gradient would be divided by zero");
  b.Add("algorithm.initial_temperature", a.initial_temperature, 1e-6, 100, "Entropy weight at the start");
  // At a standard deviation of 0.87; at 1, the least that model.log_std_min = 0 leaves, it is 1.340.
  b.Add("algorithm.target_entropy", a.target_entropy, -100, 1.33, "Entropy the temperature aims at, nats");
  b.Because("two actions in [-1, 1] have at most 2 ln 2 = 1.386 nats, a squashed Gaussian 1.367");
  b.Add("algorithm.average_decay", a.average_decay, 0, 1, "Decay of the averaged policy, per update");
  b.Add("algorithm.max_gradient_norm", a.max_gradient_norm, 0, 1e6,
        "A longer gradient of a network is scaled to it (dt, ppo); 0 is no limit");
  b.Add("algorithm.weight_decay", a.weight_decay, 0, 1, "AdamW's decay of weight matrices (dt)");
  b.Add("algorithm.latent_steps", a.latent_steps, 1, 32,
        "Decisions over which the encoder learns to predict its own state (slt)");
  b.Add("algorithm.warmup_updates", a.warmup_updates, 0, kHuge,
        "Updates over which the learning rate rises from 0 (dt)");
  b.Add("algorithm.shift_pixels", a.shift_pixels, 0, 16,
        "Soft actor-critic learns from two views of each batch, their bird's-eye planes shifted by up to so "
        "many pixels (0.4 m); 0 is one view, unshifted");
  AddOnPolicy(b, a);
}

void AddReplay(SchemaBuilder& b, Config& c) {
  ReplayConfig& r = c.replay;
  b.Add("replay.shards", r.shards, 1, 16, "Replay processes");
  b.Add("replay.max_memory_bytes", r.max_memory_bytes, 1 << 20, kHuge, "Bound on frames held in memory");
  b.Add("replay.max_disk_bytes", r.max_disk_bytes, 1 << 20, kHuge, "Bound on the segment files");
  b.Add("replay.segment_bytes", r.segment_bytes, 1 << 16, 1 << 30, "Size of one segment file");
  b.AddChoice("replay.sync", r.sync, {"none", "interval", "always"},
              "When stored chunks are forced to disk; an acknowledgement promises what this does");
  b.Add("replay.sync_interval_s", r.sync_interval_s, 0.01, 3600, "Seconds between two forced writes");
  b.Add("replay.min_size", r.min_size, 1, kHuge,
        "Frames held, over all shards, before the first sample; actors act at random until then");
  b.Add("replay.samples_per_insert", r.samples_per_insert, 0, 1e6,
        "Sampled transitions per inserted frame above which sampling waits; 0 is never");
  b.Add("replay.min_samples_per_insert", r.min_samples_per_insert, 0, 1e6,
        "Sampled transitions per inserted frame below which actors wait; 0 is never");
  b.Add("replay.samples_per_insert_band", r.samples_per_insert_band, 0.01, 1e6,
        "Tolerated deviation of both, in inserted frames, as a multiple of min_size");
  b.AddChoice(
      "replay.verify_frames", r.verify_frames, {"none", "some", "all"},
      "Frames decoded before they are stored, 2 us each; some: all of an actor's first 64 chunks, then "
      "one of each chunk");
  const std::vector<std::string> selectors = {"uniform",      "prioritized",      "newest_first",
                                              "oldest_first", "highest_priority", "lowest_priority"};
  b.AddChoice("replay.sampler", r.sampler, selectors, "How items are sampled");
  b.Add("replay.priority_exponent", r.priority_exponent, 0, 2, "alpha of prioritised replay");
  b.Add("replay.importance_exponent", r.importance_exponent, 0, 2, "beta of prioritised replay");
  b.Add("replay.max_times_sampled", r.max_times_sampled, 0, 1e6, "Samples an item serves; 0 is no limit");
  b.Add("replay.max_staleness", r.max_staleness, 0, 1e9, "Policy versions an item may lag; 0 is no limit");
  b.Add("replay.sequence_length", r.sequence_length, 0, 256,
        "Decisions of the sequences that recurrent algorithms sample; 0 is none");
  b.Add("replay.sequence_period", r.sequence_period, 1, 256,
        "Decisions from the start of a sequence to that of the next one");
  b.Add("replay.max_items", r.max_items, 0, kHuge,
        "Items a shard keeps for sampling; 0 is as many as the bytes hold");
  b.AddChoice("replay.remover", r.remover, selectors, "Which items leave beyond replay.max_items");
  b.Add("replay.state_interval_s", r.state_interval_s, 0.1, 3600,
        "Seconds between two writes of counters and priorities: what kill -9 costs of them at most");
  b.Add("replay.snapshot_interval_s", r.snapshot_interval_s, 0, 1e6,
        "Seconds between two snapshots of the replay; 0 is only on demand (dadrl replay snapshot)");
  b.Add("replay.snapshots_kept", r.snapshots_kept, 1, 1000, "Newest automatic snapshots that are kept");
}

void AddProcesses(SchemaBuilder& b, Config& c) {
  LearnerConfig& l = c.learner;
  b.Add("learner.threads", l.threads, 1, 256, "Training threads");
  b.Add("learner.credits", l.credits, 1, 16, "Batch requests outstanding");
  b.Add("learner.publish_interval_s", l.publish_interval_s, 0.01, 3600,
        "Seconds between two weight broadcasts");
  b.AddChoice("learner.publish", l.publish, {"averaged", "current"}, "Which policy is broadcast and saved");
  b.Add("learner.checkpoint_interval_s", l.checkpoint_interval_s, 1, 3600, "Seconds between two checkpoints");
  b.Add("learner.checkpoints_kept", l.checkpoints_kept, 1, 1000, "Older checkpoints are removed");
  b.Add("learner.max_updates", l.max_updates, 0, kHuge, "Stop after so many updates; 0 is never");
  b.Add("learner.max_cpu_seconds", l.max_cpu_seconds, 0, 1e9,
        "Stop after so many seconds of the learner's processor time, all its threads together; 0 is never");
  ActorConfig& a = c.actor;
  b.Add("actor.count", a.count, 0, 4096, "Actor processes on this machine");
  b.Add(
      "actor.policy", a.policy,
      "Who drives: learned (the policy that is learnt), a scripted driver (random, rdm, slow, predictive) or "
      "a policy file, whose experience is learnt from");
  b.Add("actor.wait_for_policy", a.wait_for_policy,
        "Whether actors wait for the learner's first policy; false: they drive at random until it comes");
  b.AddChoice("actor.keep", a.keep, {"all", "successes"},
              "Whose frames are stored, by the episode's outcome");
  b.Add("actor.chunk_frames", a.chunk_frames, 1, 64, "Frames of one experience chunk");
  b.Add("actor.max_unacknowledged_bytes", a.max_unacknowledged_bytes, 1 << 16, kHuge,
        "Experience an actor keeps until the replay has stored it; then it waits");
  b.AddChoice("actor.floats", a.floats, {"fp32", "fp16"}, "Coding of floats in experience");
  EvaluationConfig& e = c.evaluation;
  b.Add("evaluation.interval_s", e.interval_s, 0, 1e9,
        "Seconds between evaluations while training; 0 is none");
  b.Add("evaluation.episodes", e.episodes, 1, 1000,
        "Episodes of an evaluation while training, of each scenario");
  b.Because("a thousand traffic seeds belong to an evaluation");
  b.Add("evaluation.processes", e.processes, 1, 1024, "Processes an evaluation uses");
  b.Add("evaluation.candidates", e.candidates, 1, 1000,
        "Newest policies, one a checkpoint, of which the best is chosen when training ends; 1 is the newest "
        "itself");
  b.Add("evaluation.candidate_episodes", e.candidate_episodes, 1, 1000,
        "Episodes each candidate drives for that, of each scenario; the same for all of them");
  ClusterConfig& n = c.cluster;
  b.Add("cluster.host", n.host, "Address at which actors reach replay and learner");
  b.Add("cluster.port", n.port, 0, 60000, "First DDS port; 0 takes a free one");
  b.Add("cluster.lease_s", n.lease_s, 0.5, 600, "Longest network cut that DDS bridges by itself, s");
  b.Add("cluster.liveliness_s", n.liveliness_s, 0.1, 60,
        "A process that does not get on for five times as long is killed and restarted, s");
  b.Add("cluster.receive_buffer_bytes", n.receive_buffer_bytes, 1 << 16, 1 << 30, "UDP receive buffer");
  b.Add("cluster.mtu", n.mtu, 0, 65536, "Longest IP packet between machines, bytes; 0 asks the interface");
  b.Add("cluster.require_key", n.require_key, "Only who has RUN/key takes part; on 127.0.0.1 always so");
  b.Add("telemetry.enabled", c.telemetry.enabled, "Publish status over LCM");
  b.Add("telemetry.interval_s", c.telemetry.interval_s, 0.05, 60, "Seconds between two status messages");
}

template <typename Number>
Status AssignNumber(const ConfigField& field, std::string_view text, Number* target) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool parsed = error == std::errc() && end == text.data() + text.size();
  const double as_double = value;
  if (!parsed || !(as_double >= field.min && as_double <= field.max)) {
    return Fail(ErrorCode::kInvalidArgument, "{}: '{}' is not {} between {:g} and {:g}{}{}", field.key,
                Shown(text), std::is_integral_v<Number> ? "a whole number" : "a number", field.min, field.max,
                field.reason.empty() ? "" : ": ", field.reason);
  }
  *target = value;
  return {};
}

// Names of folders and hosts.
Status AssignText(const ConfigField& field, std::string_view text, std::string* target) {
  constexpr size_t kLongest = 255;
  const bool plain =
      std::ranges::none_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (text.empty() || text.size() > kLongest || !plain) {
    return Fail(ErrorCode::kInvalidArgument,
                "{}: '{}' is not a text of 1 to {} bytes without control characters", field.key, Shown(text),
                kLongest);
  }
  *target = text;
  return {};
}

// As YAML reads it back: quoted unless it can be nothing but a text.
std::string YamlText(const std::string& text) {
  const bool plain = std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.' || c == '/';
  });
  std::string lower = text;
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (plain && !text.empty() && text.front() != '-' && text.front() != '.' && lower != "null") return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace

std::vector<ConfigField> SchemaOf(Config& config) {
  SchemaBuilder b;
  b.Add("scenario", config.scenario, "Road and traffic: one folder of actor/scenarios, or all");
  b.Add("seed", config.seed, 0, 1e18, "Of everything random in the run");
  b.Add("minutes", config.minutes, 0, 1e6, "Wall time of a training; 0 is until stopped");
  AddTask(b, config);
  AddTraining(b, config);
  AddReplay(b, config);
  AddProcesses(b, config);
  return b.Take();
}

std::string FormatValue(const ConfigField& field) {
  return std::visit(
      [&](auto target) -> std::string {
        using Target = decltype(target);
        if constexpr (std::is_same_v<Target, ConfigField::EnumTarget>) {
          return field.choices[static_cast<size_t>(target.get(target.target))];
        } else if constexpr (std::is_same_v<Target, bool*>) {
          return *target ? "true" : "false";
        } else if constexpr (std::is_same_v<Target, std::string*>) {
          return YamlText(*target);
        } else {
          return fmt::format("{}", *target);
        }
      },
      field.target);
}

Status AssignValue(const ConfigField& field, std::string_view text) {
  return std::visit(
      [&](auto target) -> Status {
        using Target = decltype(target);
        if constexpr (std::is_same_v<Target, ConfigField::EnumTarget>) {
          const auto found = std::find(field.choices.begin(), field.choices.end(), text);
          if (found == field.choices.end()) {
            return Fail(ErrorCode::kInvalidArgument, "{}: '{}' is not one of: {}", field.key, Shown(text),
                        fmt::join(field.choices, ", "));
          }
          target.set(target.target, static_cast<int>(found - field.choices.begin()));
          return {};
        } else if constexpr (std::is_same_v<Target, bool*>) {
          if (text != "true" && text != "false") {
            return Fail(ErrorCode::kInvalidArgument, "{}: '{}' is neither true nor false", field.key,
                        Shown(text));
          }
          *target = text == "true";
          return {};
        } else if constexpr (std::is_same_v<Target, std::string*>) {
          return AssignText(field, text, target);
        } else {
          return AssignNumber(field, text, target);
        }
      },
      field.target);
}

std::string NearestName(std::string_view name, const std::vector<std::string>& candidates) {
  name = name.substr(0, 100);  // no name is longer, and the work grows with it
  std::string best;
  size_t best_distance = std::numeric_limits<size_t>::max();
  for (const std::string& candidate : candidates) {
    std::vector<size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 1; i <= name.size(); ++i) {
      size_t diagonal = row[0];
      row[0] = i;
      for (size_t j = 1; j <= candidate.size(); ++j) {
        const size_t substitution = diagonal + (name[i - 1] != candidate[j - 1]);
        diagonal = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, substitution});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

}  // namespace dadrl
