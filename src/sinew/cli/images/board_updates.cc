#include "sinew/cli/images/board_updates.h"

#include <fmt/format.h>

#include <set>

#include "sinew/cli/images/board_images.h"
#include "sinew/cli/images/flash_boards.h"
#include "sinew/cli/output/board_image_text.h"
#include "sinew/io/file.h"

namespace sinew::cli {
namespace {

/// The image for such a board that is here; nothing where there is none.
std::optional<BoardImage> here_for(std::string_view board, const std::string& folder) {
  const FlashBoard* const known = flash_board(board);
  const auto images = images_folder(folder);
  if (known == nullptr || !images || !io::exists(image_path(*images, *known))) return std::nullopt;
  const auto file = board_image(*images, *known);
  return file ? file->image : std::nullopt;
}

}  // namespace

void tell_boards(const std::vector<BoardSaid>& boards, const std::string& folder,
                 Outcome& outcome) {
  outcome.json["boards"] = Json::array();
  std::set<std::string> due;
  for (const BoardSaid& board : boards) {
    Json one = Json::object();
    std::string text = "does not say which firmware it runs";
    if (!board.joint.empty()) one["joint"] = board.joint;
    if (board.image) {
      one.update(image_json(*board.image));
      text = image_text(*board.image);
      if (const auto here = here_for(board.image->board_name(), folder)) {
        const bool other = here->checksum != board.image->checksum;
        one["update_due"] = other;
        text += other ? fmt::format("; an update is due: {}, build {:08x}", here->version_text(),
                                    here->checksum)
                      : "; up to date";
        if (other) due.emplace(board.image->board_name());
      }
    }
    outcome.text += fmt::format("  {}: {}\n", board.joint.empty() ? "board" : board.joint, text);
    outcome.json["boards"].push_back(std::move(one));
  }
  for (const std::string& board : due) {
    const bool own_port = !flash_board(board)->part.empty();
    outcome.text += fmt::format("  sinew firmware flash {} {} writes it\n", board,
                                own_port ? "--port DEVICE" : "--port ADAPTER (or --usb, --probe)");
  }
}

}  // namespace sinew::cli
