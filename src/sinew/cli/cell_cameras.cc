#include "sinew/cli/cell_cameras.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "sinew/config/camera_file.h"
#include "sinew/io/file.h"
#include "sinew/runtime/open_camera.h"

namespace sinew::cli {

std::string beside(const std::string& cell_file, const std::string& file) {
  return (std::filesystem::path(cell_file).parent_path() / file).string();
}

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

namespace {

/// A cell runs without its camera too: one that cannot be opened is said so, and tried again with
/// each picture.
runtime::CameraSource opened_when_there(const std::string& device,
                                        const runtime::CameraWanted& wanted,
                                        const std::string& name) {
  auto opened = runtime::open_camera(device, wanted);
  if (opened) return std::move(*opened);
  std::fputs(("  " + name + ": " + opened.error() + "\n").c_str(), stderr);
  auto source = std::make_shared<runtime::CameraSource>();
  return [=](const std::stop_token& ending) -> Expected<vision::Picture> {
    if (!*source) {
      auto again = runtime::open_camera(device, wanted);
      if (!again) return std::unexpected(Error{ErrorCode::kCameraLost, -1, 0});
      *source = std::move(*again);
    }
    return (*source)(ending);
  };
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
      const auto robots = [&cell] {
        return cell.robots_in_view(runtime::RunningCell::Stand::kTrue);
      };
      auto pictures = cell.table()->pictures(*settings.calibration, robots);
      auto glances = cell.table()->glances(*settings.calibration, robots);
      cell.open_camera(i, std::move(settings), std::move(pictures), std::move(glances));
      continue;
    }
    const bool is_address = camera.device.contains("://");
    runtime::CameraWanted wanted;
    if (settings.calibration) {
      wanted.width = settings.calibration->model.width;
      wanted.height = settings.calibration->model.height;
    }
    auto pictures = opened_when_there(is_address ? camera.device : beside(file, camera.device),
                                      wanted, camera.name);
    cell.open_camera(i, std::move(settings), std::move(pictures));
  }
  return {};
}

}  // namespace sinew::cli
