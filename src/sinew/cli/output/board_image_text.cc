#include "sinew/cli/output/board_image_text.h"

#include <fmt/format.h>

namespace sinew::cli {

std::string image_text(const BoardImage& image) {
  return fmt::format("{} {}, build {:08x}", image.board_name(), image.version_text(),
                     image.checksum);
}

Json image_json(const BoardImage& image) {
  return {{"board", image.board_name()},
          {"version", image.version_text()},
          {"build", fmt::format("{:08x}", image.checksum)},
          {"size", image.size}};
}

}  // namespace sinew::cli
