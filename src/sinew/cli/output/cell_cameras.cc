#include "sinew/cli/output/cell_cameras.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "sinew/config/camera_file.h"
#include "sinew/config/hand_eye_file.h"
#include "sinew/core/error_code.h"
#include "sinew/io/file.h"
#include "sinew/runtime/cameras/camera_identity.h"
#include "sinew/runtime/cameras/open_camera.h"

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

std::optional<std::string> missing_robot(const Cell& cell, const vision::TableCamera& camera) {
  const bool is_there = !camera.touched || std::ranges::any_of(cell.robots, [&](const auto& one) {
    return one.name == camera.touched->robot;
  });
  if (is_there) return std::nullopt;
  return "[table] is in the base of '" + camera.touched->robot +
         "', and the cell has no robot of that name; rename it there, or delete [table]";
}

std::expected<MeasuredHandEye, Outcome> read_hand_eye_of(const CellCamera& camera,
                                                         const std::string& path, std::size_t robot,
                                                         const RobotModel& model) {
  const auto complain = [&](const std::string& what) {
    return std::unexpected(bad_input(camera.name + ": hand_eye: " + what));
  };
  const auto text = io::read_file(path, std::size_t{1} << 20U);
  if (!text) return complain(text.error().sentence);
  auto file = read_hand_eye(*text, path);
  if (!file) return std::unexpected(complaints_outcome(file.error()));
  auto mount = runtime::mount_of(*file, robot, model);
  if (!mount) return complain(path + ": " + mount.error());
  return MeasuredHandEye{std::move(*file), std::move(*mount)};
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

/// Where a camera's calibration is kept.
std::string calibration_place(const CellCamera& camera, const std::string& cell_file) {
  return beside(cell_file, camera.calibration.value_or("camera-" + camera.name + ".toml"));
}

/// Why a calibration does not count here; nothing: it does.
/// @param file      that it stands in
/// @param identity  of the camera that is here
std::optional<std::string> why_not(const vision::TableCamera& kept, const Cell& cell,
                                   const std::string& file, const std::string& identity) {
  if (const auto missing = missing_robot(cell, kept)) return file + ": " + *missing;
  const bool is_other = !kept.identity.empty() && !identity.empty() && kept.identity != identity;
  if (!is_other) return std::nullopt;
  return file + " is of another camera: " + kept.identity + "; this one is " + identity;
}

/// What is kept of a camera, as far as there is a file and it is this camera's.
/// @error  bad input: a file that cannot be read
std::expected<void, Outcome> put_kept(runtime::Camera::Settings& settings, const Cell& cell,
                                      const CellCamera& camera) {
  const std::string& file = settings.calibration_file;
  if (!io::exists(file)) {
    if (!camera.calibration) return {};
    settings.calibration_refused = file + " is not there";
  } else {
    auto read = read_calibration(camera, file);
    if (!read) return std::unexpected(read.error());
    const auto why = why_not(*read, cell, file, settings.identity);
    if (!why) {
      settings.calibration = std::move(*read);
      return {};
    }
    settings.calibration_refused = *why;
  }
  const char* help =
      camera.hand_eye ? "To fix: sinew camera calibrate" : "Calibrate in the panel's Camera view";
  std::fputs(("  " + camera.name + ": not calibrated: " + settings.calibration_refused + ". " +
              help + "\n")
                 .c_str(),
             stderr);
  return {};
}

}  // namespace

std::expected<void, Outcome> open_cameras(runtime::RunningCell& cell, const std::string& file) {
  for (std::size_t i = 0; i < cell.cell().cameras.size(); ++i) {
    const CellCamera& camera = cell.cell().cameras[i];
    const bool is_simulated = camera.device == kSimulatedCamera;
    const bool is_address = camera.device.contains("://");
    const std::string device =
        is_address || is_simulated ? camera.device : beside(file, camera.device);
    runtime::Camera::Settings settings{.name = camera.name,
                                       .calibration = std::nullopt,
                                       .edge = camera.cube,
                                       .identity = runtime::camera_identity(camera.device),
                                       .calibration_file = calibration_place(camera, file)};
    if (auto kept = put_kept(settings, cell.cell(), camera); !kept) return kept;
    std::optional<runtime::CameraMount> mount;
    if (camera.hand_eye) {
      const std::size_t robot = *cell.find(camera.robot);
      auto read = read_hand_eye_of(camera, beside(file, *camera.hand_eye), robot,
                                   cell.station(robot).robot());
      if (!read) return std::unexpected(read.error());
      mount = read->mount;
      if (mount && settings.calibration) settings.calibration->accuracy = read->file.held_back;
      if (!mount) cell.stands_beside(i, std::move(read->file));
    }
    if (is_simulated) {
      // It hangs where the cell's file says, also where something else was measured.
      vision::TableCamera real = runtime::usual_camera();
      if (camera.calibration && settings.calibration) real = *settings.calibration;
      if (!settings.calibration) settings.calibration = real;
      real.sheet = settings.calibration->sheet;
      const auto robots = [&cell] {
        return cell.robots_in_view(runtime::RunningCell::Stand::kTrue);
      };
      runtime::SimulatedTable::Hangs hangs;
      if (mount) {
        hangs = [&cell, on = *mount] { return cell.hangs(on, runtime::RunningCell::Stand::kTrue); };
      }
      auto pictures = cell.table()->pictures(real, robots, i, std::move(hangs));
      auto glances = cell.table()->glances(real, robots, i);
      cell.open_camera(i, std::move(settings), std::move(pictures), std::move(glances), mount);
      continue;
    }
    runtime::CameraWanted wanted;
    if (settings.calibration) {
      wanted.width = settings.calibration->model.width;
      wanted.height = settings.calibration->model.height;
    }
    settings.watch = !runtime::is_stored(device);
    auto pictures = opened_when_there(device, wanted, camera.name);
    cell.open_camera(i, std::move(settings), std::move(pictures), {}, mount);
  }
  return {};
}

}  // namespace sinew::cli
