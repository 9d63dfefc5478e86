#pragma once

#include <cstdint>
#include <optional>

#include "sinew/render/cell_scene.h"
#include "sinew/vision/table_camera.h"

namespace sinew::runtime {

/// How a person holds a printed board in front of a camera over a table: flat, tilted to all sides,
/// in the corners of the picture, near and far, in turn, each a little different by chance. Nothing
/// of it is below the table (z = 0 of W).
/// @param pose  the number of the pose, from 0 on, also the seed of what differs
Pose<frame::World, frame::Board> held_board(const vision::TableCamera& camera,
                                            const vision::TagBoard& board, std::uint64_t pose);

/// The hand that holds the board at its lower edge.
render::ViewedHand holding_hand(const vision::TagBoard& board,
                                const Pose<frame::World, frame::Board>& X_WP);

}  // namespace sinew::runtime
