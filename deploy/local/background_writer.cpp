#include "deploy/local/background_writer.h"

#include <utility>

namespace dadrl {

BackgroundWriter::BackgroundWriter(Writing writing)
    : writing_(std::move(writing)), thread_([this](bool) {
        WriteNewest();
        return BackgroundThread::kUntilWoken;
      }) {}

void BackgroundWriter::Write(std::string content) {
  {
    MutexLock lock(mutex_);
    waiting_ = std::move(content);
  }
  thread_.Wake();
}

Status BackgroundWriter::last() const {
  MutexLock lock(mutex_);
  return last_;
}

Status BackgroundWriter::Finish() {
  MutexLock lock(mutex_);
  while (waiting_ || busy_) changed_.Wait(mutex_);
  return last_;
}

void BackgroundWriter::WriteNewest() {
  std::string content;
  {
    MutexLock lock(mutex_);
    if (!waiting_) return;
    content = std::move(*waiting_);
    waiting_.reset();
    busy_ = true;
  }
  Status written = writing_(content);
  MutexLock lock(mutex_);
  busy_ = false;
  last_ = std::move(written);
  changed_.NotifyAll();
}

}  // namespace dadrl
