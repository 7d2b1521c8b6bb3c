#include "actor/sensing/birds_eye_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "common/util/random.h"
#include "tests/actor/test_maps.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

constexpr int kSize = DrivingShape::kContextSize;
using Planes = std::vector<uint8_t>;

Planes Draw(const RoadMap& map, const Route& route, const Pose& ego) {
  Planes planes(DrivingShape::kContextBytes, 0xAA);
  BirdsEyeView(map, route).Draw(ego, route.centre().Project(ego.position).s, planes);
  return planes;
}

bool Pixel(const Planes& planes, int plane, int row, int column) {
  const auto byte = static_cast<size_t>((plane * kSize + row) * (kSize / 8) + column / 8);
  return (planes[byte] >> (column % 8) & 1) != 0;
}

int Count(const Planes& planes, int plane) {
  int count = 0;
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) count += Pixel(planes, plane, row, column) ? 1 : 0;
  }
  return count;
}

int Differences(const Planes& a, const Planes& b, int plane) {
  int count = 0;
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      count += Pixel(a, plane, row, column) != Pixel(b, plane, row, column) ? 1 : 0;
    }
  }
  return count;
}

// What the pixel's centre shows, in the ego's frame.
Point PixelCentre(int row, int column) {
  return {25.0 - (row + 0.5) * kPixelMetres, 25.0 - (column + 0.5) * kPixelMetres};
}

// On StraightRoad, driving east in lane 0: road from 1.6 m right to 8 m left; route 1 m to both sides, from
// 1 m behind to 33 m ahead (outside the view beyond 25 m).
TEST(BirdsEyeView, StraightRoadIsWhereArithmeticPutsIt) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  const Planes planes = Draw(map, route, {{60, 0}, 0.0});
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      const Point p = PixelCentre(row, column);
      const bool near_border = std::abs(p.y + 1.6) < 0.15 || std::abs(p.y - 8.0) < 0.15;
      if (!near_border) {
        ASSERT_EQ(Pixel(planes, 0, row, column), p.y > -1.6 && p.y < 8.0) << row << ' ' << column;
      }
      const bool on_route = std::abs(p.y) <= 1.0 && p.x >= 0.0;
      const bool in_cap = p.x < 0.0 && std::hypot(p.x, p.y) <= 1.0;
      ASSERT_EQ(Pixel(planes, 1, row, column), on_route || in_cap) << row << ' ' << column;
    }
  }
}

// StraightRoad runs along y = 0; wherever the ego stands and looks, every pixel is where arithmetic puts it.
TEST(BirdsEyeView, NoRoadIsLostAtAnyPose) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  Random random(3);
  for (int draw = 0; draw < 50; ++draw) {
    const Pose ego{{random.Uniform(40.0, 160.0), random.Uniform(-5.0, 11.0)},
                   random.Uniform(-std::numbers::pi, std::numbers::pi)};
    const Planes planes = Draw(map, route, ego);
    const Point ahead = Forward(ego.heading);
    for (int row = 0; row < kSize; ++row) {
      for (int column = 0; column < kSize; ++column) {
        const Point p = PixelCentre(row, column);
        const double y = ego.position.y + p.x * ahead.y + p.y * ahead.x;
        if (std::abs(y + 1.6) < 0.15 || std::abs(y - 8.0) < 0.15) continue;
        ASSERT_EQ(Pixel(planes, 0, row, column), y > -1.6 && y < 8.0) << draw << " " << row << " " << column;
      }
    }
  }
}

TEST(BirdsEyeView, AheadIsUpAndLeftIsLeft) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  const Planes planes = Draw(map, route, {{100, 0}, std::numbers::pi / 2});  // facing north, across the road
  EXPECT_TRUE(Pixel(planes, 0, 50, 10));                                     // 5.3 m ahead: still road
  EXPECT_FALSE(Pixel(planes, 0, 40, 64));                                    // 9.2 m ahead: beyond it
  EXPECT_FALSE(Pixel(planes, 0, 70, 64));                                    // 2.5 m behind
  EXPECT_TRUE(Pixel(planes, 1, 64, 80));                                     // the route goes to the right
  EXPECT_FALSE(Pixel(planes, 1, 64, 40));
}

TEST(BirdsEyeView, RouteBandEndsAtTheGoal) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  const Planes planes = Draw(map, route, {{100, 0}, 0.0});  // ten metres before the goal
  const int last_row = 64 - static_cast<int>(std::ceil(11.0 / kPixelMetres));
  EXPECT_FALSE(Pixel(planes, 1, last_row - 1, 63));
  EXPECT_TRUE(Pixel(planes, 1, last_row + 2, 63));
}

TEST(BirdsEyeView, TurningTheWorldChangesNothing) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  const Pose ego{{57.3, 0.4}, 0.2};
  const Planes reference = Draw(map, route, ego);
  for (const double angle : {std::numbers::pi / 2, std::numbers::pi, 0.3, -1.9}) {
    const Point shift{-31.7, 48.1};
    const RoadMap turned = test::StraightRoad(angle, shift);
    const Planes planes = Draw(turned, test::StraightRoute(turned, angle, shift),
                               {test::Moved(ego.position, angle, shift), ego.heading + angle});
    // The border cells of the 0.2 m bitmap fall elsewhere; nothing else may change.
    EXPECT_LT(Differences(reference, planes, 0), 128 * 2 / 2) << angle;
    EXPECT_LE(Differences(reference, planes, 1), 2) << angle;
  }
}

TEST(BirdsEyeView, MirroredWorldIsMirroredPicture) {
  const auto draw = [](double side) {
    std::vector<Lane> lanes;
    lanes.push_back(test::MakeLane("a_0", "a", 0, 10, {{-60, 0}, {10, 0}, {17, side * 3}, {20, side * 40}}));
    const RoadMap map(std::move(lanes),
                      {{{15, side * 10}, {30, side * 10}, {30, side * 18}, {15, side * 18}}});
    const Route route(map, {0}, {-60, 0}, {20, side * 40});
    return Draw(map, route, {{3, side * 0.3}, side * 0.1});
  };
  const Planes left = draw(1.0);
  const Planes right = draw(-1.0);
  int differences[2] = {0, 0};
  for (int plane = 0; plane < 2; ++plane) {
    for (int row = 0; row < kSize; ++row) {
      for (int column = 0; column < kSize; ++column) {
        differences[plane] +=
            Pixel(left, plane, row, column) != Pixel(right, plane, row, kSize - 1 - column) ? 1 : 0;
      }
    }
  }
  EXPECT_LT(differences[0], 128);  // a quarter of the border cells
  EXPECT_LE(differences[1], 2);
  EXPECT_GT(Count(left, 0), 1000);
  EXPECT_GT(Count(left, 1), 300);
}

TEST(BirdsEyeView, FarOffTheMapThereIsNoRoad) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  for (const Point p : {Point{1e7, 0}, Point{-500, -500}, Point{300, 0}, Point{0, -90}}) {
    EXPECT_EQ(Count(Draw(map, route, {p, 0.7}), 0), 0);
  }
}

TEST(BirdsEyeView, SeesTheWholeSquareAtTheMapsCorner) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  // At the road's end, facing outward: road only in the lower half.
  const Planes planes = Draw(map, route, {{200, 3.2}, 0.0});
  EXPECT_TRUE(Pixel(planes, 0, 127, 64));
  EXPECT_TRUE(Pixel(planes, 0, 65, 64));
  EXPECT_FALSE(Pixel(planes, 0, 62, 64));
}

// A T junction: up from the south, left into the nearer lane of the road that crosses.
RoadMap TJunction() {
  std::vector<Lane> lanes;
  lanes.push_back(test::MakeLane("south_0", "south", 0, 10, {{0, -60}, {0, -10}}, {1}));
  lanes.push_back(test::MakeLane(":j_0", ":j", 0, 10, {{0, -10}, {-1, -6}, {-4, -3}, {-8, -2}}, {2}));
  lanes.push_back(test::MakeLane("west_0", "west", 0, 10, {{-8, -2}, {-60, -2}}));
  lanes.push_back(test::MakeLane("east_0", "east", 0, 10, {{-60, -5.2}, {60, -5.2}}));
  return RoadMap(std::move(lanes), {{{-8, -7}, {-4, -10}, {4, -10}, {8, -7}, {8, -0.4}, {-8, -0.4}}});
}

// Both planes below each other as a portable bitmap, which any picture viewer opens:
// golden/t_junction.pbm was looked at once and is right.
std::string AsPortableBitmap(const Planes& planes) {
  std::string text = "P4\n128 256\n";
  for (uint8_t byte : planes) {
    uint8_t reversed = 0;
    for (int bit = 0; bit < 8; ++bit) reversed |= static_cast<uint8_t>((byte >> bit & 1) << (7 - bit));
    text += static_cast<char>(reversed);
  }
  return text;
}

// A road of 20 km: wherever on it the ego is, the road looks the same, squares that were drawn, dropped and
// drawn again included.
TEST(BirdsEyeView, ARoadLooksTheSameHoweverFarItGoes) {
  std::vector<Lane> lanes;
  lanes.push_back(test::MakeLane("road_0", "road", 0, 10.0, {{0, 0}, {20'000, 0}}));
  const RoadMap map(std::move(lanes), {});
  const Route route(map, {0}, {0, 0}, {20'000, 0});
  BirdsEyeView view(map, route);
  const auto look = [&](double x) {
    Planes planes(DrivingShape::kContextBytes, 0xAA);
    view.Draw({{x, 0.0}, 0.0}, x, planes);
    return planes;
  };
  const Planes expected = look(100.0);
  ASSERT_GT(Count(expected, 0), 0);
  for (double x = 228.0; x < 19'900.0; x += 128.0) {
    ASSERT_EQ(Differences(look(x), expected, 0), 0) << x;
    ASSERT_EQ(Differences(look(x), expected, 1), 0) << x;
  }
  EXPECT_EQ(Differences(look(100.0), expected, 0), 0);
}

TEST(BirdsEyeView, ABridgeOverTheRouteIsNotRoad) {
  const auto draw = [](double height) {
    std::vector<Lane> lanes;
    lanes.push_back(test::MakeLane("under_0", "under", 0, 10.0, {{0, 0}, {200, 0}}));
    lanes.push_back(test::MakeLane("over_0", "over", 0, 10.0, {{100, -100}, {100, 100}}));
    lanes.back().centre = Polyline({{100, -100}, {100, 100}}, {height, height});
    const RoadMap map(std::move(lanes), {});
    return Draw(map, Route(map, {0}, {0, 0}, {200, 0}), {{90, 0}, 0.0});
  };
  // Without the bridge the road is 3.2 m of the 50 m wide view.
  EXPECT_NEAR(Count(draw(7.0), 0), kSize * kSize * 3.2 / 50, kSize);
  EXPECT_GT(Count(draw(0.0), 0), 1.8 * Count(draw(7.0), 0));
}

TEST(BirdsEyeView, LooksLikeTheGoldenPicture) {
  const RoadMap map = TJunction();
  const Route route(map, {0, 1, 2}, {0, -50}, {-50, -2});
  const std::string picture = AsPortableBitmap(Draw(map, route, {{0.2, -18}, std::numbers::pi / 2 + 0.1}));
  std::ifstream file(DADRL_SOURCE_DIR "/tests/actor/sensing/golden/t_junction.pbm", std::ios::binary);
  const std::string golden((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  ASSERT_EQ(picture.size(), golden.size());
  int differences = 0;
  for (size_t i = 0; i < picture.size(); ++i) {
    differences += __builtin_popcount(static_cast<uint8_t>(picture[i] ^ golden[i]));
  }
  // Compilers may round a border either way.
  EXPECT_LE(differences, 4);
}

}  // namespace
}  // namespace dadrl
