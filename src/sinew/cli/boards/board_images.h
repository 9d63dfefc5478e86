#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/wire/board_image.h"

namespace sinew::cli {

/// An image of a board, as a file.
struct ImageFile {
  std::string path;
  std::string bytes;
  BoardImage image;
};

/// Where images are looked for: `asked`, else beside this program, as they are built and released.
/// @error  a sentence: no folder, and how to make one
std::expected<std::string, std::string> images_folder(const std::string& asked);

/// Those of all boards in that folder, by their names.
/// @error  a sentence that names the file: it cannot be read, or is not what its name says
std::expected<std::vector<ImageFile>, std::string> images_in(const std::string& folder);

/// @error  a sentence that names the file: it cannot be read, or is no image
std::expected<ImageFile, std::string> image_file(const std::string& path);

}  // namespace sinew::cli
