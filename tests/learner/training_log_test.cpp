#include "learner/training_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/io/byte_io.h"
#include "common/io/crc32c.h"
#include "common/io/read_file.h"
#include "tests/common/io/small_disk.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

constexpr uint64_t kNoLimit = uint64_t{1} << 24;

// An independent reader of event files: TFRecord framing and the few protobuf fields, by their numbers.
struct Event {
  double wall_time = 0.0;
  int64_t step = 0;
  std::string file_version;
  bool session_start = false;
  std::map<std::string, float> scalars;
};

uint64_t GetVarint(ByteReader& reader) {
  uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const auto byte = reader.Get<uint8_t>();
    value |= static_cast<uint64_t>(byte & 0x7F) << shift;
    if (byte < 0x80) break;
  }
  return value;
}

// Calls `visit(field, wire type, payload, number)` for each field.
template <typename Visit>
void ForEachField(std::span<const std::byte> message, Visit visit) {
  ByteReader reader(message);
  while (reader.remaining() > 0 && reader.ok()) {
    const uint64_t key = GetVarint(reader);
    switch (key & 7) {
      case 0:
        visit(key >> 3, std::span<const std::byte>(), static_cast<double>(GetVarint(reader)));
        break;
      case 1:
        visit(key >> 3, std::span<const std::byte>(), reader.Get<double>());
        break;
      case 2:
        visit(key >> 3, reader.GetBytes(GetVarint(reader)), 0.0);
        break;
      case 5:
        visit(key >> 3, std::span<const std::byte>(), static_cast<double>(reader.Get<float>()));
        break;
      default:
        FAIL() << "wire type " << (key & 7);
    }
  }
  EXPECT_TRUE(reader.ok());
}

std::string Text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Event ParseEvent(std::span<const std::byte> bytes) {
  Event event;
  ForEachField(bytes, [&](uint64_t field, std::span<const std::byte> payload, double number) {
    if (field == 1) event.wall_time = number;
    if (field == 2) event.step = static_cast<int64_t>(number);
    if (field == 3) event.file_version = Text(payload);
    if (field == 7) {  // SessionLog; its status 1 is START
      ForEachField(payload, [&](uint64_t inner, std::span<const std::byte>, double status) {
        event.session_start |= inner == 1 && status == 1.0;
      });
    }
    if (field != 5) return;
    ForEachField(payload, [&](uint64_t, std::span<const std::byte> value, double) {
      std::string tag;
      float scalar = 0.0f;
      ForEachField(value, [&](uint64_t inner, std::span<const std::byte> text, double simple) {
        if (inner == 1) tag = Text(text);
        if (inner == 2) scalar = static_cast<float>(simple);
      });
      event.scalars[tag] = scalar;
    });
  });
  return event;
}

std::vector<Event> ReadEvents(const std::filesystem::path& path) {
  const std::vector<std::byte> file = ReadFile(path, kNoLimit).value();
  ByteReader reader(file);
  std::vector<Event> events;
  while (reader.remaining() > 0) {
    const std::span<const std::byte> length_bytes = reader.GetBytes(8);
    const auto length = ByteReader(length_bytes).Get<uint64_t>();
    EXPECT_EQ(reader.Get<uint32_t>(), MaskedCrc32c(length_bytes));
    const std::span<const std::byte> data = reader.GetBytes(length);
    EXPECT_EQ(reader.Get<uint32_t>(), MaskedCrc32c(data));
    if (!reader.ok()) break;
    events.push_back(ParseEvent(data));
  }
  EXPECT_TRUE(reader.ok());
  return events;
}

// All events of a folder in the order that TensorBoard reads them: file after file, by name.
std::vector<Event> ReadFolder(const std::filesystem::path& folder) {
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.insert(entry.path());
  std::vector<Event> events;
  for (const auto& file : files) {
    for (Event& event : ReadEvents(file)) events.push_back(std::move(event));
  }
  return events;
}

// The steps that TensorBoard shows: a session's start drops those from its own step on.
std::vector<int64_t> ShownSteps(const std::vector<Event>& events) {
  std::vector<int64_t> steps;
  for (const Event& event : events) {
    if (event.session_start) std::erase_if(steps, [&](int64_t step) { return step >= event.step; });
    if (!event.scalars.empty()) steps.push_back(event.step);
  }
  return steps;
}

TEST(TensorBoardWriter, WritesRecordsThatAReaderOfTheFormatUnderstands) {
  TemporaryFolder folder;
  auto writer = TensorBoardWriter::Create(folder.path() / "tensorboard", 250);
  ASSERT_TRUE(writer) << writer.error().message;
  const std::vector<TaggedScalar> scalars = {
      {"loss/critic", 0.25}, {"value/mean_q", -3.5}, {"broken", std::numeric_limits<double>::infinity()}};
  ASSERT_TRUE(writer->Add(300, 1234.5, scalars));
  ASSERT_TRUE(writer->Add(70000, 1235.5, {}));
  const std::vector<Event> events = ReadEvents(writer->path());
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events[0].file_version, "brain.Event:2");
  EXPECT_TRUE(events[1].session_start);
  EXPECT_EQ(events[1].step, 250);
  EXPECT_EQ(events[2].step, 300);
  EXPECT_EQ(events[2].wall_time, 1234.5);
  EXPECT_EQ(events[2].scalars,
            (std::map<std::string, float>{{"loss/critic", 0.25f}, {"value/mean_q", -3.5f}}));
  EXPECT_FALSE(events[2].session_start);
  EXPECT_EQ(events[3].step, 70000);
}

TEST(TensorBoardWriter, NameIsOneThatTensorBoardLooksFor) {
  TemporaryFolder folder;
  const auto writer = TensorBoardWriter::Create(folder.path(), 0);
  ASSERT_TRUE(writer);
  EXPECT_THAT(writer->path().filename().string(), testing::StartsWith("events.out.tfevents."));
}

TEST(TensorBoardWriter, IsReadAfterTheFilesThatAreThereWhateverTheClockSays) {
  TemporaryFolder folder;
  const auto earlier =
      folder.path() / "events.out.tfevents.9000000000.host.7";  // the clock is set back since
  std::ofstream(earlier).flush();
  const auto writer = TensorBoardWriter::Create(folder.path(), 0);
  ASSERT_TRUE(writer);
  const auto next = TensorBoardWriter::Create(folder.path(), 0);  // within the same second
  ASSERT_TRUE(next);
  EXPECT_LT(earlier, writer->path());
  EXPECT_LT(writer->path(), next->path());
}

FaultBoard& Faults() {
  static const SystemClock clock;
  static FaultBoard board(clock);
  return board;
}

constexpr std::array kScalars = {ScalarSpec{"fit", "loss/fit"}, ScalarSpec{"rarity", "toy/rarity"}};

TEST(TrainingLog, TableAndEventsAgreeAndAnIntervalWithoutUpdatesHasNoLosses) {
  TemporaryFolder folder;
  TrainingLog log(folder.path(), 25, kScalars, Faults());
  TrainingInterval interval;
  interval.updates = 50;
  interval.cpu_s = 7.5;
  interval.interval_updates = 25;
  interval.scalars = {0.125, std::nan("")};
  log.Add(interval, {.wall_time_s = 10.0, .interval_s = 0.5, .batch_bytes = 2e6, .replay_frames = 3000});
  interval.interval_updates = 0;
  interval.scalars = {std::nan(""), std::nan("")};
  log.Add(interval, {.wall_time_s = 10.5, .interval_s = 0.5});

  const std::string table = ReadTextFile(folder.path() / "logs" / "training.csv", kNoLimit).value();
  EXPECT_THAT(table,
              HasSubstr("wall_time_s,trained_s,cpu_s,updates,updates_per_s,fit,rarity,weights_version,"));
  EXPECT_THAT(table, HasSubstr("\n10,0,7.5,50,50,0.125,,0,"));
  EXPECT_THAT(table, HasSubstr("\n10.5,0,7.5,50,0,,,0,"));
  const auto file = std::filesystem::directory_iterator(folder.path() / "tensorboard")->path();
  const std::vector<Event> events = ReadEvents(file);
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events[2].scalars.at("loss/fit"), 0.125f);
  EXPECT_FALSE(events[2].scalars.contains("toy/rarity"));
  EXPECT_EQ(events[2].scalars.at("speed/batch_mb_per_s"), 4.0f);
  EXPECT_FALSE(events[3].scalars.contains("loss/fit"));
}

TEST(TrainingLog, StepsThatAKilledLearnerHadDoneAfterItsCheckpointAreShownOnce) {
  TemporaryFolder folder;
  const auto log_to = [&](uint64_t first, std::initializer_list<uint64_t> steps) {
    TrainingLog log(folder.path(), first, {}, Faults());
    for (const uint64_t step : steps) {
      TrainingInterval interval;
      interval.updates = step;
      log.Add(interval, {.wall_time_s = 1.0, .interval_s = 0.5});
    }
  };
  log_to(0, {10, 20, 30, 40});
  log_to(25, {28, 35, 45});  // its checkpoint was that of update 25
  EXPECT_EQ(ShownSteps(ReadFolder(folder.path() / "tensorboard")),
            (std::vector<int64_t>{10, 20, 28, 35, 45}));
}

TEST(TrainingLog, ItsTimesNeverGoBackWhenTheClockDoes) {
  TemporaryFolder folder;
  const auto add = [](TrainingLog& log, double wall_time_s) {
    log.Add(TrainingInterval{}, {.wall_time_s = wall_time_s, .interval_s = 0.5});
  };
  {
    TrainingLog log(folder.path(), 0, {}, Faults());
    add(log, 1795812345.125);
    add(log, 1795800000.0);
  }
  TrainingLog resumed(folder.path(), 0, {}, Faults());
  add(resumed, 1795800000.5);
  add(resumed, 1795812400.0);
  std::ifstream table(folder.path() / "logs" / "training.csv");
  std::vector<std::string> times;
  for (std::string row; std::getline(table, row);) times.push_back(row.substr(0, row.find(',')));
  EXPECT_EQ(times, (std::vector<std::string>{"wall_time_s", "1795812345.125", "1795812345.625",
                                             "1795812346.125", "1795812400"}));
}

// Rows that are whole, and events that an independent reader takes.
size_t WholeRows(const std::filesystem::path& run) {
  const auto table = ReadTextFile(run / "logs" / "training.csv", kNoLimit);
  return table && table->ends_with('\n') ? static_cast<size_t>(std::ranges::count(*table, '\n')) - 1 : 0;
}

TEST(TrainingLog, AFullDiskCostsRowsFromItsStartOnAndNothingHalfWrittenStays) {
  TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "run", "256k");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  disk.Fill();
  ManualClock clock;
  FaultBoard faults(clock);
  TrainingLog log(disk.path(), 0, {}, faults);
  TrainingInterval interval;
  const auto add = [&] {
    ++interval.updates;
    log.Add(interval, {.wall_time_s = static_cast<double>(interval.updates), .interval_s = 1.0});
  };
  add();
  ASSERT_TRUE(faults.Lasts(FaultKind::kTrainingLog));
  EXPECT_THAT(faults.Current().front().text, HasSubstr("free some disk space"));
  disk.Free();
  add();
  EXPECT_FALSE(faults.Lasts(FaultKind::kTrainingLog)) << "there is room again";
  disk.Fill();
  // What is left of the last block takes some.
  for (int i = 0; i < 1000 && !faults.Lasts(FaultKind::kTrainingLog); ++i) add();
  ASSERT_TRUE(faults.Lasts(FaultKind::kTrainingLog));
  disk.Free();
  const size_t rows = WholeRows(disk.path());
  const size_t steps = ShownSteps(ReadFolder(disk.path() / "tensorboard")).size();
  add();
  EXPECT_FALSE(faults.Lasts(FaultKind::kTrainingLog));
  EXPECT_EQ(WholeRows(disk.path()), rows + 1);
  EXPECT_EQ(ShownSteps(ReadFolder(disk.path() / "tensorboard")).size(), steps + 1);
}

}  // namespace
}  // namespace dadrl
