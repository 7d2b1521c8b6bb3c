// How the parts of a cluster speak to each other: writers and readers of topics, over a transport. Two
// bodies: Cyclone DDS between processes (common/dds/node.h), and memory within one (memory_transport.h).
#pragma once

#include <cassert>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "common/port/topic.h"
#include "common/util/clock.h"
#include "common/util/result.h"

namespace dadrl {

// A transport's end of a Writer, without the type.
class WriterPort {
 public:
  virtual ~WriterPort() = default;
  virtual Status Write(const void* sample) = 0;
  virtual int matched() const = 0;
  virtual uint64_t match_generation() const = 0;
};

// A transport's end of a Reader, without the type.
class ReaderPort {
 public:
  using Visit = void (*)(void* context, const void* sample);
  virtual ~ReaderPort() = default;
  virtual int Take(int max, Visit visit, void* context) = 0;
  virtual bool Wait(Duration timeout) = 0;
  virtual void Wake() = 0;
  virtual int matched() const = 0;
};

// Where ports are opened. Any thread; outlives its ports. Readers and writers of a topic find each other
// whichever comes first; how soon, each transport says. An error says what could not be made, and is final.
class Transport {
 public:
  virtual ~Transport() = default;
  virtual Result<std::unique_ptr<WriterPort>> OpenWriter(const TopicSpec& topic) const = 0;
  virtual Result<std::unique_ptr<ReaderPort>> OpenReader(const TopicSpec& topic) const = 0;
};

// Sends samples of one topic. Any thread may use it.
template <typename Sample>
class Writer {
 public:
  static Result<std::unique_ptr<Writer>> Create(const Transport& transport, const TopicSpec& topic) {
    assert(topic.type->m_size == sizeof(Sample));
    DADRL_ASSIGN_OR_RETURN(auto port, transport.OpenWriter(topic));
    return std::unique_ptr<Writer>(new Writer(std::move(port)));
  }

  // `sample` is copied before it returns; sequences in it may borrow the caller's memory (_release = false).
  // kUnavailable: a reader of a KEEP_ALL topic was full, or out of reach, for the topic's max_blocking_ms;
  // nothing was sent, try again. Blocks at most that long. Without a reader the sample is lost, but for what
  // a transient-local topic keeps.
  Status Write(const Sample& sample) { return port_->Write(&sample); }
  // Readers matched now. A write with none is lost: hold the data instead.
  int matched() const { return port_->matched(); }
  // Grows whenever a reader appears; lets a sender notice a replaced peer.
  uint64_t match_generation() const { return port_->match_generation(); }

 private:
  explicit Writer(std::unique_ptr<WriterPort> port) : port_(std::move(port)) {}
  const std::unique_ptr<WriterPort> port_;
};

// Receives samples of one topic. One thread at a time uses it; Wake may be called from any.
template <typename Sample>
class Reader {
 public:
  static Result<std::unique_ptr<Reader>> Create(const Transport& transport, const TopicSpec& topic) {
    assert(topic.type->m_size == sizeof(Sample));
    DADRL_ASSIGN_OR_RETURN(auto port, transport.OpenReader(topic));
    return std::unique_ptr<Reader>(new Reader(std::move(port)));
  }

  // Calls `visit(const Sample&)` for up to `max` samples that are here now, in the order in which each writer
  // sent them; never blocks. Returns how many. A sample, and what its sequences point at, is lent for the
  // call: no copy is made of it.
  template <typename Visit>
  int Take(int max, Visit&& visit) {
    auto call = [&visit](const void* sample) { std::invoke(visit, *static_cast<const Sample*>(sample)); };
    return port_->Take(
        max, [](void* context, const void* sample) { (*static_cast<decltype(call)*>(context))(sample); },
        &call);
  }
  // Blocks until a sample can be taken, Wake, or the time-out; true when there is a sample.
  bool Wait(Duration timeout) { return port_->Wait(timeout); }
  // Ends a Wait at once: the present one, or else the next.
  void Wake() { port_->Wake(); }
  // Writers matched now.
  int matched() const { return port_->matched(); }

 private:
  explicit Reader(std::unique_ptr<ReaderPort> port) : port_(std::move(port)) {}
  const std::unique_ptr<ReaderPort> port_;
};

}  // namespace dadrl
