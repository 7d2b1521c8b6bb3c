// What a topic is: name, type, plane and the few QoS settings this system varies. The table itself is
// proto/topics.h.
#pragma once

#include <dds/dds.h>

namespace dadrl {

// What shares a reader's fate when it is full: experience to the replay, batches from it, and all the small
// rest.
enum class Plane { kExperience, kControl, kBatches };

struct TopicSpec {
  const char* name;
  const dds_topic_descriptor_t* type;
  Plane plane;
  bool reliable = true;
  bool keep_all = true;  // else KEEP_LAST of `depth`
  int depth = 1;
  bool transient_local = false;  // a late reader gets the newest
  // Of a KEEP_ALL topic's reader: the transport's backpressure, which holds up all that its process receives
  // in the same plane; 0: unlimited.
  int reader_max_samples = 0;
  // Instead of it: the reader keeps the newest so many of each key and lets go of older ones that were not
  // taken, so that it is never full. For what its sender repeats or can do without.
  int reader_keeps_last = 0;
  int max_blocking_ms = 100;  // of a reliable write
  int partition = -1;         // only endpoints of the same partition match; -1: the default one
};

}  // namespace dadrl
