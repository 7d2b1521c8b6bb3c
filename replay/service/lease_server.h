// Gives out actor numbers over the control domain; shard 0's.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/config/config.h"
#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "proto/topics.h"
#include "replay/service/lease_table.h"

namespace dadrl {

// Not thread safe; never blocks. Who asks for a number is answered; who shows the one it has, only when that
// is another's. A program of another version, or with other columns, is refused with both sides named.
// Time in which Serve was not called (the process was stopped, or got no core) ends no lease: nobody was
// heard.
class LeaseServer {
 public:
  // `least_incarnation`: above that of every chunk that is stored. Borrows `clock`.
  static Result<std::unique_ptr<LeaseServer>> Create(const Transport& transport, const Config& config,
                                                     uint64_t schema, uint64_t least_incarnation,
                                                     const Clock& clock);
  // Answers what has arrived.
  void Serve();

 private:
  using RequestReader = Reader<dadrl_idl_LeaseRequest>;
  using AnswerWriter = Writer<dadrl_idl_LeaseAnswer>;
  using AnswerWriters = std::array<std::unique_ptr<AnswerWriter>, kAcknowledgementGroups>;

  LeaseServer(std::unique_ptr<RequestReader> requests, AnswerWriters answers, LeaseTable table,
              uint64_t schema, uint64_t least_incarnation, const Clock& clock);
  void OnRequest(const dadrl_idl_LeaseRequest& message);
  LeaseTable::Answer Decide(const dadrl_idl_LeaseRequest& message);
  void Log(const dadrl_idl_LeaseRequest& message, const LeaseTable::Answer& answer);

  const std::unique_ptr<RequestReader> requests_;
  const AnswerWriters answers_;
  LeaseTable table_;
  const uint64_t schema_;
  const uint64_t least_incarnation_;
  const Clock& clock_;
  std::optional<TimePoint> served_at_;
  Duration deaf_{};  // together
  TimePoint next_log_{};
};

}  // namespace dadrl
