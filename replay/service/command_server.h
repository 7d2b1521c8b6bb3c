// What a user asks of a running shard (`dadrl replay limit | snapshot`): taken, done and answered without
// anyone else's waiting for it.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/port/port.h"
#include "common/util/result.h"
#include "proto/topics.h"
#include "replay/service/maintenance.h"
#include "replay/table.h"

namespace dadrl {

// Not thread safe; never blocks. What needs the disk is Maintenance's to do, in its turn; a command is
// answered once that is done, and again whenever it is repeated. Bounded: the last kRemembered commands.
class CommandServer {
 public:
  static constexpr size_t kRemembered = 64;

  // Borrows `table` and `maintenance`. `on_limit` is called after the rate limiter changed: both sides may be
  // waiting.
  static Result<std::unique_ptr<CommandServer>> Create(const Transport& transport, uint32_t shard,
                                                       ReplayTable& table, Maintenance& maintenance,
                                                       std::function<void()> on_limit);
  // Takes what has arrived, answers what is done.
  void Serve();

 private:
  using CommandReader = Reader<dadrl_idl_ReplayCommand>;
  using AnswerWriter = Writer<dadrl_idl_ReplayAnswer>;
  using Outcome = Result<std::string>;
  struct Known {
    uint64_t command = 0;
    std::optional<Outcome> outcome{};  // nothing: it is under way
  };

  CommandServer(std::unique_ptr<CommandReader> commands, std::unique_ptr<AnswerWriter> answers,
                uint32_t shard, ReplayTable& table, Maintenance& maintenance, std::function<void()> on_limit);
  void OnCommand(const dadrl_idl_ReplayCommand& command);
  // The outcome, if there is one at once.
  std::optional<Outcome> Begin(const dadrl_idl_ReplayCommand& command);
  std::optional<Outcome> ChangeLimit(const dadrl_idl_ReplayCommand& command);
  // Nothing, or that too much is to be done already.
  std::optional<Outcome> Enqueue(uint64_t command, std::function<Outcome()> work);
  void OnDone(uint64_t command, Outcome outcome);
  void Answer(const Known& known);

  const std::unique_ptr<CommandReader> commands_;
  const std::unique_ptr<AnswerWriter> answers_;
  const uint32_t shard_;
  ReplayTable& table_;
  Maintenance& maintenance_;
  const std::function<void()> on_limit_;
  std::deque<Known> known_;
};

}  // namespace dadrl
