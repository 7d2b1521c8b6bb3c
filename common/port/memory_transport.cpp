#include "common/port/memory_transport.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "common/port/sample_queue.h"
#include "common/port/sample_type.h"
#include "common/util/mutex.h"

namespace dadrl {

// Who reads and writes what; one lock for all of it.
class MemoryTransport::Medium {
 public:
  struct ReaderEnd {
    TopicSpec topic;
    SampleQueue queue;
    bool woken = false;
  };
  struct WriterEnd {
    TopicSpec topic;
    SampleQueue kept;  // for late readers
    uint64_t generation = 0;
  };

  explicit Medium(ManualClock* clock) : clock_(clock) {}

  void Add(WriterEnd* writer) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    writers_.push_back(writer);
    writer->generation = Readers(writer->topic).size();
  }
  void Add(ReaderEnd* reader) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    readers_.push_back(reader);
    for (WriterEnd* writer : writers_) {
      if (!Match(writer->topic, reader->topic)) continue;
      ++writer->generation;
      for (const SampleQueue::Sample& sample : writer->kept.samples()) reader->queue.Push(sample);
    }
    changed_.NotifyAll();
  }
  void Remove(WriterEnd* writer) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    std::erase(writers_, writer);
  }
  void Remove(ReaderEnd* reader) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    std::erase(readers_, reader);
    changed_.NotifyAll();
  }

  Status Write(WriterEnd& writer, const SampleQueue::Sample& sample) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    const TimePoint end = Now() + std::chrono::milliseconds(writer.topic.max_blocking_ms);
    while (AnyFull(writer.topic)) {
      if (!WaitUntil(end)) return Fail(ErrorCode::kUnavailable, "the reader is full, nothing was sent");
    }
    for (ReaderEnd* reader : Readers(writer.topic)) reader->queue.Push(sample);
    if (writer.topic.transient_local) writer.kept.Push(sample);
    changed_.NotifyAll();
    return {};
  }
  bool Wait(ReaderEnd& reader, Duration timeout) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    const TimePoint end = Now() + timeout;
    while (reader.queue.empty() && !reader.woken && WaitUntil(end)) {
    }
    reader.woken = false;
    return !reader.queue.empty();
  }
  void Wake(ReaderEnd& reader) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    reader.woken = true;
    changed_.NotifyAll();
  }
  // Null when there is none.
  std::shared_ptr<const void> Take(ReaderEnd& reader) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    if (reader.queue.empty()) return nullptr;
    changed_.NotifyAll();
    return reader.queue.Pop().value;
  }

  int CountReaders(const TopicSpec& topic) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return std::ssize(Readers(topic));
  }
  int CountWriters(const TopicSpec& topic) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return std::count_if(writers_.begin(), writers_.end(),
                         [&](const WriterEnd* writer) { return Match(writer->topic, topic); });
  }
  uint64_t GenerationOf(const WriterEnd& writer) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return writer.generation;
  }

 private:
  static bool Match(const TopicSpec& one, const TopicSpec& other) {
    return std::string_view(one.name) == other.name && one.partition == other.partition;
  }
  std::vector<ReaderEnd*> Readers(const TopicSpec& topic) const DADRL_REQUIRES(mutex_) {
    std::vector<ReaderEnd*> matching;
    for (ReaderEnd* reader : readers_) {
      if (Match(reader->topic, topic)) matching.push_back(reader);
    }
    return matching;
  }
  bool AnyFull(const TopicSpec& topic) const DADRL_REQUIRES(mutex_) {
    const std::vector<ReaderEnd*> readers = Readers(topic);
    return std::any_of(readers.begin(), readers.end(),
                       [](const ReaderEnd* reader) { return reader->queue.full(); });
  }
  TimePoint Now() const { return clock_ != nullptr ? clock_->Now() : SystemClock().Now(); }
  // Until something changed; false when it is `end`.
  bool WaitUntil(TimePoint end) DADRL_REQUIRES(mutex_) {
    const Duration left = end - Now();
    if (left <= Duration::zero()) return false;
    if (clock_ != nullptr) {
      clock_->Advance(left);
    } else {
      changed_.WaitFor(mutex_, left);
    }
    return true;
  }

  ManualClock* const clock_;
  Mutex mutex_;
  CondVar changed_;
  std::vector<WriterEnd*> writers_ DADRL_GUARDED_BY(mutex_);
  std::vector<ReaderEnd*> readers_ DADRL_GUARDED_BY(mutex_);
};

class MemoryTransport::MemoryWriter final : public WriterPort {
 public:
  MemoryWriter(Medium& medium, SampleType type, const TopicSpec& topic)
      : medium_(medium), type_(std::move(type)), end_{topic, SampleQueue::OfWriter(topic)} {
    medium_.Add(&end_);
  }
  ~MemoryWriter() override { medium_.Remove(&end_); }

  Status Write(const void* sample) override {
    return medium_.Write(end_, {.value = type_.Copy(sample), .key = type_.Key(sample)});
  }
  int matched() const override { return medium_.CountReaders(end_.topic); }
  uint64_t match_generation() const override { return medium_.GenerationOf(end_); }

 private:
  Medium& medium_;
  const SampleType type_;
  Medium::WriterEnd end_;
};

class MemoryTransport::MemoryReader final : public ReaderPort {
 public:
  MemoryReader(Medium& medium, const TopicSpec& topic)
      : medium_(medium), end_{topic, SampleQueue::OfReader(topic)} {
    medium_.Add(&end_);
  }
  ~MemoryReader() override { medium_.Remove(&end_); }

  int Take(int max, Visit visit, void* context) override {
    int taken = 0;
    for (; taken < max; ++taken) {
      const std::shared_ptr<const void> sample = medium_.Take(end_);
      if (sample == nullptr) break;
      visit(context, sample.get());
    }
    return taken;
  }
  bool Wait(Duration timeout) override { return medium_.Wait(end_, timeout); }
  void Wake() override { medium_.Wake(end_); }
  int matched() const override { return medium_.CountWriters(end_.topic); }

 private:
  Medium& medium_;
  Medium::ReaderEnd end_;
};

MemoryTransport::MemoryTransport() : medium_(std::make_unique<Medium>(nullptr)) {}
MemoryTransport::MemoryTransport(ManualClock& clock) : medium_(std::make_unique<Medium>(&clock)) {}
MemoryTransport::~MemoryTransport() = default;

Result<std::unique_ptr<WriterPort>> MemoryTransport::OpenWriter(const TopicSpec& topic) const {
  DADRL_ASSIGN_OR_RETURN(SampleType type, SampleType::Of(*topic.type));
  return std::make_unique<MemoryWriter>(*medium_, std::move(type), topic);
}

Result<std::unique_ptr<ReaderPort>> MemoryTransport::OpenReader(const TopicSpec& topic) const {
  return std::make_unique<MemoryReader>(*medium_, topic);
}

}  // namespace dadrl
