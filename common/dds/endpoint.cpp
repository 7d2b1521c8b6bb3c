// A node's ports: writers and readers of one topic, RAII over the Cyclone DDS C API.
#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>

#include "common/dds/node.h"
#include "common/dds/qos.h"

namespace dadrl::dds {
namespace {

// One take; loans are returned before the next, so this bounds what a visitor can keep from the reader.
constexpr int kTakeAtOnce = 32;

Result<dds_entity_t> Check(dds_entity_t entity, const TopicSpec& topic, const char* what) {
  if (entity > 0) return entity;
  return Fail(ErrorCode::kInternal, "cannot create the {} of topic {}: {}", what, topic.name,
              dds_strretcode(entity));
}

Result<dds_entity_t> CreateTopic(const Node& node, const TopicSpec& topic) {
  const Listener listener = MismatchListener(topic.name);
  return Check(
      dds_create_topic(node.participant(topic.plane), topic.type, topic.name, nullptr, listener.get()), topic,
      "type");
}

void Delete(dds_entity_t entity) {
  if (entity > 0) dds_delete(entity);
}

// Incompatible QoS with a peer is logged with the policy's name.
class DdsWriter final : public WriterPort {
 public:
  ~DdsWriter() override {
    Delete(writer_);
    Delete(topic_);
  }
  Status Open(const Node& node, const TopicSpec& topic);
  Status Write(const void* sample) override;
  int matched() const override;
  uint64_t match_generation() const override;

 private:
  dds_entity_t topic_ = 0;
  dds_entity_t writer_ = 0;
};

// Samples without data (disposals) are skipped.
class DdsReader final : public ReaderPort {
 public:
  ~DdsReader() override;
  Status Open(const Node& node, const TopicSpec& topic);
  int Take(int max, Visit visit, void* context) override;
  bool Wait(Duration timeout) override;
  void Wake() override;
  int matched() const override;

 private:
  dds_entity_t topic_ = 0;
  dds_entity_t reader_ = 0;
  dds_entity_t condition_ = 0;
  dds_entity_t guard_ = 0;
  dds_entity_t waitset_ = 0;
  std::atomic<bool> closing_{false};  // read by Cyclone's receive thread
};

Status DdsWriter::Open(const Node& node, const TopicSpec& topic) {
  DADRL_ASSIGN_OR_RETURN(topic_, CreateTopic(node, topic));
  const Qos qos = WriterQos(topic);
  const Listener listener = MismatchListener(topic.name);
  DADRL_ASSIGN_OR_RETURN(
      writer_, Check(dds_create_writer(node.participant(topic.plane), topic_, qos.get(), listener.get()),
                     topic, "writer"));
  return {};
}

int DdsWriter::matched() const {
  dds_publication_matched_status_t status{};
  dds_get_publication_matched_status(writer_, &status);
  return static_cast<int>(status.current_count);
}

uint64_t DdsWriter::match_generation() const {
  dds_publication_matched_status_t status{};
  dds_get_publication_matched_status(writer_, &status);
  return status.total_count;
}

Status DdsWriter::Write(const void* sample) {
  const dds_return_t result = dds_write(writer_, sample);
  if (result == DDS_RETCODE_OK) return {};
  if (result == DDS_RETCODE_TIMEOUT) {
    return Fail(ErrorCode::kUnavailable, "the reader is full or out of reach, nothing was sent");
  }
  return Fail(ErrorCode::kInternal, "DDS write failed: {}", dds_strretcode(result));
}

DdsReader::~DdsReader() {
  // Cyclone's receive thread waits inside the delivery to a full reader, and deleting the reader waits for
  // that thread: from here on whatever arrives is filtered away instead.
  closing_ = true;
  for (const dds_entity_t entity : {waitset_, condition_, guard_, reader_, topic_}) Delete(entity);
}

Status DdsReader::Open(const Node& node, const TopicSpec& topic) {
  const dds_entity_t participant = node.participant(topic.plane);
  DADRL_ASSIGN_OR_RETURN(topic_, CreateTopic(node, topic));
  dds_topic_filter filter{};
  filter.mode = DDS_TOPIC_FILTER_SAMPLEINFO_ARG;
  filter.f.sampleinfo_arg = [](const dds_sample_info_t*, void* closing) {
    return !static_cast<const std::atomic<bool>*>(closing)->load(std::memory_order_relaxed);
  };
  filter.arg = &closing_;
  const dds_return_t filtered = dds_set_topic_filter_extended(topic_, &filter);
  if (filtered != DDS_RETCODE_OK) {
    return Fail(ErrorCode::kInternal, "cannot filter topic {}: {}", topic.name, dds_strretcode(filtered));
  }
  const Qos qos = ReaderQos(topic);
  const Listener listener = MismatchListener(topic.name);
  DADRL_ASSIGN_OR_RETURN(
      reader_, Check(dds_create_reader(participant, topic_, qos.get(), listener.get()), topic, "reader"));
  DADRL_ASSIGN_OR_RETURN(condition_,
                         Check(dds_create_readcondition(reader_, DDS_ANY_STATE), topic, "read condition"));
  DADRL_ASSIGN_OR_RETURN(guard_, Check(dds_create_guardcondition(participant), topic, "guard condition"));
  DADRL_ASSIGN_OR_RETURN(waitset_, Check(dds_create_waitset(participant), topic, "wait set"));
  for (const dds_entity_t condition : {condition_, guard_}) {
    const dds_return_t attached = dds_waitset_attach(waitset_, condition, condition);
    if (attached != DDS_RETCODE_OK) {
      return Fail(ErrorCode::kInternal, "cannot wait on topic {}: {}", topic.name, dds_strretcode(attached));
    }
  }
  return {};
}

int DdsReader::matched() const {
  dds_subscription_matched_status_t status{};
  dds_get_subscription_matched_status(reader_, &status);
  return static_cast<int>(status.current_count);
}

bool DdsReader::Wait(Duration timeout) {
  std::array<dds_attach_t, 2> triggered{};
  const dds_return_t count =
      dds_waitset_wait(waitset_, triggered.data(), triggered.size(), std::max<int64_t>(timeout.count(), 0));
  bool woken = false;
  dds_take_guardcondition(guard_, &woken);
  const auto end = triggered.begin() + std::clamp<int>(count, 0, std::ssize(triggered));
  return std::find(triggered.begin(), end, condition_) != end;
}

void DdsReader::Wake() { dds_set_guardcondition(guard_, true); }

int DdsReader::Take(int max, Visit visit, void* context) {
  int visited = 0;
  while (visited < max) {
    std::array<void*, kTakeAtOnce> samples{};  // null: loans from the reader
    std::array<dds_sample_info_t, kTakeAtOnce> infos{};
    const int room = std::min(max - visited, kTakeAtOnce);
    const int taken = dds_take(reader_, samples.data(), infos.data(), static_cast<size_t>(room),
                               static_cast<uint32_t>(room));
    if (taken <= 0) break;
    struct Loan {
      dds_entity_t reader;
      void** samples;
      int count;
      ~Loan() { dds_return_loan(reader, samples, count); }
    } const loan{reader_, samples.data(), taken};
    for (size_t i = 0; i < static_cast<size_t>(taken); ++i) {
      if (!infos[i].valid_data) continue;
      visit(context, samples[i]);
      ++visited;
    }
  }
  return visited;
}

}  // namespace

Result<std::unique_ptr<WriterPort>> Node::OpenWriter(const TopicSpec& topic) const {
  auto writer = std::make_unique<DdsWriter>();
  DADRL_RETURN_IF_ERROR(writer->Open(*this, topic));
  return writer;
}

Result<std::unique_ptr<ReaderPort>> Node::OpenReader(const TopicSpec& topic) const {
  auto reader = std::make_unique<DdsReader>();
  DADRL_RETURN_IF_ERROR(reader->Open(*this, topic));
  return reader;
}

}  // namespace dadrl::dds
