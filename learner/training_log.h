// The curves of a training: logs/training.csv and TensorBoard events, a row an interval.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "common/io/row_file.h"
#include "common/util/fault.h"
#include "common/util/result.h"
#include "common/util/time_ledger.h"
#include "learner/tensorboard_writer.h"
#include "learner/trainer.h"

namespace dadrl {

// What a row says beside the training interval itself.
struct LogContext {
  double wall_time_s = 0.0;  // Unix time by the system's clock
  double interval_s = 0.0;   // how long the interval was
  double batch_bytes = 0.0;  // received in the interval
  double replay_frames = 0.0;
  double work_fraction = 0.0;  // of the training thread's time in the interval
};

// Not thread safe. Its times never go back, also when the system's clock was set back. What cannot be opened
// or written is a fault of `faults` and is tried again with the next row: no disk stops a training.
class TrainingLog {
 public:
  // Goes on behind what earlier learners of the run wrote; `updates`: where this one begins; `scalars`: of
  // the intervals' means, a column each. Borrows `scalars` and `faults`.
  TrainingLog(const std::filesystem::path& run_directory, uint64_t updates,
              std::span<const ScalarSpec> scalars, FaultBoard& faults);
  void Add(const TrainingInterval& interval, const LogContext& context);

 private:
  // What is not open yet.
  Status OpenTable();
  Status OpenEvents();
  Status Write(const TrainingInterval& interval, const LogContext& context);

  const std::filesystem::path run_directory_;
  const int64_t first_step_;
  const std::span<const ScalarSpec> scalars_;
  FaultBoard& faults_;
  std::optional<RowFile> table_;
  std::optional<TensorBoardWriter> tensorboard_;
  double wall_time_s_ = 0.0;  // of the last row, earlier sessions' included
};

}  // namespace dadrl
