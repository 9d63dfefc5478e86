#include "sinew/cli/images/board_images.h"

#include <filesystem>

#include "sinew/io/file.h"

namespace sinew::cli {
namespace {

constexpr std::size_t kFileMost = 1 << 20;

}  // namespace

std::optional<BoardImage> image_in(std::string_view bytes) {
  return read_image({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

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
      if (io::exists(image_path(folder.string(), board))) return folder.string();
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
  return ImageFile{path, std::move(*bytes), image};
}

std::string image_path(const std::string& folder, const FlashBoard& board) {
  return folder + "/" + std::string(board.image) + ".bin";
}

std::expected<ImageFile, std::string> board_image(const std::string& folder,
                                                  const FlashBoard& board) {
  const std::string path = image_path(folder, board);
  const std::string anew = ": make firmware builds it anew";
  auto file = image_file(path);
  if (!file) return std::unexpected(file.error() + anew);
  const auto& image = file->image;
  if (!image) return std::unexpected(path + ": " + std::string(kNoLabel) + anew);
  const bool right = image->board_name() == board.image && image->size == file->bytes.size() &&
                     image->size <= board.size;
  if (right) return file;
  return std::unexpected(path + ": it is not the whole image of a " + std::string(board.image) +
                         anew);
}

}  // namespace sinew::cli
