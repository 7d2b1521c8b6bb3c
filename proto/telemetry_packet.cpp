#include "proto/telemetry_packet.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "common/util/utf8.h"
#include "dadrl_lcm/episode_report.hpp"
#include "dadrl_lcm/process_status.hpp"

namespace dadrl {
namespace {

constexpr int kMetrics = static_cast<int>(Metric::kCount);
constexpr int kActivities = static_cast<int>(Activity::kCount);
static_assert(kMetrics <= 64 && kActivities <= 16, "widen the arrays in telemetry.lcm");

constexpr int kRoles = 4;
constexpr int kOutcomes = 4;

template <typename Message>
std::vector<std::byte> Encode(const Message& message) {
  std::vector<std::byte> packet(static_cast<size_t>(message.getEncodedSize()));
  message.encode(packet.data(), 0, static_cast<int>(packet.size()));
  return packet;
}

// All of our types have one fixed length, so length and fingerprint together leave the decoder nothing to
// trust.
template <typename Message>
Result<Message> Decode(std::span<const std::byte> packet) {
  Message message{};
  const auto expected = static_cast<size_t>(message.getEncodedSize());
  if (packet.size() != expected) {
    return Fail(ErrorCode::kCorrupt, "telemetry packet of {} bytes, not {}", packet.size(), expected);
  }
  int64_t fingerprint = 0;
  __int64_t_decode_array(packet.data(), 0, sizeof(fingerprint), &fingerprint, 1);
  if (fingerprint != Message::getHash()) {
    return Fail(ErrorCode::kCorrupt, "telemetry packet of another type or version");
  }
  if (message.decode(packet.data(), 0, static_cast<int>(packet.size())) < 0) {
    return Fail(ErrorCode::kCorrupt, "telemetry packet cannot be decoded");
  }
  return message;
}

bool AllFinite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

// Printable text up to the first zero, and nothing but zeros behind it.
std::optional<std::string> TextOf(std::span<const uint8_t> bytes) {
  const auto end = std::find(bytes.begin(), bytes.end(), 0);
  std::string text(bytes.begin(), end);
  const bool padded = end != bytes.end() && std::all_of(end, bytes.end(), [](uint8_t c) { return c == 0; });
  if (!padded || !IsPrintableUtf8(text)) return std::nullopt;
  return text;
}

}  // namespace

std::vector<std::byte> EncodePacket(const ProcessStatus& status) {
  dadrl_lcm::process_status message{};
  message.role = static_cast<int32_t>(status.role);
  message.index = status.index;
  message.pid = status.pid;
  message.metric_count = kMetrics;
  message.activity_count = kActivities;
  message.incarnation = std::bit_cast<int64_t>(status.incarnation);
  message.sent_ns = status.sent_ns;
  message.uptime_s = status.uptime_s;
  std::copy(status.metrics.begin(), status.metrics.end(), message.metrics);
  for (int i = 0; i < kActivities; ++i) {
    const TimeSpent& spent = status.activities[static_cast<Activity>(i)];
    message.activity_s[i] = spent.seconds;
    message.activity_begun[i] = std::bit_cast<int64_t>(spent.count);
  }
  return Encode(message);
}

std::vector<std::byte> EncodePacket(const EpisodeReport& report) {
  dadrl_lcm::episode_report message{};
  message.actor = report.actor;
  message.outcome = report.outcome;
  message.steps = report.steps;
  message.policy_version = std::bit_cast<int32_t>(report.policy_version);
  message.incarnation = std::bit_cast<int64_t>(report.incarnation);
  message.episode = std::bit_cast<int64_t>(report.episode);
  message.seed = std::bit_cast<int64_t>(report.seed);
  message.sent_ns = report.sent_ns;
  message.episode_return = report.episode_return;
  message.progress = report.progress;
  message.mean_speed_mps = report.mean_speed_mps;
  message.humanness_error = report.humanness_error;
  message.overall_score = report.overall_score;
  const std::string_view scenario = Utf8Prefix(report.scenario, EpisodeReport::kMaxScenarioName);
  std::copy(scenario.begin(), scenario.end(), message.scenario);
  return Encode(message);
}

Result<ProcessStatus> DecodeStatusPacket(std::span<const std::byte> packet) {
  DADRL_ASSIGN_OR_RETURN(const auto message, Decode<dadrl_lcm::process_status>(packet));
  if (message.metric_count != kMetrics || message.activity_count != kActivities) {
    return Fail(ErrorCode::kCorrupt, "status of another version: {} metrics and {} activities, not {} and {}",
                message.metric_count, message.activity_count, kMetrics, kActivities);
  }
  if (message.role < 0 || message.role >= kRoles || message.index < 0 || !std::isfinite(message.uptime_s) ||
      !AllFinite(message.metrics) || !AllFinite(message.activity_s)) {
    return Fail(ErrorCode::kCorrupt, "status with a value out of range");
  }
  ProcessStatus status;
  status.role = static_cast<dds::Role>(message.role);
  status.index = message.index;
  status.pid = message.pid;
  status.incarnation = std::bit_cast<uint64_t>(message.incarnation);
  status.sent_ns = message.sent_ns;
  status.uptime_s = message.uptime_s;
  std::copy_n(message.metrics, kMetrics, status.metrics.begin());
  for (int i = 0; i < kActivities; ++i) {
    status.activities[static_cast<Activity>(i)] = {std::bit_cast<uint64_t>(message.activity_begun[i]),
                                                   message.activity_s[i]};
  }
  return status;
}

Result<EpisodeReport> DecodeEpisodePacket(std::span<const std::byte> packet) {
  DADRL_ASSIGN_OR_RETURN(const auto message, Decode<dadrl_lcm::episode_report>(packet));
  const double numbers[] = {message.episode_return, message.progress, message.mean_speed_mps,
                            message.humanness_error, message.overall_score};
  if (message.actor < 0 || message.outcome < 0 || message.outcome >= kOutcomes || message.steps < 0 ||
      !AllFinite(numbers)) {
    return Fail(ErrorCode::kCorrupt, "episode report with a value out of range");
  }
  const auto scenario = TextOf(message.scenario);
  if (!scenario) return Fail(ErrorCode::kCorrupt, "episode report whose scenario is not a name");
  EpisodeReport report;
  report.actor = message.actor;
  report.outcome = message.outcome;
  report.steps = message.steps;
  report.policy_version = std::bit_cast<uint32_t>(message.policy_version);
  report.incarnation = std::bit_cast<uint64_t>(message.incarnation);
  report.episode = std::bit_cast<uint64_t>(message.episode);
  report.seed = std::bit_cast<uint64_t>(message.seed);
  report.sent_ns = message.sent_ns;
  report.episode_return = message.episode_return;
  report.progress = message.progress;
  report.mean_speed_mps = message.mean_speed_mps;
  report.humanness_error = message.humanness_error;
  report.overall_score = message.overall_score;
  report.scenario = *scenario;
  return report;
}

}  // namespace dadrl
