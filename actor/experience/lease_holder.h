// An actor's number in the run: asked for once, kept by showing it again and again.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/dds/node.h"
#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "proto/lease.h"
#include "proto/topics.h"

namespace dadrl {

// Acquire first; then one thread, any, calls Step every now and then; it never waits for the network. While
// the replay is away nothing happens: the number stays in use until the replay says that it is another's.
class LeaseHolder {
 public:
  struct Options {
    LeaseToken token;
    uint64_t start = 0;              // wanted incarnation, higher with each process of the token
    std::optional<uint32_t> number;  // this one or none; nothing: any
    uint64_t schema = 0;
  };
  struct Lease {
    uint32_t number = 0;
    uint64_t incarnation = 0;
  };

  // How long a number that another holds is asked for: as long as the lease of one that has just died.
  static constexpr Duration kPatience = kLeaseTerm + std::chrono::seconds(2);

  // Borrows `transport` and `clock`.
  static Result<std::unique_ptr<LeaseHolder>> Create(const Transport& transport, const Options& options,
                                                     const Clock& clock);
  // Gives the number back.
  ~LeaseHolder();

  // Waits for a replay to answer, without end; `idle` is called meanwhile, ten times a second at least, and
  // ends it by returning false (kUnavailable). kExhausted: another holds the number. kInvalidArgument: this
  // program and the replay do not fit.
  Result<Lease> Acquire(const std::function<bool()>& idle);
  // When that is due, shows the lease and hears answers. False once it is another's: `lost` says whose.
  bool Step(TimePoint now);
  const std::string& lost() const { return lost_; }

  // A replay is there.
  bool connected() const { return requests_->matched() > 0; }

 private:
  using RequestWriter = Writer<dadrl_idl_LeaseRequest>;
  using AnswerReader = Reader<dadrl_idl_LeaseAnswer>;

  LeaseHolder(const Options& options, const Clock& clock) : options_(options), clock_(clock) {}
  void Ask(bool leaving);
  // The newest answer to this process, if one came.
  std::optional<dadrl_idl_LeaseAnswer> Hear();

  const Options options_;
  const Clock& clock_;
  std::unique_ptr<RequestWriter> requests_;
  std::unique_ptr<AnswerReader> answers_;
  std::optional<Lease> lease_;
  TimePoint next_{};
  std::string lost_;
};

}  // namespace dadrl
