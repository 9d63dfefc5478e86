#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "sinew/runtime/cameras/simulated_table.h"
#include "sinew/runtime/running_cell.h"
#include "sinew/server/json/json_rpc.h"
#include "sinew/vision/tags.h"

/// What the server says of cameras: SI, in the cell's frame; px of the picture as it was taken.
namespace sinew::server {

/// Where baskets stand.
Json baskets_json(const std::vector<CellBasket>& baskets);

/// Where its table is, where its calibration is kept and, where it is calibrated, its lens.
Json camera_description(const runtime::RunningCell& cell, std::size_t camera);

/// What its newest picture shows; `picture` beside it, a JPEG as base64, where it has another
/// number than `known`.
/// @param longest  px, of the picture's longer side
Json shot_json(const runtime::RunningCell& cell, std::size_t camera,
               const runtime::Camera::Shot& shot, std::uint64_t known, int longest);

/// "none", "hand", "covered", "unplugged" or "frozen"; nothing: it has another name.
/// @param camera  that a hand reaches into the picture of
std::optional<runtime::SimulatedTable::Trouble> trouble_named(std::string_view name,
                                                              const runtime::SimulatedTable& table,
                                                              std::size_t camera);
std::string_view name_of(const runtime::SimulatedTable::Trouble& trouble);

/// The tags of `shot` in shot_json(). Of the thread that looks through cameras: what was found in a
/// picture is found once for all clients.
class ShownTags {
 public:
  Json of(std::size_t camera, const runtime::Camera::Shot& shot);

 private:
  struct Found {
    std::uint64_t number = 0;
    Json tags;
  };
  std::optional<vision::TagFinder> finder_;
  std::map<std::size_t, Found> found_;  ///< the last ones, by camera
};

}  // namespace sinew::server
