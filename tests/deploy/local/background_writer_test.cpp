#include "deploy/local/background_writer.h"

#include <gmock/gmock.h>

#include <semaphore>
#include <vector>

namespace dadrl {
namespace {

using testing::ElementsAre;

// A disk that takes as long as the test wants; its owner outlives the writer.
struct SlowDisk {
  Status Write(const std::string& content) {
    begun.release();
    go_on.acquire();
    written.push_back(content);
    return full ? Fail(ErrorCode::kExhausted, "full") : Status();
  }
  BackgroundWriter::Writing Writing() {
    return [this](const std::string& content) { return Write(content); };
  }
  std::counting_semaphore<> begun{0};
  std::counting_semaphore<> go_on{0};
  std::vector<std::string> written;
  bool full = false;
};

TEST(BackgroundWriter, NobodyWaitsForASlowDiskAndTheNewestContentGetsThere) {
  SlowDisk disk;
  BackgroundWriter writer(disk.Writing());
  EXPECT_TRUE(writer.Finish()) << "nothing was asked for";
  writer.Write("first");
  disk.begun.acquire();
  for (const char* content : {"second", "third", "fourth"}) writer.Write(content);
  disk.go_on.release(2);
  EXPECT_TRUE(writer.Finish());
  EXPECT_THAT(disk.written, ElementsAre("first", "fourth"));
}

TEST(BackgroundWriter, ItsEndFinishesWhatWasAskedFor) {
  SlowDisk disk;
  disk.go_on.release();
  BackgroundWriter(disk.Writing()).Write("last");
  EXPECT_THAT(disk.written, ElementsAre("last"));
}

TEST(BackgroundWriter, AFailureIsToldAndTheNextContentIsAnotherTry) {
  SlowDisk disk;
  disk.go_on.release(2);
  disk.full = true;
  BackgroundWriter writer(disk.Writing());
  writer.Write("some");
  EXPECT_EQ(writer.Finish().error().code, ErrorCode::kExhausted);
  EXPECT_FALSE(writer.last());
  disk.full = false;
  writer.Write("more");
  EXPECT_TRUE(writer.Finish());
  EXPECT_TRUE(writer.last());
}

}  // namespace
}  // namespace dadrl
