#include "sinew/cli/boards/board_images.h"

#include <filesystem>

#include "sinew/cli/boards/flash_tools.h"
#include "sinew/io/file.h"

namespace sinew::cli {
namespace {

constexpr std::size_t kFileMost = 1 << 20;

std::optional<BoardImage> image_in(std::string_view bytes) {
  return read_image({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

}  // namespace

std::expected<std::string, std::string> images_folder(const std::string& asked) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!asked.empty()) {
    if (fs::is_directory(asked, error)) return asked;
    return std::unexpected("--images: " + asked + ": no such folder");
  }
  const fs::path own = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& folder : {own.parent_path() / "firmware", own / "firmware"}) {
    for (const FlashBoard& board : flash_boards()) {
      if (fs::exists(folder / (std::string(board.image) + ".bin"), error)) return folder.string();
    }
  }
  return std::unexpected(
      "no images are beside this program: make firmware builds them, and --images names their "
      "folder");
}

std::expected<ImageFile, std::string> image_file(const std::string& path) {
  auto bytes = io::read_file(path, kFileMost);
  if (!bytes) return std::unexpected(bytes.error().sentence);
  const auto image = image_in(*bytes);
  if (!image) return std::unexpected(path + ": nothing in it says that it is an image of a board");
  return ImageFile{path, std::move(*bytes), *image};
}

std::expected<std::vector<ImageFile>, std::string> images_in(const std::string& folder) {
  std::vector<ImageFile> files;
  for (const FlashBoard& board : flash_boards()) {
    const std::string path = folder + "/" + std::string(board.image) + ".bin";
    if (!io::exists(path)) continue;
    auto file = image_file(path);
    const std::string anew = ": make firmware builds it anew";
    if (!file) return std::unexpected(file.error() + anew);
    const bool right = file->image.board_name() == board.image &&
                       file->image.size == file->bytes.size() && file->image.size <= board.size;
    if (!right) {
      return std::unexpected(path + ": it is not the whole image of a " + std::string(board.image) +
                             anew);
    }
    files.push_back(std::move(*file));
  }
  return files;
}

}  // namespace sinew::cli
