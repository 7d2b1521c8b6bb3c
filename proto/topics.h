// The one table of topics: each QoS setting with its reason.
#pragma once

#include "cluster.h"
#include "common/port/topic.h"
#include "proto/lease.h"

namespace dadrl {

// Of everything that the processes of a cluster say to each other. Grows with every change that another build
// would misunderstand; a process of another version is refused with both versions named.
constexpr uint32_t kProtocolVersion = 4;

// Experience. KEEP_ALL and a bounded reader: the replay's pace is the actors' pace; nothing is overwritten.
// Alone in its plane: whatever keeps the replay from storing (a slow or full disk) leaves this reader full,
// and nothing else may wait for that. Volatile: actors resend what is unacknowledged, so DDS need not keep
// it. One partition a shard: a writer that matched several shards would be held up by the slowest, and every
// shard would receive everything.
constexpr int kChunkReaderSamples = 128;
inline TopicSpec ChunkTopic(int shard) {
  return {.name = "dadrl/chunk",
          .type = &dadrl_idl_ChunkMessage_desc,
          .plane = Plane::kExperience,
          .reader_max_samples = kChunkReaderSamples,
          .max_blocking_ms = 200,
          .partition = shard};
}
// Newest word per actor is all that counts, also for an actor that joins or rejoins: transient local,
// KEEP_LAST 1 per key. A partition for each of a few groups of actors: without multicast a writer sends its
// samples to every reader it matches, and with one group for all, an acknowledgement to one of 200 actors
// would leave 200 times.
constexpr uint32_t kAcknowledgementGroups = 32;
inline TopicSpec AcknowledgementTopic(uint32_t actor) {
  return {.name = "dadrl/acknowledgement",
          .type = &dadrl_idl_Acknowledgement_desc,
          .plane = Plane::kControl,
          .keep_all = false,
          .transient_local = true,
          .partition = static_cast<int>(actor % kAcknowledgementGroups)};
}
// A request that is not answered is sent again, so the newest are enough: a replay that was stopped for a
// while finds those that still matter.
inline const TopicSpec kBatchRequestTopic{.name = "dadrl/batch_request",
                                          .type = &dadrl_idl_BatchRequest_desc,
                                          .plane = Plane::kControl,
                                          .reader_keeps_last = 64};
inline const TopicSpec kBatchReplyTopic{.name = "dadrl/batch_reply",
                                        .type = &dadrl_idl_BatchReply_desc,
                                        .plane = Plane::kBatches,
                                        .reader_max_samples = 16,
                                        .max_blocking_ms = 500};
// Losing some priorities is harmless; holding up training is not: short time-out, the newest are kept.
inline const TopicSpec kPriorityTopic{.name = "dadrl/priorities",
                                      .type = &dadrl_idl_PriorityUpdate_desc,
                                      .plane = Plane::kControl,
                                      .reader_keeps_last = 64,
                                      .max_blocking_ms = 50};
// What a user's command asks of a shard. Rare and small; repeated until it is answered.
enum class ReplayCommandKind : uint32_t { kLimit = 0, kSnapshot = 1 };
inline const TopicSpec kReplayCommandTopic{.name = "dadrl/replay_command",
                                           .type = &dadrl_idl_ReplayCommand_desc,
                                           .plane = Plane::kControl,
                                           .reader_keeps_last = 16};
inline const TopicSpec kReplayAnswerTopic{.name = "dadrl/replay_answer",
                                          .type = &dadrl_idl_ReplayAnswer_desc,
                                          .plane = Plane::kControl,
                                          .reader_keeps_last = 64};
// Only the newest policy matters; a late actor gets it at once. KEEP_LAST never blocks the learner.
inline const TopicSpec kWeightsTopic{.name = "dadrl/weights",
                                     .type = &dadrl_idl_Weights_desc,
                                     .plane = Plane::kControl,
                                     .keep_all = false,
                                     .transient_local = true};
// Whoever joins gets it at once, and as often as it likes.
inline const TopicSpec kRunConfigTopic{.name = "dadrl/run_config",
                                       .type = &dadrl_idl_RunConfig_desc,
                                       .plane = Plane::kControl,
                                       .keep_all = false,
                                       .transient_local = true};
// A replay that ends as it was asked to says so, also to whoever finds it only then.
inline const TopicSpec kRunStateTopic{.name = "dadrl/run_state",
                                      .type = &dadrl_idl_RunState_desc,
                                      .plane = Plane::kControl,
                                      .keep_all = false,
                                      .transient_local = true};
// Repeated until it is answered, and again and again while the actor lives: the newest of each actor is
// enough.
inline const TopicSpec kLeaseRequestTopic{.name = "dadrl/lease_request",
                                          .type = &dadrl_idl_LeaseRequest_desc,
                                          .plane = Plane::kControl,
                                          .keep_all = false};
// Groups as of acknowledgements, by token.
inline TopicSpec LeaseAnswerTopic(const LeaseToken& token) {
  return {.name = "dadrl/lease_answer",
          .type = &dadrl_idl_LeaseAnswer_desc,
          .plane = Plane::kControl,
          .keep_all = false,
          .partition = static_cast<int>(token.low % kAcknowledgementGroups)};
}
// Lossy, as on LCM: cumulative counters, and a reader that is slow must not hold up anyone.
constexpr int kTelemetryDepth = 1024;
inline const TopicSpec kTelemetryTopic{.name = "dadrl/telemetry",
                                       .type = &dadrl_idl_Telemetry_desc,
                                       .plane = Plane::kControl,
                                       .reliable = false,
                                       .keep_all = false,
                                       .depth = kTelemetryDepth};
inline const TopicSpec kRelayedTelemetryTopic{.name = "dadrl/telemetry_relayed",
                                              .type = &dadrl_idl_Telemetry_desc,
                                              .plane = Plane::kControl,
                                              .reliable = false,
                                              .keep_all = false,
                                              .depth = kTelemetryDepth};

}  // namespace dadrl
