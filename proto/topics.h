// The one table of topics: each QoS setting with its reason.
#pragma once

#include "cluster.h"
#include "common/dds/topic.h"

namespace dadrl {

// Experience. KEEP_ALL and a bounded reader: the replay's pace is the actors' pace; nothing is overwritten.
// Volatile: actors resend what is unacknowledged, so DDS need not keep it. One partition a shard: a writer
// that matched several shards would be held up by the slowest, and every shard would receive everything.
inline dds::TopicSpec ChunkTopic(int shard) {
  return {.name = "dadrl/chunk",
          .type = &dadrl_idl_ChunkMessage_desc,
          .plane = dds::Plane::kData,
          .reader_max_samples = 128,
          .max_blocking_ms = 200,
          .partition = shard};
}
// Newest word per actor is all that counts, also for an actor that joins or rejoins: transient local,
// KEEP_LAST 1 per key. A partition for each of a few groups of actors: without multicast a writer sends its
// samples to every reader it matches, and with one group for all, an acknowledgement to one of 200 actors
// would leave 200 times.
constexpr uint32_t kAcknowledgementGroups = 32;
inline dds::TopicSpec AcknowledgementTopic(uint32_t actor) {
  return {.name = "dadrl/acknowledgement",
          .type = &dadrl_idl_Acknowledgement_desc,
          .plane = dds::Plane::kControl,
          .keep_all = false,
          .transient_local = true,
          .partition = static_cast<int>(actor % kAcknowledgementGroups)};
}
// Credits bound what is outstanding; the reader limit is a safety net.
inline const dds::TopicSpec kBatchRequestTopic{.name = "dadrl/batch_request",
                                               .type = &dadrl_idl_BatchRequest_desc,
                                               .plane = dds::Plane::kControl,
                                               .reader_max_samples = 64};
inline const dds::TopicSpec kBatchReplyTopic{.name = "dadrl/batch_reply",
                                             .type = &dadrl_idl_BatchReply_desc,
                                             .plane = dds::Plane::kData,
                                             .reader_max_samples = 16,
                                             .max_blocking_ms = 500};
// Losing some priorities is harmless; holding up training is not: short time-out, dropped when full.
inline const dds::TopicSpec kPriorityTopic{.name = "dadrl/priorities",
                                           .type = &dadrl_idl_PriorityUpdate_desc,
                                           .plane = dds::Plane::kControl,
                                           .reader_max_samples = 64,
                                           .max_blocking_ms = 50};
// What a user's command asks of a shard. Rare and small; repeated until it is answered.
enum class ReplayCommandKind : uint32_t { kLimit = 0, kSnapshot = 1 };
inline const dds::TopicSpec kReplayCommandTopic{.name = "dadrl/replay_command",
                                                .type = &dadrl_idl_ReplayCommand_desc,
                                                .plane = dds::Plane::kControl,
                                                .reader_max_samples = 16};
inline const dds::TopicSpec kReplayAnswerTopic{.name = "dadrl/replay_answer",
                                               .type = &dadrl_idl_ReplayAnswer_desc,
                                               .plane = dds::Plane::kControl,
                                               .reader_max_samples = 64};
// Only the newest policy matters; a late actor gets it at once. KEEP_LAST never blocks the learner.
inline const dds::TopicSpec kWeightsTopic{.name = "dadrl/weights",
                                          .type = &dadrl_idl_Weights_desc,
                                          .plane = dds::Plane::kControl,
                                          .keep_all = false,
                                          .transient_local = true};
// Whoever joins gets it at once, and as often as it likes.
inline const dds::TopicSpec kRunConfigTopic{.name = "dadrl/run_config",
                                            .type = &dadrl_idl_RunConfig_desc,
                                            .plane = dds::Plane::kControl,
                                            .keep_all = false,
                                            .transient_local = true};
// Lossy, as on LCM: cumulative counters, and a reader that is slow must not hold up anyone.
constexpr int kTelemetryDepth = 1024;
inline const dds::TopicSpec kTelemetryTopic{.name = "dadrl/telemetry",
                                            .type = &dadrl_idl_Telemetry_desc,
                                            .plane = dds::Plane::kControl,
                                            .reliable = false,
                                            .keep_all = false,
                                            .depth = kTelemetryDepth};
inline const dds::TopicSpec kRelayedTelemetryTopic{.name = "dadrl/telemetry_relayed",
                                                   .type = &dadrl_idl_Telemetry_desc,
                                                   .plane = dds::Plane::kControl,
                                                   .reliable = false,
                                                   .keep_all = false,
                                                   .depth = kTelemetryDepth};
// Manual liveliness: a beat proves that the work loop runs, not only that the process exists.
inline const dds::TopicSpec kHeartbeatTopic{.name = "dadrl/heartbeat",
                                            .type = &dadrl_idl_Heartbeat_desc,
                                            .plane = dds::Plane::kControl,
                                            .keep_all = false,
                                            .transient_local = true,
                                            .manual_liveliness = true};

}  // namespace dadrl
