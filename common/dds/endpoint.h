// Writers and readers of one topic, RAII over the Cyclone DDS C API.
#pragma once

#include <dds/dds.h>

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "common/dds/topic.h"
#include "common/util/clock.h"
#include "common/util/result.h"

namespace dadrl::dds {

// Any thread may use a Writer. Incompatible QoS with a peer is logged with the policy's name.
class WriterBase {
 public:
  WriterBase(const WriterBase&) = delete;
  WriterBase& operator=(const WriterBase&) = delete;

  // Readers matched now. A write with none is lost: hold the data instead.
  int matched() const;
  // Grows whenever a reader appears; lets a sender notice a replaced peer.
  uint64_t match_generation() const;

 protected:
  WriterBase() = default;
  ~WriterBase();
  Status Open(const Node& node, const TopicSpec& topic);
  // kUnavailable: the time-out of the topic passed, nothing was sent, try again. Blocks at most that long.
  Status WriteSample(const void* sample);

 private:
  dds_entity_t topic_ = 0;
  dds_entity_t writer_ = 0;
};

template <typename Sample>
class Writer final : public WriterBase {
 public:
  static Result<std::unique_ptr<Writer>> Create(const Node& node, const TopicSpec& topic) {
    std::unique_ptr<Writer> writer(new Writer);
    DADRL_RETURN_IF_ERROR(writer->Open(node, topic));
    return writer;
  }
  // Serialises `sample` before it returns; sequences in it may borrow the caller's memory (_release = false).
  Status Write(const Sample& sample) { return WriteSample(&sample); }
};

// One thread at a time uses a Reader; Wake may be called from any.
class ReaderBase {
 public:
  ReaderBase(const ReaderBase&) = delete;
  ReaderBase& operator=(const ReaderBase&) = delete;

  int matched() const;
  // Blocks until a sample can be taken, Wake, or the time-out; true when there is a sample.
  bool Wait(Duration timeout);
  // Ends a Wait at once.
  void Wake();

 protected:
  ReaderBase() = default;
  ~ReaderBase();
  Status Open(const Node& node, const TopicSpec& topic);
  // Calls `visit(context, sample)` for up to `max` samples, which are lent for the call. Returns how many.
  int TakeSamples(int max, void (*visit)(void* context, const void* sample), void* context);

 private:
  dds_entity_t topic_ = 0;
  dds_entity_t reader_ = 0;
  dds_entity_t condition_ = 0;
  dds_entity_t guard_ = 0;
  dds_entity_t waitset_ = 0;
  std::atomic<bool> closing_{false};  // read by Cyclone's receive thread
};

template <typename Sample>
class Reader final : public ReaderBase {
 public:
  static Result<std::unique_ptr<Reader>> Create(const Node& node, const TopicSpec& topic) {
    std::unique_ptr<Reader> reader(new Reader);
    DADRL_RETURN_IF_ERROR(reader->Open(node, topic));
    return reader;
  }
  // Calls `visit(const Sample&)` for up to `max` samples that are here now; never blocks. Returns how many.
  // Samples without data (disposals) are skipped.
  template <typename Visit>
  int Take(int max, Visit&& visit) {
    auto call = [&visit](const void* sample) { std::invoke(visit, *static_cast<const Sample*>(sample)); };
    return TakeSamples(
        max, [](void* context, const void* sample) { (*static_cast<decltype(call)*>(context))(sample); },
        &call);
  }
};

}  // namespace dadrl::dds
