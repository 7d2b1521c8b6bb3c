// From a TopicSpec to Cyclone DDS's QoS and listeners.
#pragma once

#include <dds/dds.h>

#include <memory>

#include "common/port/topic.h"

namespace dadrl::dds {

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

struct ListenerDeleter {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using Listener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

Qos WriterQos(const TopicSpec& topic);
Qos ReaderQos(const TopicSpec& topic);

// Logs what DDS would otherwise keep to itself: peers of another type or with incompatible QoS never match,
// and nothing says so. `topic_name` must have static storage.
Listener MismatchListener(const char* topic_name);

}  // namespace dadrl::dds
