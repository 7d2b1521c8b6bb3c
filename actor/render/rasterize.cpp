#include "actor/render/rasterize.h"

#include <cairo.h>
#include <librsvg/rsvg.h>

#include <cmath>
#include <memory>
#include <string>

namespace dadrl {
namespace {

struct Release {
  void operator()(RsvgHandle* handle) const { g_object_unref(handle); }
  void operator()(GError* error) const { g_error_free(error); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};
template <typename T>
using Owned = std::unique_ptr<T, Release>;

std::string TakeMessage(GError* error) {
  const Owned<GError> owned(error);
  return owned ? owned->message : "no reason given";
}

cairo_status_t AppendBytes(void* bytes, const unsigned char* data, unsigned int length) {
  const auto* begin = reinterpret_cast<const std::byte*>(data);
  auto& out = *static_cast<std::vector<std::byte>*>(bytes);
  out.insert(out.end(), begin, begin + length);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

Result<std::vector<std::byte>> RasterizePng(std::string_view svg, double zoom) {
  GError* error = nullptr;
  const Owned<RsvgHandle> handle(
      rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(svg.data()), svg.size(), &error));
  if (!handle) return Fail(ErrorCode::kInternal, "the picture cannot be drawn: {}", TakeMessage(error));
  double width = 0.0;
  double height = 0.0;
  if (rsvg_handle_get_intrinsic_size_in_pixels(handle.get(), &width, &height) == FALSE) {
    return Fail(ErrorCode::kInternal, "the picture cannot be drawn: it has no size in pixels");
  }
  const Owned<cairo_surface_t> surface(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(std::ceil(width * zoom)),
                                 static_cast<int>(std::ceil(height * zoom))));
  const Owned<cairo_t> context(cairo_create(surface.get()));
  const RsvgRectangle page{0.0, 0.0, width * zoom, height * zoom};
  if (rsvg_handle_render_document(handle.get(), context.get(), &page, &error) == FALSE) {
    return Fail(ErrorCode::kInternal, "the picture cannot be drawn: {}", TakeMessage(error));
  }
  std::vector<std::byte> png;
  const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), AppendBytes, &png);
  if (status != CAIRO_STATUS_SUCCESS) {
    return Fail(ErrorCode::kInternal, "the picture cannot be drawn: {}", cairo_status_to_string(status));
  }
  return png;
}

}  // namespace dadrl
