#include "common/io/unnamed_file.h"

#include <gtest/gtest.h>

#include <fstream>

namespace dadrl {
namespace {

TEST(OpenUnnamedFile, IsReadThroughItsPathWhileItLives) {
  std::filesystem::path path;
  {
    const auto file = OpenUnnamedFile("test");
    ASSERT_TRUE(file);
    path = UnnamedFilePath(*file);
    const std::string text = "what was written";
    ASSERT_TRUE(WriteAll(*file, std::as_bytes(std::span(text)), path));
    std::string read;
    std::getline(std::ifstream(path), read);
    EXPECT_EQ(read, text);
  }
  EXPECT_FALSE(std::ifstream(path).good());
}

}  // namespace
}  // namespace dadrl
