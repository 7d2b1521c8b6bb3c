#include "actor/render/rasterize.h"

#include <cairo.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "actor/render/picture.h"
#include "tests/actor/render/test_recordings.h"

namespace dadrl {
namespace {

struct Release {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};

class Image {
 public:
  explicit Image(const std::vector<std::byte>& png) : rest_(png) {
    surface_.reset(cairo_image_surface_create_from_png_stream(&Image::Read, this));
  }
  bool ok() const { return cairo_surface_status(surface_.get()) == CAIRO_STATUS_SUCCESS; }
  int width() const { return cairo_image_surface_get_width(surface_.get()); }
  int height() const { return cairo_image_surface_get_height(surface_.get()); }
  // 0xRRGGBB
  uint32_t Pixel(int x, int y) const {
    uint32_t value = 0;
    std::memcpy(&value,
                cairo_image_surface_get_data(surface_.get()) +
                    y * cairo_image_surface_get_stride(surface_.get()) + 4 * x,
                sizeof value);
    return value & 0xffffffU;
  }

 private:
  static cairo_status_t Read(void* self, unsigned char* out, unsigned int length) {
    auto& rest = static_cast<Image*>(self)->rest_;
    if (rest.size() < length) return CAIRO_STATUS_READ_ERROR;
    std::memcpy(out, rest.data(), length);
    rest = rest.subspan(length);
    return CAIRO_STATUS_SUCCESS;
  }

  std::span<const std::byte> rest_;
  std::unique_ptr<cairo_surface_t, Release> surface_;
};

TEST(RasterizePng, DrawsAtThePicturesOwnSize) {
  const auto png = RasterizePng(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="30" height="20"><rect width="30" height="20" fill="#ff0000"/><rect x="10" width="5" height="20" fill="#0000ff"/></svg>)");
  ASSERT_TRUE(png) << png.error().message;
  const Image image(*png);
  ASSERT_TRUE(image.ok());
  EXPECT_EQ(image.width(), 30);
  EXPECT_EQ(image.height(), 20);
  EXPECT_EQ(image.Pixel(3, 10), 0xff0000U);
  EXPECT_EQ(image.Pixel(12, 10), 0x0000ffU);
}

TEST(RasterizePng, SaysWhatItCannotRead) {
  const auto png = RasterizePng("<svg xmlns='http://www.w3.org/2000/svg'><rect");
  ASSERT_FALSE(png);
  EXPECT_EQ(png.error().code, ErrorCode::kInternal);
  EXPECT_NE(png.error().message.find("cannot be drawn"), std::string::npos);
}

TEST(RasterizePng, TheEgoIsBlueInTheMiddleOfTheScene) {
  const auto png = RasterizePng(FramePicture(test::StraightDrive(4), 2));
  ASSERT_TRUE(png) << png.error().message;
  const Image image(*png);
  ASSERT_TRUE(image.ok());
  // The scene's box is 848 x 540 at (16, 52); left of the middle is the ego's roof, right its windscreen.
  EXPECT_EQ(image.Pixel(16 + 424 - 4, 52 + 270), 0x0072b2U);
}

}  // namespace
}  // namespace dadrl
