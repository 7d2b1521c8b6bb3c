#include "actor/sim/traffic.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <utility>

#include "actor/sim/world_state.h"

namespace dadrl {
namespace {

// A vehicle that moveToXY sets down across two lanes is registered on the second one too, and SUMO 1.15 never
// takes that back: the traffic keeps braking for it there, and once the ego is off the road the next look at
// it aborts the process (MSVehicle::getBackPositionOnLane). Less wide than SUMO's tolerance of 1 mm, the ego
// is on one lane at a time. SUMO needs its width for nothing else here: contacts are judged outside it.
constexpr double kDrivenEgoWidth = 0.001;

using Attributes = std::vector<std::pair<std::string, std::string>>;

std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

const std::string* Find(const ProfileSettings& profile, std::string_view name) {
  for (const auto& [key, value] : profile.driver_attributes) {
    if (key == name) return &value;
  }
  return nullptr;
}

// A later value of the same name replaces the earlier.
void Set(Attributes& attributes, const std::string& name, std::string value) {
  const auto found = std::find_if(attributes.begin(), attributes.end(),
                                  [&](const auto& attribute) { return attribute.first == name; });
  if (found == attributes.end()) {
    attributes.emplace_back(name, std::move(value));
  } else {
    found->second = std::move(value);
  }
}

void AppendType(std::string& xml, int index, const DriverType& type, const ProfileSettings& profile) {
  Attributes attributes{{"vClass", kCarClass}, {"length", "5"},      {"width", "1.8"},
                        {"accel", "2.6"},      {"maxSpeed", "55.5"}, {"speedDev", "0.1"}};
  // Lorries, buses and the like are as SUMO has them.
  if (VehicleClass(profile) != kCarClass) attributes = {{"speedDev", "0.1"}};
  Set(attributes, "decel", fmt::format("{}", kDriverDecel));
  Set(attributes, "speedFactor", fmt::format("{}", type.speed_factor));
  Set(attributes, "sigma", fmt::format("{}", type.imperfection));
  Set(attributes, "minGap", fmt::format("{}", type.min_gap_m));
  Set(attributes, "lcSpeedGain", fmt::format("{}", type.lane_change_speed_gain));
  Set(attributes, "lcImpatience", fmt::format("{}", type.lane_change_impatience));
  Set(attributes, "lcCooperative", fmt::format("{}", type.lane_change_cooperative));
  Set(attributes, "jmIgnoreFoeProb", fmt::format("{}", type.ignore_standing_foe));
  Set(attributes, "impatience", fmt::format("{}", type.impatience));
  for (const auto& [name, value] : profile.driver_attributes) Set(attributes, name, value);
  fmt::format_to(std::back_inserter(xml), R"(<vType id="{}")", TypeId(index));
  for (const auto& [name, value] : attributes) {
    fmt::format_to(std::back_inserter(xml), R"( {}="{}")", name, Escaped(value));
  }
  xml += "/>\n";
}

void AppendEgo(std::string& xml, const EgoTraffic& ego) {
  // A driven ego brakes and keeps distance as the paper's simulator declares it to the traffic; SUMO's own
  // driver keeps SUMO's defaults.
  const std::string driver = ego.sumo_drives
                                 ? fmt::format(R"(width="{}" maxSpeed="{}" impatience="{}")", kVehicleWidth,
                                               ego.max_speed_mps, ego.impatience)
                                 : fmt::format(R"(width="{}" decel="6" tau="4")", kDrivenEgoWidth);
  fmt::format_to(std::back_inserter(xml),
                 R"(<vType id="{0}" vClass="passenger" length="{1}" {2}/>)"
                 "\n"
                 R"(<route id="{0}" edges="{3}"/>)"
                 "\n",
                 kEgoId, kVehicleLength, driver, Escaped(fmt::format("{}", fmt::join(ego.edges, " "))));
}

}  // namespace

std::string SocialId(int vehicle) { return fmt::format("v{}", vehicle); }
std::string FlowId(int flow) { return fmt::format("f{}", flow); }
std::string TypeId(int type) { return fmt::format("t{}", type); }

int SocialIndex(const std::string& id) {
  int index = -1;
  if (id.size() < 2 || id[0] != 'v') return -1;
  const auto [end, error] = std::from_chars(id.data() + 1, id.data() + id.size(), index);
  return error == std::errc() && end == id.data() + id.size() ? index : -1;
}

bool SaysWhatDrives(const ProfileSettings& profile) {
  return Find(profile, "length") != nullptr || Find(profile, "width") != nullptr ||
         VehicleClass(profile) != kCarClass;
}

std::string VehicleClass(const ProfileSettings& profile) {
  const std::string* const given = Find(profile, "vClass");
  return given == nullptr ? kCarClass : *given;
}

std::vector<DriverType> SampleDriverTypes(int count, Random& random) {
  std::vector<DriverType> types(static_cast<size_t>(count));
  for (DriverType& type : types) {
    type.speed_factor = random.Uniform(0.6, 1.0);
    type.min_gap_m = std::max(0.0, random.Uniform(2.0, 4.0) + 0.1 * random.Normal());
    type.imperfection = std::clamp(random.Uniform(0.3, 0.7) + 0.1 * random.Normal(), 0.0, 1.0);
    type.lane_change_speed_gain = random.Uniform(1.0, 2.0);
    type.lane_change_impatience = random.Uniform();
    type.lane_change_cooperative = random.Uniform();
    type.ignore_standing_foe = random.Uniform();
    type.impatience = random.Uniform();
  }
  return types;
}

std::string TrafficXml(const Scenario& scenario, const ProfileSettings& profile,
                       const std::vector<DriverType>& types, const std::vector<double>& lane_end_m,
                       const EgoTraffic& ego) {
  std::string xml = "<routes>\n";
  for (size_t type = 0; type < types.size(); ++type) {
    AppendType(xml, type, types[type], profile);
  }
  AppendEgo(xml, ego);
  for (size_t flow = 0; flow < scenario.flows.size(); ++flow) {
    fmt::format_to(std::back_inserter(xml), "<route id=\"{}\" edges=\"{}\"/>\n", FlowId(flow),
                   Escaped(fmt::format("{}", fmt::join(scenario.flows[flow].edges, " "))));
  }
  for (int vehicle = 0; vehicle < scenario.population(); ++vehicle) {
    const int flow_index = vehicle / scenario.driver_types;
    const TrafficFlow& flow = scenario.flows[static_cast<size_t>(flow_index)];
    const std::string depart = flow.depart == FlowPosition::kRandom
                                   ? std::string("random")
                                   : fmt::format("{}", lane_end_m[static_cast<size_t>(flow_index)]);
    fmt::format_to(std::back_inserter(xml),
                   R"(<vehicle id="{}" type="{}" route="{}" depart="0" departLane="{}" departPos="{}" )"
                   R"(departSpeed="max" arrivalLane="{}" arrivalPos="{}"/>)"
                   "\n",
                   SocialId(vehicle), TypeId(vehicle % scenario.driver_types), FlowId(flow_index),
                   flow.depart_lane, depart, flow.arrival_lane,
                   flow.arrival == FlowPosition::kRandom ? "random" : "max");
  }
  return xml + "</routes>\n";
}

}  // namespace dadrl
