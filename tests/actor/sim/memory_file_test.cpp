#include "actor/sim/memory_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace dadrl {
namespace {

std::string Slurp(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(MemoryFile, IsReadThroughItsPath) {
  auto file = MemoryFile::Create("test");
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->Write("a long first text"));
  EXPECT_EQ(Slurp(file->path()), "a long first text");
  ASSERT_TRUE(file->Write("short"));
  EXPECT_EQ(Slurp(file->path()), "short");
  EXPECT_EQ(file->Read(), "short");
}

TEST(MemoryFile, VanishesWithItsOwner) {
  std::string path;
  {
    auto file = MemoryFile::Create("test");
    ASSERT_TRUE(file);
    path = file->path();
    ASSERT_TRUE(std::ifstream(path).good());
  }
  EXPECT_FALSE(std::ifstream(path).good());
}

}  // namespace
}  // namespace dadrl
