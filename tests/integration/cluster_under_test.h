// A cluster started as a user starts it, watched as a user watches it.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "deploy/local/child_process.h"
#include "deploy/local/log_tail.h"
#include "tests/deploy/cli/run_command.h"

namespace dadrl {

using nlohmann::json;

// Small enough to train within seconds on two busy cores; everything else as a user has it.
inline std::vector<std::string> SmallTraining() {
  return {"--actors", "1",
          "--set",    "replay.min_size=200",
          "--set",    "actor.chunk_frames=16",
          "--set",    "model.hidden=32",
          "--set",    "learner.checkpoint_interval_s=2",
          "--set",    "learner.publish_interval_s=0.2",
          "--set",    "telemetry.interval_s=0.2",
          "--set",    "evaluation.interval_s=0",
          "--set",    "evaluation.episodes=2",
          "--set",    "evaluation.candidates=2",
          "--set",    "evaluation.candidate_episodes=2"};
}

// Owns the launcher and, through it, the cluster.
class ClusterUnderTest {
 public:
  // `dadrl train ARGUMENTS --run-dir run_directory`.
  ClusterUnderTest(const std::filesystem::path& run_directory, std::vector<std::string> arguments)
      : run_(run_directory), log_(run_directory.string() + ".train.log") {
    arguments.insert(arguments.begin(), {DadrlProgram(), "train"});
    arguments.insert(arguments.end(), {"--run-dir", run_.string()});
    auto launcher = ChildProcess::Spawn({.command = std::move(arguments), .log = log_});
    if (launcher) launcher_.emplace(std::move(*launcher));
    EXPECT_TRUE(launcher_) << "cannot start dadrl";
  }

  const std::filesystem::path& run() const { return run_; }
  ChildProcess& launcher() { return *launcher_; }
  // What the launcher said so far and the ends of the processes' logs, for messages of failed expectations.
  std::string Said() const {
    std::string text = "\n--- dadrl train said:\n" + FileText(log_);
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(run_ / "logs", error)) {
      if (entry.path().extension() != ".log") continue;
      text += "--- " + entry.path().filename().string() + " ends:\n";
      for (const std::string& line : LogTail(entry.path(), 8)) text += line + "\n";
    }
    return text;
  }

  // Exit code once it has ended; -1 when it was killed or does not end within `seconds`.
  int WaitForEnd(int seconds) {
    std::optional<ExitStatus> status;
    Eventually([&] { return (status = launcher_->TryWait()).has_value(); }, std::chrono::seconds(seconds));
    return status && !status->signaled ? status->value : -1;
  }

  // `dadrl monitor --json`, when it has an answer.
  std::optional<json> Monitor() const {
    const CommandOutput output = Dadrl({"monitor", "--json", "--run-dir", run_});
    if (output.exit_code != 0) return std::nullopt;
    const json object = json::parse(output.out, nullptr, false);
    EXPECT_TRUE(object.is_object()) << output.out;
    return object;
  }

  // Asks the monitor until `condition` holds for its answer; nothing when it does not within `seconds` or the
  // launcher has ended.
  std::optional<json> MonitorUntil(const std::function<bool(const json&)>& condition, int seconds = 90) {
    std::optional<json> answer;
    const bool held = Eventually(
        [&] {
          if (launcher_->TryWait()) return true;
          answer = Monitor();
          return answer && condition(*answer);
        },
        std::chrono::seconds(seconds));
    if (!held || launcher_->TryWait() || !answer) return std::nullopt;
    return answer;
  }

 private:
  std::filesystem::path run_;
  std::filesystem::path log_;
  std::optional<ChildProcess> launcher_;
};

// The row of a process ("actor-0", "learner") in a monitor's answer; null when it is not there.
inline json ProcessIn(const json& monitor, const std::string& name) {
  for (const json& row : monitor["processes"]) {
    if (row["name"] == name) return row;
  }
  return nullptr;
}

inline pid_t PidOf(const json& monitor, const std::string& name) {
  const json row = ProcessIn(monitor, name);
  return row.is_null() ? 0 : row["pid"].get<pid_t>();
}

inline double MetricOf(const json& monitor, const std::string& name, const std::string& metric) {
  const json row = ProcessIn(monitor, name);
  return row.is_null() ? 0.0 : row["metrics"].value(metric, 0.0);
}

inline bool IsTraining(const json& monitor) {
  return monitor["updates_per_s"] > 0.0 && monitor["env_steps_per_s"] > 0.0 && monitor["actors_alive"] > 0;
}

}  // namespace dadrl
