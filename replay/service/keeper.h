// What keeps a shard in order, on a thread of its own: whatever may block on the disk and must not hold up
// inserts or draws.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "common/config/config.h"
#include "common/dds/endpoint.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "proto/topics.h"
#include "replay/service/chores.h"
#include "replay/table.h"

namespace dadrl {

// One thread runs Run. Forces the log to the device (replay.sync: interval), saves the state, takes snapshots
// into <run directory>/snapshots/shard-K, says when these hold too much of the disk, trims resident memory,
// and does what `dadrl replay limit` and `dadrl replay snapshot` ask for over the control domain.
class Keeper {
 public:
  // Borrows `table` and `clock`. `on_limit` is called after the rate limiter changed: both sides may be
  // waiting.
  static Result<std::unique_ptr<Keeper>> Create(const dds::Node& node, const Config& config, uint32_t shard,
                                                const std::filesystem::path& run_directory,
                                                ReplayTable& table, const Clock& clock,
                                                std::function<void()> on_limit);

  void Run(const std::atomic<bool>& stop);
  void Wake() { commands_->Wake(); }
  // Bytes that only snapshots hold, as last looked at; for any thread.
  uint64_t snapshot_bytes() const { return snapshot_bytes_.load(); }

 private:
  using CommandReader = dds::Reader<dadrl_idl_ReplayCommand>;
  using AnswerWriter = dds::Writer<dadrl_idl_ReplayAnswer>;

  Keeper(std::unique_ptr<CommandReader> commands, std::unique_ptr<AnswerWriter> answers, const Config& config,
         uint32_t shard, const std::filesystem::path& run_directory, ReplayTable& table, const Clock& clock,
         std::function<void()> on_limit);
  void OnCommand(const dadrl_idl_ReplayCommand& command);
  Result<std::string> Obey(const dadrl_idl_ReplayCommand& command);
  Result<std::string> ChangeLimit(const dadrl_idl_ReplayCommand& command);
  Result<std::string> TakeSnapshot(const std::string& name);
  Status TakeAutomaticSnapshot();
  // kExhausted when snapshots hold more than the replay itself may.
  Status CheckSnapshots();

  const std::unique_ptr<CommandReader> commands_;
  const std::unique_ptr<AnswerWriter> answers_;
  const ReplayConfig replay_;
  const uint32_t shard_;
  const std::filesystem::path snapshots_;
  ReplayTable& table_;
  const std::function<void()> on_limit_;
  std::atomic<uint64_t> snapshot_bytes_{0};
  Chores chores_;

  // The last command, so that one that is sent again is answered again, not done again.
  uint64_t last_command_ = 0;
  bool last_done_ = false;
  std::string last_text_;
};

}  // namespace dadrl
