#include "sinew/cli/picture_argument.h"

#include <cmath>

#include "sinew/io/file.h"
#include "sinew/vision/picture_file.h"

namespace sinew::cli {

std::expected<vision::Picture, std::string> read_picture(const std::string& path) {
  constexpr std::size_t kFileMax = std::size_t{256} << 20U;  // a PNG of all pixels that are read
  const auto file = io::read_file(path, kFileMax);
  if (!file) return std::unexpected(file.error().sentence);
  auto picture =
      vision::decode_picture({reinterpret_cast<const std::uint8_t*>(file->data()), file->size()});
  if (!picture) return std::unexpected(path + ": " + picture.error());
  return picture;
}

Json pixel_json(vision::Pixel p) {
  return {std::round(10 * p.x) / 10, std::round(10 * p.y) / 10};
}

}  // namespace sinew::cli
