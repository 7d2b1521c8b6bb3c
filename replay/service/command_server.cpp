#include "replay/service/command_server.h"

#include <algorithm>
#include <utility>

#include "common/util/log.h"
#include "replay/service/limit_command.h"

namespace dadrl {
namespace {

std::string Describe(uint32_t shard, const RateLimiter::Options& options) {
  return fmt::format(
      "shard {}: at most {} and at least {} samples per insert, from {} frames on, band {} frames", shard,
      options.max_samples_per_insert, options.min_samples_per_insert, options.min_size, options.band);
}

}  // namespace

Result<std::unique_ptr<CommandServer>> CommandServer::Create(const Transport& transport, uint32_t shard,
                                                             ReplayTable& table, Maintenance& maintenance,
                                                             std::function<void()> on_limit) {
  // The writer first: who finds the reader can already be answered.
  DADRL_ASSIGN_OR_RETURN(auto answers, AnswerWriter::Create(transport, kReplayAnswerTopic));
  DADRL_ASSIGN_OR_RETURN(auto commands, CommandReader::Create(transport, kReplayCommandTopic));
  return std::unique_ptr<CommandServer>(new CommandServer(std::move(commands), std::move(answers), shard,
                                                          table, maintenance, std::move(on_limit)));
}

CommandServer::CommandServer(std::unique_ptr<CommandReader> commands, std::unique_ptr<AnswerWriter> answers,
                             uint32_t shard, ReplayTable& table, Maintenance& maintenance,
                             std::function<void()> on_limit)
    : commands_(std::move(commands)),
      answers_(std::move(answers)),
      shard_(shard),
      table_(table),
      maintenance_(maintenance),
      on_limit_(std::move(on_limit)) {}

void CommandServer::Serve() {
  commands_->Take(16, [this](const dadrl_idl_ReplayCommand& command) { OnCommand(command); });
  while (auto done = maintenance_.TakeDone()) OnDone(done->job, std::move(done->outcome));
}

void CommandServer::OnCommand(const dadrl_idl_ReplayCommand& command) {
  if (command.shard != shard_) return;
  const auto known = std::find_if(known_.begin(), known_.end(),
                                  [&](const Known& one) { return one.command == command.command; });
  if (known != known_.end()) {
    if (known->outcome) Answer(*known);
    return;
  }
  known_.push_back({.command = command.command});
  if (known_.size() > kRemembered) known_.pop_front();
  if (auto outcome = Begin(command)) OnDone(command.command, std::move(*outcome));
}

std::optional<CommandServer::Outcome> CommandServer::Begin(const dadrl_idl_ReplayCommand& command) {
  switch (static_cast<ReplayCommandKind>(command.kind)) {
    case ReplayCommandKind::kLimit:
      return ChangeLimit(command);
    case ReplayCommandKind::kSnapshot:
      return Enqueue(command.command, [this, name = std::string(command.snapshot)] {
        return maintenance_.TakeSnapshot(name);
      });
  }
  return Fail(ErrorCode::kInvalidArgument, "shard {} does not know command {}", shard_, command.kind);
}

std::optional<CommandServer::Outcome> CommandServer::ChangeLimit(const dadrl_idl_ReplayCommand& command) {
  const RateLimiter::Options before = table_.limiter_options();
  const Result<RateLimiter::Options> changed = ChangedLimits(before, command);
  if (!changed) return Fail(ErrorCode::kInvalidArgument, "shard {}: {}", shard_, changed.error().message);
  const RateLimiter::Options& options = *changed;
  if (options == before) return Describe(shard_, options);
  table_.Reconfigure(options);
  on_limit_();
  // In force at once; said when it also outlives a restart.
  return Enqueue(command.command, [this, options = options]() -> Outcome {
    DADRL_RETURN_IF_ERROR(table_.SaveState());
    return Describe(shard_, options);
  });
}

std::optional<CommandServer::Outcome> CommandServer::Enqueue(uint64_t command,
                                                             std::function<Outcome()> work) {
  if (maintenance_.Do(command, std::move(work))) return std::nullopt;
  return Fail(ErrorCode::kExhausted, "shard {}: {} commands wait for its disk already; try again later",
              shard_, Maintenance::kMaxJobs);
}

void CommandServer::OnDone(uint64_t command, Outcome outcome) {
  if (outcome) {
    spdlog::info("{}", *outcome);
  } else {
    spdlog::warn("{}", outcome.error().message);
  }
  const auto known =
      std::find_if(known_.begin(), known_.end(), [&](const Known& one) { return one.command == command; });
  if (known == known_.end()) return;
  known->outcome = std::move(outcome);
  Answer(*known);
}

void CommandServer::Answer(const Known& known) {
  const std::string& text = *known.outcome ? **known.outcome : known.outcome->error().message;
  dadrl_idl_ReplayAnswer answer{};
  answer.shard = shard_;
  answer.command = known.command;
  answer.done = known.outcome->has_value();
  const size_t length = std::min(text.size(), sizeof(answer.text) - 1);  // ends with a zero
  std::copy_n(text.data(), length, answer.text);
  if (const Status sent = answers_->Write(answer); !sent) spdlog::warn("answer: {}", sent.error().message);
}

}  // namespace dadrl
