// A packet of telemetry, as LCM and the relay of replay shard 0 get it: one byte says of which kind.
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/util/utf8.h"
#include "proto/telemetry_packet.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

enum Kind : uint8_t { kStatus, kEpisode };

Bytes Input(Kind kind, const std::vector<std::byte>& packet) {
  Bytes input{std::byte{kind}};
  input.insert(input.end(), packet.begin(), packet.end());
  return input;
}

// What a monitor relies on; it adds them up.
bool CheckStatus(std::span<const std::byte> packet) {
  const auto status = DecodeStatusPacket(packet);
  if (!status) return false;
  Require(status->index >= 0 && status->index <= kMaxActorNumber);
  Require(std::isfinite(8192 * status->uptime_s) && status->uptime_s >= 0.0);
  for (const double metric : status->metrics) Require(std::isfinite(8192 * metric));
  Require(status->scalars.size() <= size_t{kMaxScalars});
  for (const NamedScalar& scalar : status->scalars) {
    Require(IsScalarName(scalar.name) && std::isfinite(scalar.value));
  }
  const auto again = DecodeStatusPacket(EncodePacket(*status));
  Require(again && again->scalars == status->scalars);
  return true;
}

bool CheckEpisode(std::span<const std::byte> packet) {
  const auto report = DecodeEpisodePacket(packet);
  if (!report) return false;
  Require(report->outcome >= 0 && report->outcome < 4);
  Require(std::isfinite(100 * report->episode_return));
  Require(report->scenario.size() <= EpisodeReport::kMaxScenarioName);
  Require(IsPrintableUtf8(report->scenario));
  Require(std::ranges::equal(EncodePacket(*report), packet));
  return true;
}

ProcessStatus Learner() {
  ProcessStatus status;
  status.role = dds::Role::kLearner;
  status.pid = 4711;
  status.uptime_s = 12.5;
  status.scalars = {{"critic_loss", 0.5}, {"mean_q", -1.5}};
  return status;
}

EpisodeReport Collision() {
  EpisodeReport report;
  report.outcome = 1;
  report.episode_return = -1.25;
  report.scenario = "left_turn";
  return report;
}

}  // namespace

const int kMutants = 200000;

bool Check(std::span<std::byte> input) {
  if (input.empty()) return false;
  const std::span<const std::byte> packet = input.subspan(1);
  return (input[0] & std::byte{1}) == std::byte{kStatus} ? CheckStatus(packet) : CheckEpisode(packet);
}

Seeds MakeSeeds() {
  Seeds seeds;
  seeds.accepted = {Input(kStatus, EncodePacket(ProcessStatus{})), Input(kStatus, EncodePacket(Learner())),
                    Input(kEpisode, EncodePacket(EpisodeReport{})),
                    Input(kEpisode, EncodePacket(Collision()))};
  ProcessStatus endless = Learner();
  endless[Metric::kUpdates] = std::numeric_limits<double>::infinity();
  EpisodeReport huge = Collision();
  huge.episode_return = 1e300;
  seeds.refused = {Input(kStatus, EncodePacket(endless)),
                   Input(kEpisode, EncodePacket(huge)),
                   Input(kStatus, EncodePacket(Collision())),
                   {}};
  return seeds;
}

}  // namespace dadrl::fuzz
