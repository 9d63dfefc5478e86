#include "sinew/cli/cell_cameras.h"

#include <filesystem>
#include <utility>

#include "sinew/config/camera_file.h"
#include "sinew/io/file.h"
#include "sinew/runtime/written_pictures.h"

namespace sinew::cli {

std::string beside(const std::string& cell_file, const std::string& file) {
  return (std::filesystem::path(cell_file).parent_path() / file).string();
}

namespace {

/// @error  bad input
std::expected<vision::TableCamera, Outcome> read_calibration(const CellCamera& camera,
                                                             const std::string& path) {
  const auto text = io::read_file(path, std::size_t{1} << 20U);
  if (!text) {
    return std::unexpected(bad_input(camera.name + ": calibration: " + text.error().sentence));
  }
  auto read = read_camera(*text, path);
  if (!read) return std::unexpected(complaints_outcome(read.error()));
  return std::move(*read);
}

}  // namespace

std::expected<void, Outcome> open_cameras(runtime::RunningCell& cell, const std::string& file) {
  for (std::size_t i = 0; i < cell.cell().cameras.size(); ++i) {
    const CellCamera& camera = cell.cell().cameras[i];
    runtime::Camera::Settings settings{camera.name, std::nullopt, camera.cube};
    if (camera.calibration) {
      auto read = read_calibration(camera, beside(file, *camera.calibration));
      if (!read) return std::unexpected(read.error());
      settings.calibration = std::move(*read);
    }
    if (camera.device == kSimulatedCamera) {
      if (!settings.calibration) settings.calibration = runtime::usual_camera();
      auto pictures = cell.table()->pictures(*settings.calibration,
                                             [&cell] { return cell.robots_in_view(); });
      cell.open_camera(i, std::move(settings), std::move(pictures));
      continue;
    }
    cell.open_camera(i, std::move(settings),
                     runtime::written_pictures(beside(file, camera.device)));
  }
  return {};
}

}  // namespace sinew::cli
