// processes.json of a run that may be somebody else's: what is taken can be shown on a terminal.
#include "deploy/monitor/supervision.h"

#include <algorithm>

#include "deploy/monitor/merge_supervision.h"
#include "tests/fuzz/outside_text.h"

namespace dadrl::fuzz {
namespace {

bool IsShown(const std::string& text) {
  return std::ranges::none_of(text, [](char c) { return (c >= 0 && c < ' ') || c == 0x7f; });
}

}  // namespace

const int kMutants = 20000;

bool Check(std::span<std::byte> input) {
  const auto supervision = ParseSupervision(std::string(AsText(input)));
  if (!Accepted(supervision)) return false;
  Require(supervision->launcher >= 0);
  for (const SupervisedProcess& process : supervision->processes) {
    Require(process.pid >= 0 && process.restarts >= 0 && process.hangs >= 0 && process.since_ns >= 0);
    for (const std::string* text :
         {&process.name, &process.state, &process.trouble, &process.fault, &process.last_end}) {
      Require(IsShown(*text));
    }
  }
  ClusterSummary summary;
  MergeSupervision(*supervision, summary);
  Require(summary.processes.size() <= supervision->processes.size());
  return true;
}

Seeds MakeSeeds() {
  const Supervision supervision{
      .launcher = 17,
      .processes = {
          {.name = "replay-0", .pid = 18, .state = "running", .trouble = "", .fault = "", .last_end = ""},
          {.name = "actor-2147483648",
           .state = "restarting",
           .trouble = "\x1b[2J",
           .fault = "fault",
           .restarts = 3,
           .last_end = "it hung"}}};
  Seeds seeds{
      .accepted = {AsBytes(SupervisionJson(supervision)), AsBytes(R"({"launcher":0,"processes":[]})")},
      .refused = BadJson()};
  for (const char* launcher : {"-1", "2147483648", "1.5", "\"1\"", "null"}) {
    seeds.refused.push_back(AsBytes(fmt::format(R"({{"launcher":{},"processes":[]}})", launcher)));
  }
  seeds.refused.push_back(AsBytes(R"({"launcher":1,"processes":{}})"));
  seeds.refused.push_back(AsBytes(R"({"launcher":1,"processes":[[]]})"));
  return seeds;
}

}  // namespace dadrl::fuzz
