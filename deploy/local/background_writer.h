// A file that is written again and again without holding up its owner, however slow the disk is.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "common/util/background_thread.h"
#include "common/util/mutex.h"
#include "common/util/result.h"

namespace dadrl {

// Owns a thread. Thread safe.
class BackgroundWriter {
 public:
  // Writes `content` to the disk, which may take its time.
  using Writing = std::function<Status(const std::string& content)>;

  explicit BackgroundWriter(Writing writing);
  // Finishes what was asked for.
  ~BackgroundWriter() = default;
  BackgroundWriter(const BackgroundWriter&) = delete;
  BackgroundWriter& operator=(const BackgroundWriter&) = delete;

  // Has `content` written soon; of several that wait the newest counts. Never blocks.
  void Write(std::string content) DADRL_EXCLUDES(mutex_);
  // How the last attempt ended; success before the first.
  Status last() const DADRL_EXCLUDES(mutex_);
  // Waits until nothing is waiting or under way; then as last().
  Status Finish() DADRL_EXCLUDES(mutex_);

 private:
  void WriteNewest() DADRL_EXCLUDES(mutex_);

  const Writing writing_;
  mutable Mutex mutex_;
  CondVar changed_;
  std::optional<std::string> waiting_ DADRL_GUARDED_BY(mutex_);
  bool busy_ DADRL_GUARDED_BY(mutex_) = false;
  Status last_ DADRL_GUARDED_BY(mutex_);
  BackgroundThread thread_;
};

}  // namespace dadrl
