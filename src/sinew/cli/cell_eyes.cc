#include "sinew/cli/cell_eyes.h"

#include <algorithm>
#include <filesystem>
#include <memory>

#include "sinew/config/camera_file.h"
#include "sinew/io/file.h"
#include "sinew/runtime/written_pictures.h"

namespace sinew::cli {

std::string beside(const std::string& cell_file, const std::string& file) {
  return (std::filesystem::path(cell_file).parent_path() / file).string();
}

std::expected<void, Outcome> open_eyes(runtime::RunningCell& cell, const std::string& file) {
  const auto& cameras = cell.cell().cameras;
  const auto camera = std::ranges::find_if(
      cameras, [](const CellCamera& one) { return one.calibration.has_value(); });
  if (camera == cameras.end()) return {};
  const std::string path = beside(file, *camera->calibration);
  const auto text = io::read_file(path, std::size_t{1} << 20U);
  if (!text) {
    return std::unexpected(bad_input(camera->name + ": calibration: " + text.error().sentence));
  }
  const auto read = read_camera(*text, path);
  if (!read) return std::unexpected(complaints_outcome(read.error()));
  const std::string image = beside(file, camera->device);
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const auto X_BT = cell.cell().robots[i].X_WB.inverse() * camera->X_WT;
    // The calibration's world is its table.
    cell.see_by(i, std::make_unique<runtime::CubeEyes>(
                       runtime::CubeEyes::Place{*read, relabel<frame::Base, frame::World>(X_BT),
                                                camera->cube},
                       runtime::written_pictures(image)));
  }
  return {};
}

}  // namespace sinew::cli
