// The curves of a training: logs/training.csv and TensorBoard events, a row an interval.
#pragma once

#include <filesystem>

#include "common/util/result.h"
#include "common/util/time_ledger.h"
#include "learner/csv_log.h"
#include "learner/tensorboard_writer.h"
#include "learner/trainer.h"

namespace dadrl {

// What a row says beside the training interval itself.
struct LogContext {
  double wall_time_s = 0.0;  // Unix time
  double interval_s = 0.0;   // how long the interval was
  double batch_bytes = 0.0;  // received in the interval
  double replay_frames = 0.0;
  double work_fraction = 0.0;  // of the training thread's time in the interval
};

// Not thread safe. A write that fails is logged once and tried again with the next row: a full disk does not
// stop a training.
class TrainingLog {
 public:
  static Result<TrainingLog> Open(const std::filesystem::path& run_directory);
  void Add(const TrainingInterval& interval, const LogContext& context);

 private:
  TrainingLog(CsvLog csv, TensorBoardWriter tensorboard)
      : csv_(std::move(csv)), tensorboard_(std::move(tensorboard)) {}

  CsvLog csv_;
  TensorBoardWriter tensorboard_;
  bool failing_ = false;
};

}  // namespace dadrl
