#pragma once

#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/wire/board_image.h"

namespace sinew::cli {

/// "axis-stm32f103 0.1.0, build 3f0a91bc"
std::string image_text(const BoardImage& image);
/// {"board", "version", "build", "size"}; the build is the checksum in hex.
Json image_json(const BoardImage& image);

}  // namespace sinew::cli
