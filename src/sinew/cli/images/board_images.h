#pragma once

#include <expected>
#include <optional>
#include <string>
#include <string_view>

#include "sinew/cli/images/flash_boards.h"
#include "sinew/wire/board_image.h"

namespace sinew::cli {

/// Said of a file without a label.
inline constexpr std::string_view kNoLabel = "nothing in it says that it is an image of a board";

/// A file that may be an image of a board.
struct ImageFile {
  std::string path;
  std::string bytes;
  std::optional<BoardImage> image;  ///< nothing: the file has no label
};

/// Identity of bytes that begin with an image; nothing without a label.
std::optional<BoardImage> image_in(std::string_view bytes);

/// Where images are looked for: `asked`, else beside this program, as they are built and released.
/// @error  a sentence: no folder, and how to make one
std::expected<std::string, std::string> images_folder(const std::string& asked);

/// @error  a sentence: the file cannot be read
std::expected<ImageFile, std::string> image_file(const std::string& path);

/// A board's image file in a folder.
std::string image_path(const std::string& folder, const FlashBoard& board);
/// Its content, with the label of that board.
/// @error  a sentence: the file cannot be read, or is not the whole image of that board
std::expected<ImageFile, std::string> board_image(const std::string& folder,
                                                  const FlashBoard& board);

}  // namespace sinew::cli
