#include "sinew/vision/picture_file.h"

#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string_view>

#include "sinew/core/assert.h"
#include "sinew/vision/byte_text.h"
#include "sinew/vision/exif.h"

namespace sinew::vision {
namespace {

using Decoded = std::expected<Picture, std::string>;

std::optional<std::string> size_trouble(std::int64_t width, std::int64_t height) {
  if (width < 1 || height < 1) return "a picture without pixels";
  if (width <= kPixelsMax / height) return std::nullopt;
  return "a picture of " + std::to_string(width) + " x " + std::to_string(height) +
         " pixels; at most " + std::to_string(kPixelsMax / 1'000'000) + " million are read";
}

struct FreeJpeg {
  void operator()(void* handle) const { tjDestroy(handle); }
};

/// Ink of the four colours, which Adobe's files store the other way round, and all others too.
Picture from_inks(const std::vector<std::uint8_t>& inks, int width, int height) {
  Picture picture = black_picture(width, height);
  for (std::size_t i = 0; i < picture.rgb.size() / 3; ++i) {
    const int black = inks[4 * i + 3];
    for (std::size_t c = 0; c < 3; ++c) {
      picture.rgb[3 * i + c] = static_cast<std::uint8_t>((inks[4 * i + c] * black + 127) / 255);
    }
  }
  return picture;
}

Decoded decode_jpeg(Bytes file) {
  const std::unique_ptr<void, FreeJpeg> jpeg(tjInitDecompress());
  if (!jpeg) return std::unexpected("there is no memory for it");
  const auto broken = [&] {
    return std::unexpected(std::string("a JPEG file that is broken: ") +
                           tjGetErrorStr2(jpeg.get()));
  };
  const auto size = static_cast<unsigned long>(file.size());
  int width = 0;
  int height = 0;
  int sampling = 0;
  int colours = 0;
  if (tjDecompressHeader3(jpeg.get(), file.data(), size, &width, &height, &sampling, &colours) !=
      0) {
    return broken();
  }
  if (auto trouble = size_trouble(width, height)) return std::unexpected(std::move(*trouble));
  const bool inks = colours == TJCS_CMYK || colours == TJCS_YCCK;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::uint8_t> out((inks ? 4 : 3) * pixels);
  const int done =
      tjDecompress2(jpeg.get(), file.data(), size, out.data(), width, 0, height,
                    inks ? TJPF_CMYK : TJPF_RGB, TJFLAG_LIMITSCANS | TJFLAG_ACCURATEDCT);
  // Cameras leave a few bytes too many here and there. Half a picture is none: cubes in its other
  // half would be missing without a word.
  const bool whole =
      std::string_view(tjGetErrorStr2(jpeg.get())).find("Premature end") == std::string_view::npos;
  if (done != 0 && (tjGetErrorCode(jpeg.get()) != TJERR_WARNING || !whole)) return broken();
  return inks ? from_inks(out, width, height) : Picture{width, height, std::move(out)};
}

Decoded decode_png(Bytes file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const auto broken = [&] {
    std::string why = std::string("a PNG file that is broken: ") + image.message;
    png_image_free(&image);
    return std::unexpected(std::move(why));
  };
  if (png_image_begin_read_from_memory(&image, file.data(), file.size()) == 0) return broken();
  if (auto trouble = size_trouble(image.width, image.height)) {
    png_image_free(&image);
    return std::unexpected(std::move(*trouble));
  }
  image.format = PNG_FORMAT_RGB;
  image.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
  Picture picture = black_picture(static_cast<int>(image.width), static_cast<int>(image.height));
  const png_color white{255, 255, 255};
  if (png_image_finish_read(&image, &white, picture.rgb.data(), 0, nullptr) == 0) return broken();
  return picture;
}

/// What else people have: a name for it, and nothing where it is unknown.
std::string_view other_kind(Bytes file) {
  struct Kind {
    std::size_t at;
    std::string_view mark;
    std::string_view name;
  };
  constexpr std::array<Kind, 8> kKinds{{{0, "BM", "BMP"},
                                        {0, "GIF8", "GIF"},
                                        {8, "WEBP", "WebP"},
                                        {4, "ftyphe", "HEIC"},
                                        {4, "ftypmif1", "HEIC"},
                                        {4, "ftypavif", "AVIF"},
                                        {0, "II*", "TIFF"},
                                        {0, std::string_view("MM\0*", 4), "TIFF"}}};
  const auto known = std::ranges::find_if(
      kKinds, [&](const Kind& kind) { return has_at(file, kind.at, kind.mark); });
  return known != kKinds.end() ? known->name : std::string_view();
}

}  // namespace

Decoded decode_picture(Bytes file) {
  if (file.empty()) return std::unexpected("an empty file");
  const bool jpeg = has_at(file, 0, "\xFF\xD8");
  const bool png = has_at(file, 0, "\x89PNG\r\n\x1A\n");
  if (!jpeg && !png) {
    const std::string_view kind = other_kind(file);
    return std::unexpected(kind.empty() ? std::string("no picture; JPEG and PNG files are read")
                                        : "a picture of the kind " + std::string(kind) +
                                              "; JPEG and PNG files are read");
  }
  Decoded picture = jpeg ? decode_jpeg(file) : decode_png(file);
  if (!picture) return picture;
  return upright(std::move(*picture), orientation_of_file(file));
}

std::vector<std::uint8_t> encode_jpeg(const Picture& picture, int quality) {
  const std::unique_ptr<void, FreeJpeg> jpeg(tjInitCompress());
  SINEW_ASSERT(jpeg != nullptr);
  std::vector<std::uint8_t> file(tjBufSize(picture.width, picture.height, TJSAMP_420));
  unsigned char* out = file.data();
  unsigned long size = file.size();
  const int done = tjCompress2(jpeg.get(), picture.rgb.data(), picture.width, 0, picture.height,
                               TJPF_RGB, &out, &size, TJSAMP_420, quality, TJFLAG_NOREALLOC);
  SINEW_ASSERT(done == 0);  // it has a size, and room
  file.resize(size);
  return file;
}

std::vector<std::uint8_t> encode_png(const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> file(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t size = file.size();
  const int written =
      png_image_write_to_memory(&image, file.data(), &size, 0, picture.rgb.data(), 0, nullptr);
  SINEW_ASSERT(written != 0);  // the bytes are there, and room for the largest file
  file.resize(size);
  return file;
}

}  // namespace sinew::vision
