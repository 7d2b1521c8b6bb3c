#include "common/liveness/beat_page.h"

#include <gmock/gmock.h>
#include <sys/mman.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "common/liveness/working_thread.h"
#include "deploy/local/child_process.h"
#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;
using ::testing::StartsWith;

// This process beats on a page of its own: what a supervisor would see of it.
const BeatRecord* RecordOf(std::string_view name) {
  for (const BeatRecord& record : BeatMemoryOfThisProcess().threads) {
    if (record.thread.load() == gettid() && std::string_view(record.name.data()) == name) return &record;
  }
  return nullptr;
}

TEST(WorkingThread, BeatsForAsLongAsItLives) {
  {
    const WorkingThread working("train");
    const BeatRecord* const record = RecordOf("train");
    ASSERT_NE(record, nullptr);
    const uint64_t before = record->beats;
    Beat();
    Beat();
    EXPECT_EQ(record->beats, before + 2);
  }
  EXPECT_EQ(RecordOf("train"), nullptr);
  Beat();  // nobody's: nothing happens
}

TEST(WorkingThread, DeclaresLongWorkAndTakesItBack) {
  const WorkingThread working("ingest");
  const BeatRecord* const record = RecordOf("ingest");
  ASSERT_NE(record, nullptr);
  EXPECT_EQ(record->limit_ms, 0u);
  {
    const LongWork storing(2s);
    EXPECT_EQ(record->limit_ms, 2000u);
    {
      const Resting resting;
      EXPECT_EQ(record->limit_ms, BeatRecord::kResting);
    }
    EXPECT_EQ(record->limit_ms, 2000u);
  }
  EXPECT_EQ(record->limit_ms, 0u);
}

TEST(WorkingThread, MoreThreadsThanThePageHoldsWorkUnwatched) {
  std::vector<std::thread> threads;
  std::atomic<bool> stop{false};
  for (size_t i = 0; i < BeatMemory::kThreads + 3; ++i) {
    threads.emplace_back([&] {
      const WorkingThread working("a name that is longer than the page takes");
      const LongWork work(1s);
      while (!stop) Beat();
    });
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(RecordOf("train"), nullptr);
}

// What a process of ours does on the page it inherited, seen from the other end.
class BeatPageTest : public testing::Test {
 protected:
  BeatPage page_ = std::move(BeatPage::Create().value());
  BeatMemory* const child_ = static_cast<BeatMemory*>(
      mmap(nullptr, sizeof(BeatMemory), PROT_READ | PROT_WRITE, MAP_SHARED, page_.fd(), 0));
  ~BeatPageTest() override { munmap(child_, sizeof(BeatMemory)); }
};

TEST_F(BeatPageTest, ShowsWhoWorksAndHowLongTheyMayBeSilent) {
  EXPECT_THAT(page_.Threads(), IsEmpty());
  BeatRecord& record = child_->threads[3];
  std::copy_n("train", 6, record.name.data());
  record.beats = 17;
  record.limit_ms = 1500;
  record.thread = 42;
  child_->threads[4].thread = -1;  // just being claimed
  const std::vector<BeatPage::Thread> threads = page_.Threads();
  ASSERT_EQ(threads.size(), 1u);
  EXPECT_EQ(threads[0].id, 42);
  EXPECT_EQ(threads[0].name, "train");
  EXPECT_EQ(threads[0].beats, 17u);
  EXPECT_EQ(threads[0].limit, 1500ms);
  EXPECT_FALSE(threads[0].resting);
}

TEST_F(BeatPageTest, ReadsBoundedWhateverTheProcessWrites) {
  for (BeatRecord& record : child_->threads) {
    record.thread = 1;
    record.name.fill('x');
  }
  for (std::atomic<char>& c : child_->fault) c = 'x';
  EXPECT_EQ(page_.Threads().size(), BeatMemory::kThreads);
  EXPECT_EQ(page_.Threads()[0].name.size(), child_->threads[0].name.size());
  EXPECT_EQ(page_.Fault().size(), child_->fault.size());
  child_->fault_version = 1;  // never finished
  EXPECT_EQ(page_.Fault(), "");
}

TEST(ReportFault, IsReadWholeAndTakenBack) {
  // Through this process's own page, as its supervisor would map it.
  BeatMemory& memory = BeatMemoryOfThisProcess();
  const auto text = [&] {
    std::string read;
    for (const std::atomic<char>& c : memory.fault) {
      if (c == '\0') break;
      read += c;
    }
    return read;
  };
  ReportFault("cannot store experience:\nno space");
  EXPECT_EQ(text(), "cannot store experience: no space");
  ReportFault(std::string(1000, 'x'));
  EXPECT_EQ(text().size(), memory.fault.size() - 1);
  ReportFault("");
  EXPECT_EQ(text(), "");
  EXPECT_EQ(memory.fault_version % 2, 0u);
}

TEST_F(BeatPageTest, IsInheritedByAChildAndByNobodyElse) {
  const TemporaryFolder folder;
  const auto log = folder.path() / "log";
  const auto list = [&](int beats_fd) {
    std::filesystem::remove(log);
    auto child = ChildProcess::Spawn({.command = {"/bin/sh", "-c",
                                                  "echo variable=$DADRL_BEATS; for fd in /proc/self/fd/*; do "
                                                  "readlink $fd; done | grep -c beats"},
                                      .log = log,
                                      .beats_fd = beats_fd});
    EXPECT_TRUE(child);
    EXPECT_TRUE(child->Wait(20s));
    return FileText(log);
  };
  EXPECT_EQ(list(-1), "variable=\n0\n");
  EXPECT_EQ(list(page_.fd()), fmt::format("variable={}\n1\n", page_.fd()));
}

}  // namespace
}  // namespace dadrl
