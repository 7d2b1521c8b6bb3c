// `dadrl replay inspect | verify | export | import` on real folders.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "common/io/checksum.h"
#include "common/io/npy.h"
#include "replay/storage/snapshot_folder.h"
#include "tests/driving_columns.h"
#include "tests/replay/run_tool.h"
#include "tests/replay/tools_fixture.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string FileBytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_F(ToolsTest, InspectCountsWhatIsThereFromAnyOfItsFolders) {
  Store(30);
  for (const fs::path& folder : {run_, run_ / "replay", shard_}) {
    const ToolOutput output = RunTool({"inspect", folder.string(), "--json"});
    ASSERT_EQ(output.exit_code, 0) << output.err;
    const auto json = nlohmann::json::parse(output.out);
    EXPECT_EQ(json["chunks"], 61);
    EXPECT_EQ(json["frames"], 30 * 31 + 3);
    EXPECT_EQ(json["transitions"], 30 * 30 + 3);
    EXPECT_EQ(json["episodes"], 61);
    EXPECT_EQ(json["ends"]["terminated"], 30);
    EXPECT_EQ(json["ends"]["by_success"], 30);
    EXPECT_EQ(json["ends"]["truncated"], 30);
    EXPECT_EQ(json["ends"]["unfinished"], 1);
    EXPECT_EQ(json["actors"], 2);
    EXPECT_EQ(json["policy_versions"]["oldest"], 2);
    EXPECT_EQ(json["policy_versions"]["newest"], 9);
    EXPECT_EQ(json["columns"]["decision"], "action float32 [2]");
    EXPECT_THAT(json["columns"]["observation"].get<std::string>(), HasSubstr("ego float32 [5, 20]"));
    EXPECT_EQ(json["damaged_bytes"], 0);
    EXPECT_GT(json["segments"], 1);
    EXPECT_EQ(json["snapshots"]["count"], 0);
  }
  const fs::path snapshot = SnapshotFolder(run_, 0) / "kept";
  fs::create_directories(snapshot);
  fs::create_hard_link(FirstSegment(), snapshot / "shared.log");
  std::ofstream(snapshot / "own.log") << std::string(1000, 'x');
  for (const fs::path& folder : {run_, run_ / "replay", shard_}) {
    const auto json = nlohmann::json::parse(RunTool({"inspect", folder.string(), "--json"}).out);
    EXPECT_EQ(json["snapshots"]["count"], 1) << folder;
    EXPECT_EQ(json["snapshots"]["bytes_only_there"], 1000) << folder;
  }
  const ToolOutput table = RunTool({"inspect", run_.string()});
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_THAT(table.out, HasSubstr("terminated"));
}

TEST_F(ToolsTest, VerifyNamesFileAndOffsetOfDamageAndMendsNothing) {
  Store(20);
  const ToolOutput sound = RunTool({"verify", run_.string()});
  EXPECT_EQ(sound.exit_code, 0) << sound.out;
  EXPECT_THAT(sound.out, HasSubstr("623 frames"));
  const fs::path segment = FirstSegment();
  std::string bytes = FileBytes(segment);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  bytes.resize(bytes.size() - 16);  // more than padding
  std::ofstream(segment, std::ios::binary) << bytes;
  const ToolOutput damaged = RunTool({"verify", run_.string(), "--json"});
  EXPECT_EQ(damaged.exit_code, 1);
  const auto json = nlohmann::json::parse(damaged.out);
  EXPECT_EQ(json["ok"], false);
  ASSERT_EQ(json["damages"], 2) << damaged.out;
  const auto middle = json["damage"][0];
  EXPECT_EQ(middle["file"], segment.string());
  EXPECT_LE(middle["offset"].get<size_t>(), bytes.size() / 2);
  EXPECT_GT(middle["offset"].get<size_t>() + middle["bytes"].get<size_t>(), bytes.size() / 2);
  EXPECT_EQ(json["damage"][1]["offset"].get<size_t>() + json["damage"][1]["bytes"].get<size_t>(),
            bytes.size());
  EXPECT_EQ(FileBytes(segment), bytes) << "it looks, and touches nothing";
  std::ofstream(shard_ / "state", std::ios::trunc) << "nonsense";
  const ToolOutput state = RunTool({"verify", run_.string()});
  EXPECT_EQ(state.exit_code, 1);
  EXPECT_THAT(state.out, HasSubstr((shard_ / "state").string()));
}

TEST_F(ToolsTest, VerifyFindsAFrameThatDoesNotDecodeBehindSoundChecksums) {
  const auto table = OpenTable();
  ChunkBuilder other(DrivingShape{.vehicles = 2, .history = 5}, FloatCoding::kFloat16);
  other.AddTransition(Observation(DrivingShape{.vehicles = 2, .history = 5}), Action{}, 0.0f, 0, 1);
  std::vector<std::byte> chunk = other.Finish({1, 1, 1});
  const uint64_t schema = SchemaHash(kSpec);
  std::memcpy(&chunk[48], &schema, 8);
  const uint64_t checksum = Xxh3(std::span(chunk).first(chunk.size() - 8));
  std::memcpy(&chunk[chunk.size() - 8], &checksum, 8);
  ASSERT_EQ(table->Insert(chunk), ReplayTable::Insertion::kStored);
  const ToolOutput output = RunTool({"verify", run_.string()});
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_THAT(output.out, HasSubstr("actor 1, episode 0, frame 0"));
}

TEST_F(ToolsTest, VerifyNamesRewardsThatTheTaskCannotGive) {
  TableOptions options{.directory = shard_, .spec = kSpec, .replay = {}};
  options.bounds.reward = INFINITY;
  // A reward of about a thousand: possible for some task, not for the default one.
  const auto chunk = MakeSyntheticChunk(kSpec, {.identity = {1, 5, 1}, .episode = 1 << 20, .frames = 3});
  ASSERT_TRUE(ReplayTable::Open(options, clock_).value()->Insert(chunk));
  EXPECT_EQ(RunTool({"verify", run_.string()}).exit_code, 0) << "nothing says which task it is of";
  std::ofstream(run_ / "config.yaml") << "scenario: left_turn\n";
  for (const fs::path& folder : {run_, run_ / "replay", shard_}) {
    const ToolOutput output = RunTool({"verify", folder.string()});
    EXPECT_EQ(output.exit_code, 1);
    EXPECT_THAT(output.out, HasSubstr("offset 64,"));
    EXPECT_THAT(output.out, HasSubstr("actor 1, episode 1048576, frame 0: reward 1024 is beyond 5.56"));
  }
}

class RoundTrip : public ToolsTest, public testing::WithParamInterface<FloatCoding> {};
INSTANTIATE_TEST_SUITE_P(Codings, RoundTrip, testing::Values(FloatCoding::kFloat16, FloatCoding::kFloat32));

TEST_P(RoundTrip, ExportImportExportIsTheSameToTheByte) {
  Store(8, GetParam());
  const ToolOutput first = RunTool({"export", run_.string(), "--out", At("a")});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  std::ofstream(At("run.yaml")) << "task: {reward: {goal: 100}}\n";  // rewards grow with the episode's number
  const ToolOutput imported =
      RunTool({"import", At("imported"), "--from", At("a"), "--config", At("run.yaml")});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_EQ(RunTool({"verify", At("imported")}).exit_code, 0);
  ASSERT_EQ(RunTool({"export", At("imported"), "--out", At("b")}).exit_code, 0);
  size_t files = 0;
  for (const auto& entry : fs::directory_iterator(At("a"))) {
    EXPECT_EQ(FileBytes(entry.path()), FileBytes(fs::path(At("b")) / entry.path().filename()))
        << entry.path().filename();
    ++files;
  }
  EXPECT_EQ(files, 15u);
  // A replay takes it as its own.
  TableOptions options{.directory = fs::path(At("imported")) / "shard-0", .spec = kSpec, .replay = {}};
  const auto table = ReplayTable::Open(options, clock_).value();
  EXPECT_EQ(table->stats().frames_held, 8u * 30u + 3u);
  EXPECT_EQ(table->stats().inserted_frames, 8u * 30u + 3u);
}

TEST_F(ToolsTest, AnExportOfTheFirstFormatIsImportedAsItWas) {
  Store(3);
  ASSERT_EQ(RunTool({"export", run_.string(), "--out", At("a")}).exit_code, 0);
  ASSERT_TRUE(fs::remove(fs::path(At("a")) / "success.npy"));
  fs::rename(fs::path(At("a")) / "action.npy", fs::path(At("a")) / "actions.npy");
  fs::rename(fs::path(At("a")) / "has_decision.npy", fs::path(At("a")) / "has_action.npy");
  std::ofstream(fs::path(At("a")) / "index.json")
      << R"({"format": "dadrl experience", "version": 1, "rows": 96,
             "observation": {"vehicles": 6, "history": 5}, "floats": "float16", "arrays": {}})";
  std::ofstream(At("run.yaml")) << "task: {reward: {goal: 100}}\n";
  const ToolOutput imported =
      RunTool({"import", At("imported"), "--from", At("a"), "--config", At("run.yaml")});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  ASSERT_EQ(RunTool({"export", At("imported"), "--out", At("b")}).exit_code, 0);
  EXPECT_EQ(FileBytes(fs::path(At("b")) / "action.npy"), FileBytes(fs::path(At("a")) / "actions.npy"));
  EXPECT_EQ(FileBytes(fs::path(At("b")) / "vehicles.npy"), FileBytes(fs::path(At("a")) / "vehicles.npy"));
}

// Stored before there were descriptions, or under another column's.
TEST_F(ToolsTest, AFolderWithoutItsColumnsIsReadIfItsStepsAreOfTheFirstFormat) {
  Store(2);
  ASSERT_TRUE(fs::remove(shard_ / "columns.json"));
  EXPECT_EQ(RunTool({"verify", run_.string()}).exit_code, 0);
  std::ofstream(shard_ / "columns.json") << "{}";
  EXPECT_EQ(RunTool({"verify", run_.string()}).exit_code, 0);
}

// What a method adds to a step is stored, described, exported and imported without a word about it.
TEST_F(ToolsTest, OtherColumnsAreExportedAndImportedByTheirNames) {
  StepSpec spec = kSpec;
  spec.observation.push_back({.name = "gap", .shape = {3}, .bound = 1.0f});
  spec.decision.push_back({.name = "log_probability"});
  {
    const auto table = ReplayTable::Open({.directory = shard_, .spec = spec, .replay = {}}, clock_).value();
    ChunkBuilder builder(spec, FloatCoding::kFloat16);
    builder.Begin(1, 0);
    Observation observation(spec);
    for (int i = 0; i < 4; ++i) {
      const auto x = static_cast<float>(i);
      std::ranges::fill(observation.floats(3), 0.25f * x);
      builder.AddTransition(observation, std::array{0.1f, 0.2f, -x}, 0.5f, i == 3 ? kTerminated : uint8_t{0},
                            1);
    }
    ASSERT_EQ(table->Insert(builder.Finish({1, 5, 1})), ReplayTable::Insertion::kStored);
  }
  EXPECT_EQ(RunTool({"verify", run_.string()}).exit_code, 0);
  ASSERT_EQ(RunTool({"export", run_.string(), "--out", At("a")}).exit_code, 0);
  const auto gap = ReadNpy<float>(fs::path(At("a")) / "gap.npy", 1 << 20).value();
  EXPECT_EQ(gap.shape, (std::vector<size_t>{4, 3}));
  EXPECT_EQ(gap.values[11], 0.75f);
  const auto log_probability = ReadNpy<float>(fs::path(At("a")) / "log_probability.npy", 1 << 20).value();
  EXPECT_EQ(log_probability.values, (std::vector{-0.0f, -1.0f, -2.0f, -3.0f}));
  ASSERT_EQ(RunTool({"import", At("imported"), "--from", At("a")}).exit_code, 0);
  ASSERT_EQ(RunTool({"export", At("imported"), "--out", At("b")}).exit_code, 0);
  for (const char* name : {"index.json", "gap.npy", "log_probability.npy", "action.npy"}) {
    EXPECT_EQ(FileBytes(fs::path(At("a")) / name), FileBytes(fs::path(At("b")) / name)) << name;
  }
  ASSERT_TRUE(fs::remove(shard_ / "columns.json"));
  const ToolOutput unknown = RunTool({"verify", run_.string()});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.err, HasSubstr("nothing says what its steps hold"));
}

TEST_F(ToolsTest, ExportedArraysHoldWhatWasStored) {
  Store(1);
  ASSERT_EQ(RunTool({"export", run_.string(), "--out", At("arrays"), "--limit", "30"}).exit_code, 0);
  const fs::path arrays = At("arrays");
  const auto chunk = MakeSyntheticChunk(
      kSpec, {.identity = {1, 5, 1}, .episode = 1, .frames = 20, .end = kTerminated, .policy_version = 2});
  const auto view = ChunkView::Parse(chunk).value();
  const auto rewards = ReadNpy<float>(arrays / "rewards.npy", 1 << 20).value();
  const auto vehicles = ReadNpy<float>(arrays / "vehicles.npy", 1 << 20).value();
  const auto context = ReadNpy<uint8_t>(arrays / "context.npy", 1 << 20).value();
  const auto terminated = ReadNpy<uint8_t>(arrays / "terminated.npy", 1 << 20).value();
  const auto step = ReadNpy<uint32_t>(arrays / "step.npy", 1 << 20).value();
  EXPECT_EQ(rewards.shape, std::vector<size_t>{30});
  EXPECT_EQ(vehicles.shape, (std::vector<size_t>{30, 6, 5, 7}));
  EXPECT_EQ(context.shape, (std::vector<size_t>{30, 2, 128, 128}));
  PayloadCodec codec(kSpec, FloatCoding::kFloat16);
  Observation observation(kSpec);
  for (int frame = 0; frame < 20; ++frame) {
    const auto row = static_cast<size_t>(frame);
    ASSERT_TRUE(codec.Decode(view.payload(frame), observation));
    EXPECT_EQ(rewards.values[row], view.reward(frame));
    EXPECT_EQ(terminated.values[row], frame == 19);
    EXPECT_EQ(step.values[row], row);
    EXPECT_TRUE(std::equal(VehiclesOf(observation).begin(), VehiclesOf(observation).end(),
                           vehicles.values.begin() + static_cast<ptrdiff_t>(row * 210)));
    for (const size_t pixel :
         {size_t{0}, size_t{8 * 128 + 60}, size_t{64 * 128 + 64}, size_t{2 * 16384 - 1}}) {
      EXPECT_EQ(context.values[row * 32768 + pixel], ContextOf(observation)[pixel / 8] >> (pixel % 8) & 1);
    }
  }
}

TEST_F(ToolsTest, NumPyReadsAnExport) {
  Store(2);
  ASSERT_EQ(RunTool({"export", run_.string(), "--out", At("arrays")}).exit_code, 0);
  const std::string script = folder_.path() / "check.py";
  std::ofstream(script) << R"(
import json, numpy, sys
index = json.load(open(sys.argv[1] + "/index.json"))
a = {name: numpy.load(f"{sys.argv[1]}/{array['file']}") for name, array in index["arrays"].items()}
for name, array in index["arrays"].items():
    assert list(a[name].shape) == array["shape"] and a[name].dtype.str == array["type"], name
rows = index["rows"]
assert rows == 2 * 31 + 3
transitions = a["has_decision"] == 1
assert transitions.sum() == 63 and a["terminated"].sum() == 2 and a["truncated"].sum() == 2
assert (a["success"] == a["terminated"]).all()
# The row behind a transition is its next observation, unless the episode terminated.
after = numpy.flatnonzero(a["truncated"]) + 1
assert (a["has_decision"][after] == 0).all() and (a["step"][after] == 10).all()
assert a["context"].max() == 1 and numpy.isfinite(a["vehicles"]).all()
)";
  const ToolOutput checked = RunShell("/usr/bin/python3 " + script + " " + At("arrays"));
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
}

TEST_F(ToolsTest, ImportRefusesWhatIsNoExperienceAndLeavesNothingBehind) {
  Store(1);
  ASSERT_EQ(RunTool({"export", run_.string(), "--out", At("arrays")}).exit_code, 0);
  const fs::path arrays = At("arrays");
  const auto refused = [&](const char* says, int code) {
    const ToolOutput output = RunTool({"import", At("new"), "--from", arrays.string()});
    EXPECT_EQ(output.exit_code, code) << output.err;
    EXPECT_THAT(output.err, HasSubstr(says));
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
    EXPECT_FALSE(fs::exists(At("new")));
  };
  auto ego = ReadNpy<float>(arrays / "ego.npy", 1 << 20).value();
  const auto sound_ego = ego.values;
  ego.values[200] = NAN;
  ASSERT_TRUE(WriteNpy<float>(arrays / "ego.npy", ego.shape, ego.values));
  refused("row 2: ego.npy", 2);
  ASSERT_TRUE(WriteNpy<float>(arrays / "ego.npy", ego.shape, sound_ego));
  auto truncated = ReadNpy<uint8_t>(arrays / "truncated.npy", 1 << 20).value();
  const auto sound_truncated = truncated.values;
  truncated.values[5] = 1;
  ASSERT_TRUE(WriteNpy<uint8_t>(arrays / "truncated.npy", truncated.shape, truncated.values));
  refused("no part of an episode", 2);
  const std::vector<size_t> shorter{3};
  ASSERT_TRUE(WriteNpy<uint8_t>(arrays / "truncated.npy", shorter, std::span(sound_truncated).first(3)));
  refused("has shape (3,)", 2);
  fs::remove(arrays / "index.json");
  refused("index.json", 1);
}

TEST_F(ToolsTest, ImportRefusesWhatTheTaskCannotProduce) {
  Store(1);
  ASSERT_EQ(RunTool({"export", run_.string(), "--out", At("arrays")}).exit_code, 0);
  const fs::path arrays = At("arrays");
  const auto refused = [&](const char* says) {
    const ToolOutput output = RunTool({"import", At("new"), "--from", arrays.string()});
    EXPECT_EQ(output.exit_code, 2) << output.err;
    EXPECT_THAT(output.err, HasSubstr(says));
    EXPECT_FALSE(fs::exists(At("new")));
  };
  // One value of one array, and back.
  const auto with = [&]<typename T>(const char* name, size_t at, T value, const char* says) {
    const fs::path file = arrays / (std::string(name) + ".npy");
    const auto sound = ReadNpy<T>(file, 1 << 20).value();
    auto array = sound;
    array.values[at] = value;
    ASSERT_TRUE(WriteNpy<T>(file, array.shape, array.values));
    refused(says);
    ASSERT_TRUE(WriteNpy<T>(file, sound.shape, sound.values));
  };
  with("rewards", 3, 1e30f, "row 3: a reward of 1e+30, a decision of this task earns at most 5.56");
  with("rewards", 3, -3e38f, "row 3: a reward of -3e+38");
  with("rewards", 0, NAN, "row 0: a reward of nan");
  with("action", 4, 1.5f, "row 2: the decision (1.5");
  with("action", 5, NAN, "within [-1, 1]");
  with("vehicles", 0, 6.0f, "row 0: vehicles.npy holds a number that is not within [-5, 5]");
  with("has_decision", 1, uint8_t{2}, "row 1: has_decision.npy holds something else than 0 and 1");
  with("incarnation", 2, UINT64_MAX, "row 2: incarnation 18446744073709551615 is a time to come");
  EXPECT_EQ(RunTool({"import", At("new"), "--from", arrays.string()}).exit_code, 0);
}

TEST_F(ToolsTest, AConfigurationSaysWhatItsRewardsCanBe) {
  Store(1);
  ASSERT_EQ(RunTool({"export", run_.string(), "--out", At("arrays")}).exit_code, 0);
  const fs::path file = fs::path(At("arrays")) / "rewards.npy";
  auto rewards = ReadNpy<float>(file, 1 << 20).value();
  rewards.values[7] = 80.0f;
  ASSERT_TRUE(WriteNpy<float>(file, rewards.shape, rewards.values));
  EXPECT_EQ(RunTool({"import", At("new"), "--from", At("arrays")}).exit_code, 2);
  std::ofstream(At("run.yaml")) << "task: {reward: {goal: 80}}\n";
  EXPECT_EQ(RunTool({"import", At("new"), "--from", At("arrays"), "--config", At("run.yaml")}).exit_code, 0);
}

TEST_F(ToolsTest, AFailedImportRemovesOnlyWhatItMade) {
  Store(1);
  ASSERT_EQ(RunTool({"export", run_.string(), "--out", At("arrays")}).exit_code, 0);
  const fs::path file = fs::path(At("arrays")) / "rewards.npy";
  auto rewards = ReadNpy<float>(file, 1 << 20).value();
  rewards.values.back() = 1e30f;
  ASSERT_TRUE(WriteNpy<float>(file, rewards.shape, rewards.values));
  fs::create_directories(At("mine"));
  EXPECT_EQ(RunTool({"import", At("mine"), "--from", At("arrays")}).exit_code, 2);
  EXPECT_TRUE(fs::is_directory(At("mine")) && fs::is_empty(At("mine")));
  std::ofstream(At("file")) << "";
  EXPECT_EQ(RunTool({"import", At("file"), "--from", At("arrays")}).exit_code, 2);
  EXPECT_TRUE(fs::is_regular_file(At("file")));
}

TEST_F(ToolsTest, NothingIsOverwritten) {
  Store(1);
  ASSERT_EQ(RunTool({"export", run_.string(), "--out", At("arrays")}).exit_code, 0);
  const ToolOutput again = RunTool({"export", run_.string(), "--out", At("arrays")});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, HasSubstr("not empty"));
  const ToolOutput onto = RunTool({"import", (run_ / "replay").string(), "--from", At("arrays")});
  EXPECT_EQ(onto.exit_code, 2);
  EXPECT_THAT(onto.err, HasSubstr("no empty folder"));
}

TEST_F(ToolsTest, WrongUsageIsOneLine) {
  fs::create_directories(folder_.path() / "empty");
  const auto fails = [](const std::vector<std::string>& words, int code, const char* says) {
    const ToolOutput output = RunTool(words);
    EXPECT_EQ(output.exit_code, code) << output.err;
    EXPECT_THAT(output.err, HasSubstr(says));
    EXPECT_EQ(output.out, "");
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
  };
  fails({"inspect", "/no/such/folder"}, 1, "/no/such/folder");
  fails({"verify", At("empty")}, 1, "holds no stored experience");
  fails({"inspekt", At("empty")}, 2, "the nearest is 'inspect'");
  fails({"export", At("empty")}, 2, "--out");
  for (const std::string& name : {std::string("../x"), std::string("/tmp/x"), std::string("''"),
                                  std::string("a/../../b"), std::string(300, 'x'), std::string(".")}) {
    fails({"restore", "--run-dir", At("empty"), "--snapshot", name}, 2, "snapshot name");
    fails({"snapshot", "--run-dir", At("empty"), "--name", name}, 2, name == "''" ? "config.yaml" : "name");
  }
  fails({"restore", "--run-dir", At("empty"), "--snapshot", "$(printf 'x\\033[31m')"}, 2, "'x\\x1b[31m'");
  fails({"limit", "--run-dir", At("empty")}, 2, "config.yaml");
  fails({"limit", "--run-dir", At("empty"), "--samples-per-insert", "many"}, 2, "--samples-per-insert");
}

}  // namespace
}  // namespace dadrl
