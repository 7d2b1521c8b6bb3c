#include "common/dds/cluster_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/io/run_key.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl::dds {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class ClusterKey : public ::testing::Test {
 protected:
  const TemporaryFolder run_;
  ClusterConfig cluster_;
};

TEST_F(ClusterKey, IsThatOfTheRunOnLoopback) {
  const std::string key = EnsureRunKey(run_.path()).value();
  EXPECT_EQ(LoadClusterKey(run_.path(), cluster_).value(), key);
  cluster_.host = "localhost";
  EXPECT_EQ(LoadClusterKey(run_.path(), cluster_).value(), key);
}

TEST_F(ClusterKey, WithoutItsFileNobodyTakesPart) {
  const auto missing = LoadClusterKey(run_.path(), cluster_);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message,
              AllOf(HasSubstr(RunKeyFile(run_.path()).string()), HasSubstr("on 127.0.0.1"),
                    HasSubstr("dadrl train --resume --run-dir " + run_.path().string())));
  std::filesystem::create_symlink("elsewhere", RunKeyFile(run_.path()));
  EXPECT_FALSE(LoadClusterKey(run_.path(), cluster_)) << "a link";
}

TEST_F(ClusterKey, IsAskedForElsewhereOnlyWhenItIsRequired) {
  cluster_.host = "192.0.2.1";
  EXPECT_EQ(LoadClusterKey(run_.path(), cluster_).value(), "");
  cluster_.require_key = true;
  const auto missing = LoadClusterKey(run_.path(), cluster_);
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message, HasSubstr("cluster.require_key"));
}

}  // namespace
}  // namespace dadrl::dds
