#include "sinew/runtime/cameras/read_picture.h"

#include "sinew/io/file.h"
#include "sinew/vision/picture_file.h"

namespace sinew::runtime {

std::expected<vision::Picture, std::string> read_picture(const std::string& path,
                                                         std::size_t bytes_max) {
  const auto file = io::read_file(path, bytes_max);
  if (!file) return std::unexpected(file.error().sentence);
  auto picture =
      vision::decode_picture({reinterpret_cast<const std::uint8_t*>(file->data()), file->size()});
  if (!picture) return std::unexpected(path + ": " + picture.error());
  return picture;
}

}  // namespace sinew::runtime
