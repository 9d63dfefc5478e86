#include "sinew/calibration/view_coverage.h"

#include <algorithm>
#include <cmath>

namespace sinew::calibration {
namespace {

/// Smallest and largest of some values.
struct Range {
  double lowest = kInfinity;
  double highest = -kInfinity;

  void add(double value) {
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
};

using CellCounts = std::array<std::array<int, Coverage::kColumns>, Coverage::kRows>;

void count_cells(const BoardView& view, CellCounts& counts) {
  for (const vision::Pixel& p : view.seen.pixels) {
    if (!(p.x >= 0 && p.y >= 0 && p.x <= view.width && p.y <= view.height)) continue;
    const auto column = static_cast<std::size_t>(p.x * Coverage::kColumns / view.width);
    const auto row = static_cast<std::size_t>(p.y * Coverage::kRows / view.height);
    ++counts[std::min(row, Coverage::kRows - 1)][std::min(column, Coverage::kColumns - 1)];
  }
}

/// "the upper left corner of the picture"
std::string place_of(std::size_t row, std::size_t column) {
  constexpr std::array<const char*, Coverage::kColumns> kSides{"left", "left of", "right of",
                                                               "right"};
  const bool at_side = column == 0 || column == Coverage::kColumns - 1;
  const std::string side = kSides[column];
  const std::string edge = row == 0 ? "upper" : "lower";
  if (row == 1)
    return at_side ? "the " + side + " edge of the picture"
                   : "the picture, " + side + " the middle";
  if (at_side) return "the " + edge + " " + side + " corner of the picture";
  return "the " + edge + " edge of the picture, " + side + " the middle";
}

std::optional<std::string> missing_cell(const Coverage& coverage) {
  // Corners first: the lens bends most there.
  for (const bool corners : {true, false}) {
    for (std::size_t row = 0; row < Coverage::kRows; ++row) {
      for (std::size_t column = 0; column < Coverage::kColumns; ++column) {
        const bool corner = row != 1 && (column == 0 || column == Coverage::kColumns - 1);
        if (corner != corners || coverage.seen[row][column]) continue;
        return "Move the board to " + place_of(row, column) + ".";
      }
    }
  }
  return std::nullopt;
}

}  // namespace

bool Coverage::all_cells_seen() const {
  return std::all_of(seen.begin(), seen.end(), [](const auto& row) {
    return std::all_of(row.begin(), row.end(), [](bool cell) { return cell; });
  });
}

Coverage coverage(std::span<const BoardView> views,
                  const std::optional<vision::CameraModel>& camera) {
  const vision::CameraModel model = camera ? *camera : rough_camera(views);
  Coverage out;
  CellCounts counts{};
  Range tilt_x;
  Range tilt_y;
  Range distance;
  for (const BoardView& view : views) {
    count_cells(view, counts);
    const auto pose = plane_pose(model, view.seen);
    if (!pose) continue;
    ++out.views;
    const Vec3 n = (pose->X_CB.R.z.z > 0 ? -1.0 : 1.0) * pose->X_CB.R.z;
    tilt_x.add(std::atan2(n.y, -n.z));
    tilt_y.add(std::atan2(n.x, -n.z));
    distance.add(norm(pose->X_CB.p));
  }
  for (std::size_t row = 0; row < Coverage::kRows; ++row) {
    std::transform(counts[row].begin(), counts[row].end(), out.seen[row].begin(),
                   [](int count) { return count >= 4; });
  }
  if (out.views == 0) return out;
  out.tilt_x = tilt_x.highest - tilt_x.lowest;
  out.tilt_y = tilt_y.highest - tilt_y.lowest;
  out.scale = distance.highest / distance.lowest;
  return out;
}

std::optional<std::string> what_to_add(const Coverage& coverage) {
  if (coverage.views == 0) {
    return "Hold the board flat in front of the camera, so that it fills half of the picture.";
  }
  if (!coverage.tilt_x_suffices()) {
    return "Tilt the board by about 30 deg about its horizontal edge.";
  }
  if (!coverage.tilt_y_suffices()) {
    return "Tilt the board by about 30 deg about its vertical edge.";
  }
  if (auto cell = missing_cell(coverage)) return cell;
  if (!coverage.scale_suffices()) return "Move the board to twice its distance, or half of it.";
  if (coverage.views < Coverage::kViewsEnough) {
    return "Take another view, with the board tilted and turned differently: " +
           std::to_string(coverage.views) + " of " + std::to_string(Coverage::kViewsEnough) +
           " views.";
  }
  return std::nullopt;
}

}  // namespace sinew::calibration
