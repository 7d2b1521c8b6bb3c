#include "common/dds/qos.h"

#include <array>
#include <string>

#include "common/util/log.h"

namespace dadrl::dds {
namespace {

Qos CommonQos(const TopicSpec& topic) {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), topic.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(topic.max_blocking_ms));
  dds_qset_history(qos.get(), topic.keep_all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST, topic.depth);
  if (topic.transient_local) dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  if (topic.partition >= 0) {
    const std::string name = fmt::format("{}", topic.partition);
    dds_qset_partition1(qos.get(), name.c_str());
  }
  return qos;
}

const char* PolicyName(uint32_t id) {
  switch (id) {
    case DDS_DURABILITY_QOS_POLICY_ID:
      return "durability";
    case DDS_PRESENTATION_QOS_POLICY_ID:
      return "presentation";
    case DDS_DEADLINE_QOS_POLICY_ID:
      return "deadline";
    case DDS_LATENCYBUDGET_QOS_POLICY_ID:
      return "latency budget";
    case DDS_OWNERSHIP_QOS_POLICY_ID:
      return "ownership";
    case DDS_LIVELINESS_QOS_POLICY_ID:
      return "liveliness";
    case DDS_RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    case DDS_DESTINATIONORDER_QOS_POLICY_ID:
      return "destination order";
    case DDS_TYPE_CONSISTENCY_ENFORCEMENT_QOS_POLICY_ID:
      return "type consistency";
    case DDS_DATA_REPRESENTATION_QOS_POLICY_ID:
      return "data representation";
    default:
      return "unknown";
  }
}

void LogIncompatibleQos(const void* topic_name, uint32_t policy) {
  if (policy == DDS_PARTITION_QOS_POLICY_ID) return;  // another shard's: meant to differ
  spdlog::error(
      "topic {}: a peer's {} QoS (policy {}) does not fit ours: nothing flows between us; do all "
      "processes run the same version and configuration?",
      static_cast<const char*>(topic_name), PolicyName(policy), policy);
}

}  // namespace

Qos WriterQos(const TopicSpec& topic) {
  Qos qos = CommonQos(topic);
  // What a transient-local writer keeps for late readers.
  if (topic.transient_local) {
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, topic.depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  // A leaving writer says nothing about its instances: an actor's end is no statement about its data.
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

Qos ReaderQos(const TopicSpec& topic) {
  Qos qos = CommonQos(topic);
  if (topic.reader_keeps_last > 0) {
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, topic.reader_keeps_last);
  } else if (topic.keep_all && topic.reader_max_samples > 0) {
    dds_qset_resource_limits(qos.get(), topic.reader_max_samples, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  return qos;
}

Listener MismatchListener(const char* topic_name) {
  void* const name = const_cast<char*>(topic_name);  // handed back as const
  Listener listener(dds_create_listener(nullptr));
  dds_lset_inconsistent_topic_arg(
      listener.get(),
      [](dds_entity_t, dds_inconsistent_topic_status_t, void* context) {
        spdlog::error(
            "topic {}: a peer uses another type under this name: nothing flows between us; do all "
            "processes run the same version?",
            static_cast<const char*>(context));
      },
      name, true);
  dds_lset_offered_incompatible_qos_arg(
      listener.get(),
      [](dds_entity_t, dds_offered_incompatible_qos_status_t status, void* context) {
        LogIncompatibleQos(context, status.last_policy_id);
      },
      name, true);
  dds_lset_requested_incompatible_qos_arg(
      listener.get(),
      [](dds_entity_t, dds_requested_incompatible_qos_status_t status, void* context) {
        LogIncompatibleQos(context, status.last_policy_id);
      },
      name, true);
  return listener;
}

}  // namespace dadrl::dds
