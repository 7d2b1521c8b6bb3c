#include "common/io/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/io/read_file.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr uint64_t kMaxBytes = 1 << 20;

class NpyTest : public testing::Test {
 protected:
  // A file with this header text and these bytes behind it.
  void Write(const std::string& text, size_t value_bytes, char format = 1) {
    std::string file = std::string("\x93NUMPY") + format + '\0';
    const auto length = static_cast<uint32_t>(text.size());
    file.append(reinterpret_cast<const char*>(&length), format == 1 ? 2 : 4);
    file += text + std::string(value_bytes, '\0');
    WritePlainly(path_, std::as_bytes(std::span(file)));
  }
  Error ErrorOf() {
    const auto array = ReadNpy<float>(path_, kMaxBytes);
    return array ? Error{} : array.error();
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "a.npy";
};

TEST_F(NpyTest, ReadsBackWhatItWrote) {
  const std::vector<float> floats = {0.5f, -1.25f, 3e-20f, 1e20f, 0.0f, 7.0f};
  ASSERT_TRUE(WriteNpy<float>(path_, std::vector<size_t>{2, 3}, floats));
  const auto read = ReadNpy<float>(path_, kMaxBytes);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_THAT(read->shape, ElementsAre(2, 3));
  EXPECT_EQ(read->values, floats);
  const std::vector<int64_t> numbers = {-5};
  ASSERT_TRUE(WriteNpy<int64_t>(path_, std::vector<size_t>{1}, numbers));
  EXPECT_EQ(ReadNpy<int64_t>(path_, kMaxBytes)->values, numbers);
  ASSERT_TRUE(WriteNpy<uint8_t>(path_, std::vector<size_t>{0, 4}, {}));
  EXPECT_THAT(ReadNpy<uint8_t>(path_, kMaxBytes)->shape, ElementsAre(0, 4));
}

// What numpy.save(file, numpy.zeros(3, numpy.float32)) writes (NumPy 1.24), byte for byte.
TEST_F(NpyTest, HeaderIsNumPys) {
  std::string expected =
      std::string("\x93NUMPY\x01\x00v\x00", 10) + "{'descr': '<f4', 'fortran_order': False, 'shape': (3,), }";
  expected.resize(127, ' ');
  EXPECT_EQ(NpyHeader("<f4", std::vector<size_t>{3}), expected + '\n');
  EXPECT_EQ(NpyType<double>() + NpyType<uint16_t>() + NpyType<int8_t>(), "<f8<u2|i1");
}

TEST_F(NpyTest, ReadsEveryWayToWriteAHeader) {
  for (const char format : {1, 2, 3}) {
    Write("{\"shape\":(2,),'descr':'<f4' , 'fortran_order':False}\n", 8, format);
    const auto read = ReadNpy<float>(path_, kMaxBytes);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_THAT(read->shape, ElementsAre(2));
  }
  Write("{'descr': '<f4', 'fortran_order': False, 'shape': (), }", 4);
  EXPECT_TRUE(ReadNpy<float>(path_, kMaxBytes)->shape.empty());
}

TEST_F(NpyTest, AnotherTypeOrOrderIsRefusedWithTheRemedy) {
  Write("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }", 16);
  EXPECT_EQ(ErrorOf().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(ErrorOf().message, HasSubstr("type '<f8', '<f4' is needed: a.astype('<f4')"));
  Write("{'descr': '>f4', 'fortran_order': False, 'shape': (2,), }", 8);
  EXPECT_THAT(ErrorOf().message, HasSubstr("'>f4'"));
  Write("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 2), }", 16);
  EXPECT_EQ(ErrorOf().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(ErrorOf().message, HasSubstr("numpy.ascontiguousarray"));
}

TEST_F(NpyTest, BadHeadersAreCorrupt) {
  for (const char* text :
       {"", "{", "{}", "{'descr': '<f4'}", "{'descr': '<f4', 'fortran_order': False, 'shape': (2}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (2 2), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (-2,), }",
        "{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (2,), }",
        "{'descr': '<f4', 'fortran_order': 0, 'shape': (2,), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (2,), 'more': 'x'}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (2,), } x",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999,), }"}) {
    Write(text, 8);
    EXPECT_EQ(ErrorOf().code, ErrorCode::kCorrupt) << text;
    EXPECT_THAT(ErrorOf().message, HasSubstr(path_.string()));
  }
  Write("{'descr': '<f4', 'fortran_order': False, 'shape': (2,), }", 8, 4);
  EXPECT_THAT(ErrorOf().message, HasSubstr("format 4"));
}

TEST_F(NpyTest, ShapeAndLengthMustAgree) {
  Write("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", 20);
  EXPECT_EQ(ErrorOf().code, ErrorCode::kCorrupt);
  EXPECT_THAT(ErrorOf().message, HasSubstr("20 bytes behind the header, shape (2, 3) has 24"));
  Write("{'descr': '<f4', 'fortran_order': False, 'shape': (4294967296, 4294967296), }", 0);
  EXPECT_EQ(ErrorOf().code, ErrorCode::kCorrupt) << "the product overflows";
}

TEST_F(NpyTest, EveryTruncationIsCorrupt) {
  ASSERT_TRUE(WriteNpy<float>(path_, std::vector<size_t>{3}, std::vector<float>{1, 2, 3}));
  const std::vector<std::byte> good = ReadFile(path_, kMaxBytes).value();
  for (size_t length = 0; length < good.size(); ++length) {
    WritePlainly(path_, std::span(good).first(length));
    ASSERT_EQ(ErrorOf().code, ErrorCode::kCorrupt) << length;
  }
}

TEST_F(NpyTest, MissingAndOversizedFilesAreNamed) {
  EXPECT_EQ(ErrorOf().code, ErrorCode::kNotFound);
  ASSERT_TRUE(WriteNpy<float>(path_, std::vector<size_t>{3}, std::vector<float>{1, 2, 3}));
  const auto read = ReadNpy<float>(path_, 100);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kExhausted);
  EXPECT_THAT(read.error().message, HasSubstr(path_.string()));
}

}  // namespace
}  // namespace dadrl
