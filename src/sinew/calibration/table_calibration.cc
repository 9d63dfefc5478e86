#include "sinew/calibration/table_calibration.h"

#include <algorithm>
#include <utility>

namespace sinew::calibration {
namespace {

/// Every second tag: its four corners stand together.
std::pair<vision::BoardCorners, vision::BoardCorners> halves(const vision::BoardCorners& seen) {
  std::pair<vision::BoardCorners, vision::BoardCorners> parts;
  for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
    vision::BoardCorners& part = i / 4 % 2 == 0 ? parts.first : parts.second;
    part.points_B.push_back(seen.points_B[i]);
    part.pixels.push_back(seen.pixels[i]);
  }
  return parts;
}

/// m, at `distance` from the camera, of the points in a view that the camera was not fitted to.
void add_errors(const vision::CameraModel& camera, const BoardView& view, double distance,
                std::vector<double>& errors) {
  const auto [known, checked] = halves(view.seen);
  const auto pose = plane_pose(camera, known);
  if (!pose) return;
  const PoseWC X_WC = relabel<frame::World, frame::Camera>(pose->X_CB.inverse());
  const double scale = distance / norm(pose->X_CB.p);
  for (std::size_t i = 0; i < checked.pixels.size(); ++i) {
    const auto p_B = ray_to_plane(camera, X_WC, checked.pixels[i], 0);
    if (p_B) errors.push_back(scale * norm(*p_B - checked.points_B[i]));
  }
}

}  // namespace

Calibrated<TableCalibration> table_calibration(std::span<const BoardView> views,
                                               const BoardView& table) {
  constexpr std::size_t kViewsLeast = 5;
  if (views.size() < kViewsLeast) {
    return std::unexpected(CalibrationError{CalibrationFault::kTooFewViews, -1,
                                            static_cast<double>(views.size()), kViewsLeast, 0});
  }
  auto all = intrinsics(views);
  if (!all) return std::unexpected(all.error());
  const auto of_table = [&](CalibrationError error) {
    error.index = static_cast<int>(views.size());
    return std::unexpected(error);
  };
  if (table.width != all->camera.width || table.height != all->camera.height) {
    return of_table({CalibrationFault::kPictureSize, 0, 0, 0, 0});
  }
  auto pose = plane_pose(all->camera, table.seen, std::max(kCornerSigma, all->pixel_sigma));
  if (!pose) return of_table(pose.error());

  std::vector<double> errors;
  std::optional<CalibrationError> alone;  // of a fit without one view
  for (std::size_t held = 0; held < views.size(); ++held) {
    std::vector<BoardView> rest(views.begin(), views.end());
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(held));
    const auto others = intrinsics(rest);
    // Without this view the rest may not do: then it is not one that can be held back.
    if (others) {
      add_errors(others->camera, views[held], norm(pose->X_CB.p), errors);
    } else {
      alone = others.error();
    }
  }
  // No view says how wrong the others are: then nothing does.
  if (errors.empty() && alone) return std::unexpected(*alone);
  TableCalibration result;
  result.intrinsics = std::move(*all);
  result.table = *pose;
  result.coverage = coverage(views, result.intrinsics.camera);
  result.camera.model = result.intrinsics.camera;
  result.camera.X_WC = relabel<frame::World, frame::Camera>(pose->X_CB.inverse());
  result.camera.reprojection = result.intrinsics.rms;
  result.camera.accuracy = quantile(errors, 0.95);
  return result;
}

}  // namespace sinew::calibration
