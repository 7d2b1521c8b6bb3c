#include "actor/sim/network_crop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "actor/sim/simulation.h"
#include "actor/sim/sumo_network.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

// 3 x 3 crossings, columns A to C, rows 0 to 2, 100 m apart.
constexpr const char* kGrid = DADRL_SOURCE_DIR "/tests/actor/roads/small_grid";

std::string Text(const fs::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(NetworkCrop, KeepsWhatIsNearAsItWas) {
  const fs::path network = fs::path(kGrid) / "network.net.xml";
  std::string text = Text(network);
  ASSERT_TRUE(CropNetworkXml(text, {"A0A1", "A1A2"}, 30.0));
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "cut.net.xml") << text;
  const auto whole = LoadRoadMap(network);
  ASSERT_TRUE(whole) << whole.error().message;
  const auto cut = LoadRoadMap(folder.path() / "cut.net.xml");
  ASSERT_TRUE(cut) << cut.error().message;
  // Column A with what leads off it stays, columns B and C go.
  EXPECT_GE(cut->FindLane("A1B1_0"), 0);
  EXPECT_EQ(cut->FindLane("B1C1_0"), -1);
  EXPECT_EQ(cut->FindLane("B0B1_0"), -1);
  EXPECT_LT(cut->lanes().size(), whole->lanes().size() / 2);
  const auto names = [](const RoadMap& map, const Lane& lane) {
    std::vector<std::string> successors;
    for (const int next : lane.successors) successors.push_back(map.lane(next).id);
    return successors;
  };
  for (const Lane& lane : cut->lanes()) {
    const Lane& before = whole->lane(whole->FindLane(lane.id));
    EXPECT_EQ(lane.centre.length(), before.centre.length()) << lane.id;
    EXPECT_EQ(lane.speed_limit, before.speed_limit) << lane.id;
    // Dead ends at the rim: edges that lead into column B.
    const bool into_rim = lane.edge == "A0B0" || lane.edge == "A1B1" || lane.edge == "A2B2";
    EXPECT_EQ(names(*cut, lane), into_rim ? std::vector<std::string>{} : names(*whole, before)) << lane.id;
  }
}

TEST(NetworkCrop, LeavesWhatItCannotCut) {
  const std::string grid = Text(fs::path(kGrid) / "network.net.xml");
  for (const auto& [text, edge] : std::vector<std::pair<std::string, std::string>>{
           {grid, "nowhere"}, {"", "A0A1"}, {"<net>", "A0A1"}, {"<nodes/>", "A0A1"}, {"\x1f\x8b", "A0A1"}}) {
    std::string cut = text;
    EXPECT_FALSE(CropNetworkXml(cut, {edge}, 30.0));
    EXPECT_EQ(cut, text);
  }
}

// What a process takes follows what is near the route: SUMO and the map get the same part.
TEST(NetworkCrop, IsWhatALargeNetworkIsDrivenOn) {
  const TemporaryFolder folder;
  fs::copy(kGrid, folder.path() / "city");
  const std::string command =
      "netgenerate --grid --grid.number 16 --grid.length 100 --no-turnarounds true "
      "--xml-validation never -o " +
      (folder.path() / "city/network.net.xml").string() + " >/dev/null 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0);
  ASSERT_GT(fs::file_size(folder.path() / "city/network.net.xml"), kCropBytes);
  const auto scenario = LoadScenario("city", folder.path());
  ASSERT_TRUE(scenario) << scenario.error().message;
  const auto simulation = Simulation::Create(*scenario, {});
  ASSERT_TRUE(simulation) << simulation.error().message;
  EXPECT_TRUE((*simulation)->network_is_cut());
  EXPECT_GE((*simulation)->map().FindLane("D3E3_0"), 0);
  EXPECT_EQ((*simulation)->map().FindLane("O14P14_0"), -1);
  ASSERT_TRUE((*simulation)->Reset(1));
  EXPECT_FALSE((*simulation)->world().vehicles.empty());
}

}  // namespace
}  // namespace dadrl
