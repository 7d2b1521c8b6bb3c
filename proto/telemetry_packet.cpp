#include "proto/telemetry_packet.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "common/util/utf8.h"
#include "dadrl_lcm/episode_report.hpp"
#include "dadrl_lcm/process_status.hpp"

namespace dadrl {
namespace {

constexpr int kMetrics = decltype(ProcessStatus::metrics)().size();
constexpr int kActivities = ActivityTotals().size();
static_assert(kMetrics <= 48 && kActivities <= 16, "widen the arrays in telemetry.lcm");

constexpr int kOutcomes = 4;

static_assert(ProcessStatus::kMaxFaults == std::extent_v<decltype(dadrl_lcm::process_status::fault_kind)> &&
              ProcessStatus::kMaxFaultText + 1 == sizeof(dadrl_lcm::process_status::fault_text[0]));

template <typename Message>
std::vector<std::byte> Encode(const Message& message) {
  std::vector<std::byte> packet(static_cast<size_t>(message.getEncodedSize()));
  message.encode(packet.data(), 0, packet.size());
  return packet;
}

// All of our types have one fixed length, so length and fingerprint together leave the decoder nothing to
// trust.
template <typename Message>
Result<Message> Decode(std::span<const std::byte> packet) {
  Message message{};
  const int expected = message.getEncodedSize();
  if (std::cmp_not_equal(packet.size(), expected)) {
    return Fail(ErrorCode::kCorrupt, "telemetry packet of {} bytes, not {}", packet.size(), expected);
  }
  int64_t fingerprint = 0;
  __int64_t_decode_array(packet.data(), 0, sizeof(fingerprint), &fingerprint, 1);
  if (fingerprint != Message::getHash()) {
    return Fail(ErrorCode::kCorrupt, "telemetry packet of another type or version");
  }
  if (message.decode(packet.data(), 0, packet.size()) < 0) {
    return Fail(ErrorCode::kCorrupt, "telemetry packet cannot be decoded");
  }
  return message;
}

// What no count of bytes, steps or seconds of one run reaches, and what a double still counts one by one.
constexpr double kMost = 1e15;
constexpr int64_t kMostBegun = int64_t{1} << 50;
constexpr int kMostPids = 1 << 22;  // Linux's
constexpr double kLargestReturn = 1e9;

// False for NaN.
bool IsBetween(double least, double value, double most) { return least <= value && value <= most; }

// An age is a difference of two machines' clocks.
bool MayBeNegative(Metric metric) {
  return metric == Metric::kPolicyAgeS ||
         (metric >= Metric::kStalenessVersionsMean && metric <= Metric::kCheckpointAgeS);
}

bool IsPossible(const dadrl_lcm::process_status& message) {
  for (size_t i = 0; i < kMetrics; ++i) {
    const double least = MayBeNegative(decltype(ProcessStatus::metrics)::At(i)) ? -kMost : 0.0;
    if (!IsBetween(least, message.metrics[i], kMost)) return false;
  }
  for (int i = 0; i < kActivities; ++i) {
    if (!IsBetween(0.0, message.activity_s[i], kMost)) return false;
    if (message.activity_begun[i] < 0 || message.activity_begun[i] > kMostBegun) return false;
  }
  return IsBetween(0.0, message.uptime_s, kMost) && message.pid >= 0 && message.pid <= kMostPids;
}

// Losses and values have either sign.
bool IsPossible(const NamedScalar& scalar) {
  return IsScalarName(scalar.name) && IsBetween(-kMost, scalar.value, kMost);
}

// Whether a process of `role` can have the number `index`.
bool IsProcess(int role, int index) {
  switch (static_cast<dds::Role>(role)) {
    case dds::Role::kReplay:
      return index >= 0 && index < dds::kMaxShards;
    case dds::Role::kActor:
      return index >= 0 && index <= kMaxActorNumber;
    case dds::Role::kLearner:
    case dds::Role::kMonitor:
      return index == 0;
    default:
      return false;
  }
}

bool IsPossible(const dadrl_lcm::episode_report& message) {
  return message.outcome >= 0 && message.outcome < kOutcomes &&
         IsBetween(-kLargestReturn, message.episode_return, kLargestReturn);
}

// Printable text up to the first zero, and nothing but zeros behind it.
std::optional<std::string> TextOf(std::span<const uint8_t> bytes) {
  const auto end = std::find(bytes.begin(), bytes.end(), 0);
  std::string text(bytes.begin(), end);
  const bool padded = end != bytes.end() && std::all_of(end, bytes.end(), [](uint8_t c) { return c == 0; });
  if (!padded || !IsPrintableUtf8(text)) return std::nullopt;
  return text;
}

void PutFaults(const std::vector<Fault>& faults, dadrl_lcm::process_status& message) {
  const size_t count = std::min(faults.size(), ProcessStatus::kMaxFaults);
  message.fault_count = count;
  for (size_t i = 0; i < count; ++i) {
    message.fault_kind[i] = static_cast<int32_t>(faults[i].kind);
    message.fault_s[i] = faults[i].since_s;
    std::string text(Utf8Prefix(faults[i].text, ProcessStatus::kMaxFaultText));
    // A path may hold anything.
    if (!IsPrintableUtf8(text)) {
      std::ranges::replace_if(
          text, [](char c) { return c < ' ' || c > '~'; }, '?');
    }
    std::ranges::copy(text, message.fault_text[i]);
  }
}

// Nothing when one of them cannot be.
std::optional<std::vector<Fault>> FaultsOf(const dadrl_lcm::process_status& message) {
  if (message.fault_count < 0 || std::cmp_greater(message.fault_count, ProcessStatus::kMaxFaults)) {
    return std::nullopt;
  }
  std::vector<Fault> faults(static_cast<size_t>(message.fault_count));
  for (size_t i = 0; i < faults.size(); ++i) {
    const auto kind = static_cast<FaultKind>(message.fault_kind[i]);
    const auto text = TextOf(message.fault_text[i]);
    const bool lasts = IsBetween(0.0, message.fault_s[i], kMost);
    if (kind < FaultKind{} || kind >= FaultKind::kCount || !text || !lasts) return std::nullopt;
    faults[i] = {kind, *text, message.fault_s[i]};
  }
  return faults;
}

void PutScalars(std::span<const NamedScalar> scalars, dadrl_lcm::process_status& message) {
  static_assert(std::extent_v<decltype(message.scalars)> == kMaxScalars &&
                std::extent_v<decltype(message.scalar_names), 1> == kMaxScalarName + 1);
  for (const NamedScalar& scalar : scalars) {
    if (message.scalar_count == kMaxScalars) break;
    if (!IsPossible(scalar)) continue;
    std::ranges::copy(scalar.name, message.scalar_names[message.scalar_count]);
    message.scalars[message.scalar_count++] = scalar.value;
  }
}

// Nothing when one has no name or a value that cannot be, or a name comes twice.
std::optional<std::vector<NamedScalar>> ScalarsOf(const dadrl_lcm::process_status& message) {
  if (message.scalar_count < 0 || message.scalar_count > kMaxScalars) return std::nullopt;
  std::vector<NamedScalar> scalars;
  for (int i = 0; i < message.scalar_count; ++i) {
    NamedScalar scalar{TextOf(message.scalar_names[i]).value_or(""), message.scalars[i]};
    const bool is_new = std::ranges::find(scalars, scalar.name, &NamedScalar::name) == scalars.end();
    if (!is_new || !IsPossible(scalar)) return std::nullopt;
    scalars.push_back(std::move(scalar));
  }
  return scalars;
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
  for (size_t i = 0; i < kActivities; ++i) {
    const TimeSpent& spent = status.activities[i];
    message.activity_s[i] = spent.seconds;
    message.activity_begun[i] = std::bit_cast<int64_t>(spent.count);
  }
  PutFaults(status.faults, message);
  PutScalars(status.scalars, message);
  return Encode(message);
}

std::vector<std::byte> EncodePacket(const EpisodeReport& report) {
  dadrl_lcm::episode_report message{};
  message.outcome = report.outcome;
  message.episode_return = report.episode_return;
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
  if (!IsProcess(message.role, message.index)) {
    return Fail(ErrorCode::kCorrupt, "status of a process that cannot be: role {}, number {}", message.role,
                message.index);
  }
  if (!IsPossible(message)) return Fail(ErrorCode::kCorrupt, "status with a value out of range");
  auto faults = FaultsOf(message);
  if (!faults) return Fail(ErrorCode::kCorrupt, "status with a fault that cannot be");
  auto scalars = ScalarsOf(message);
  if (!scalars) return Fail(ErrorCode::kCorrupt, "status with a scalar that cannot be");
  ProcessStatus status;
  status.scalars = std::move(*scalars);
  status.role = static_cast<dds::Role>(message.role);
  status.index = message.index;
  status.pid = message.pid;
  status.incarnation = std::bit_cast<uint64_t>(message.incarnation);
  status.sent_ns = message.sent_ns;
  status.uptime_s = message.uptime_s;
  std::copy_n(message.metrics, kMetrics, status.metrics.begin());
  for (size_t i = 0; i < kActivities; ++i) {
    status.activities[i] = {std::bit_cast<uint64_t>(message.activity_begun[i]), message.activity_s[i]};
  }
  status.faults = std::move(*faults);
  return status;
}

Result<EpisodeReport> DecodeEpisodePacket(std::span<const std::byte> packet) {
  DADRL_ASSIGN_OR_RETURN(const auto message, Decode<dadrl_lcm::episode_report>(packet));
  if (!IsPossible(message)) return Fail(ErrorCode::kCorrupt, "episode report with a value out of range");
  const auto scenario = TextOf(message.scenario);
  if (!scenario) return Fail(ErrorCode::kCorrupt, "episode report whose scenario is not a name");
  EpisodeReport report;
  report.outcome = message.outcome;
  report.episode_return = message.episode_return;
  report.scenario = *scenario;
  return report;
}

}  // namespace dadrl
