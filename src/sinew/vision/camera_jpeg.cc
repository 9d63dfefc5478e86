#include "sinew/vision/camera_jpeg.h"

#include <turbojpeg.h>

#include <memory>
#include <string_view>

#include "sinew/vision/byte_text.h"
#include "sinew/vision/exif.h"
#include "sinew/vision/picture_file.h"

namespace sinew::vision {
namespace {

struct FreeDecoder {
  void operator()(void* handle) const { tjDestroy(handle); }
};

/// Whether what the decoder complains of leaves every pixel as it was: many webcams fill up their
/// scans with a few bytes that mean nothing. Of several complaints it keeps the first.
bool is_harmless(void* jpeg) {
  return tjGetErrorCode(jpeg) == TJERR_WARNING &&
         std::string_view(tjGetErrorStr2(jpeg)).contains("extraneous bytes before marker");
}

}  // namespace

std::expected<Picture, std::string> decode_camera_jpeg(Bytes frame) {
  if (!has_at(frame, 0, "\xFF\xD8")) return std::unexpected("a frame that is no JPEG");
  const std::unique_ptr<void, FreeDecoder> jpeg(tjInitDecompress());
  if (!jpeg) return std::unexpected("there is no memory for a frame");
  const auto damaged = [&] {
    return std::unexpected(std::string("a JPEG frame that is damaged: ") +
                           tjGetErrorStr2(jpeg.get()));
  };
  const auto size = static_cast<unsigned long>(frame.size());
  int width = 0;
  int height = 0;
  int sampling = 0;
  int colours = 0;
  if (tjDecompressHeader3(jpeg.get(), frame.data(), size, &width, &height, &sampling, &colours) !=
          0 &&
      !is_harmless(jpeg.get())) {
    return damaged();
  }
  if (width < 1 || height < 1 || width > kPixelsMax / height) {
    return std::unexpected("a JPEG frame of " + std::to_string(width) + " x " +
                           std::to_string(height) + " pixels; at most " +
                           std::to_string(kPixelsMax / 1'000'000) + " million are read");
  }
  Picture picture = black_picture(width, height);
  if (tjDecompress2(jpeg.get(), frame.data(), size, picture.rgb.data(), width, 0, height, TJPF_RGB,
                    TJFLAG_LIMITSCANS | TJFLAG_ACCURATEDCT) != 0 &&
      !is_harmless(jpeg.get())) {
    return damaged();
  }
  return upright(std::move(picture), orientation_of_file(frame));
}

}  // namespace sinew::vision
