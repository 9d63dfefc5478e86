#pragma once

#include <string>

#include "sinew/runtime/running_cell.h"
#include "sinew/server/json_rpc.h"

/// What the server says of cameras: SI, in the cell's frame; px of the picture as it was taken.
namespace sinew::server {

/// Where baskets stand.
Json baskets_json(const std::vector<CellBasket>& baskets);

/// What never changes: where its table is and, where it is calibrated, its lens.
Json camera_description(const runtime::RunningCell& cell, std::size_t camera);

/// What its newest picture shows; `picture` beside it, a JPEG as base64, where it has another
/// number than `known`.
/// @param longest  px, of the picture's longer side
Json shot_json(const runtime::RunningCell& cell, std::size_t camera,
               const runtime::Camera::Shot& shot, std::uint64_t known, int longest);

}  // namespace sinew::server
