#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/wire/board_image.h"

namespace sinew::cli {

/// A board of a robot, and which image it has said it runs.
struct BoardSaid {
  std::string joint;                ///< empty: the robot has one board
  std::optional<BoardImage> image;  ///< nothing: it does not say
};

/// Adds what runs on each board, as text and as "boards", and whether the images beside this
/// program are others: then an update is due.
/// @param folder  of images; empty: beside this program
void tell_boards(const std::vector<BoardSaid>& boards, const std::string& folder, Outcome& outcome);

}  // namespace sinew::cli
