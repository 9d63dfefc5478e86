#include "sinew/vision/table_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sinew/core/number_text.h"
#include "sinew/core/units.h"
#include "sinew/vision/shapes.h"
#include "sinew/vision/side_color.h"
#include "sinew/vision/table_fit.h"
#include "sinew/vision/table_thing.h"
#include "sinew/vision/view_watch.h"

namespace sinew::vision {
namespace {

/// The square that the corners of a top make on the plane z = height.
std::optional<CubePosition> square_at(const TableCamera& camera, const Quad& top, double height) {
  std::array<Vec3, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto p_W = on_plane(camera, top[i], height);
    if (!p_W) return std::nullopt;
    corners[i] = *p_W;
  }
  CubePosition square;
  double twice = 0;
  Pixel turn;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3& from = corners[i];
    const Vec3& to = corners[(i + 1) % 4];
    square.top_W = square.top_W + 0.25 * from;
    twice += from.x * to.y - from.y * to.x;
    // Four times the angle: sides that are a quarter turn apart say the same.
    const double angle = 4 * std::atan2(to.y - from.y, to.x - from.x);
    turn =
        turn + std::hypot(to.x - from.x, to.y - from.y) * Pixel{std::cos(angle), std::sin(angle)};
  }
  square.edge = std::sqrt(std::abs(twice) / 2);
  const double angle = std::atan2(turn.y, turn.x) / 4;
  square.yaw = angle < 0 ? angle + kPi / 2 : angle;
  return square;
}

constexpr double kSquare = 16.5;  ///< contrast of a square's sides, of 8-bit RGB

/// On the level on which a square of a cube's size fits best; nothing where its corners say that
/// its size is off by more than a quarter on each.
std::optional<TableFit> best_fit(const Picture& picture, const TableCamera& camera, const Quad& top,
                                 double edge, const std::vector<bool>& hidden) {
  constexpr int kLevels = 6;
  constexpr double kOffMost = 0.25;
  // Its corners say the size to a tenth: two levels more or less. A top and a side face together
  // look like a larger top, so what decides is where the side faces end that are seen.
  constexpr double kFoot = 16;        // of 8-bit RGB
  constexpr double kFits = 0.75;      // of the contrast on the lowest level
  constexpr double kSmallest = 0.97;  // of its size: corners are rather seen too far out
  std::optional<TableFit> best;
  double lowest = 0;
  for (int level = 1; level <= kLevels; ++level) {
    auto square = square_at(camera, top, level * edge);
    if (!square) break;
    if (std::abs(square->edge / edge - 1) >= kOffMost) continue;
    square->level = level;
    const double pixel = square->edge / std::max(edge_of(top), 1.0);
    TableFit fit = fitted_on_table(picture, camera, *square, edge, pixel, hidden);
    if (!best) lowest = fit.contrast;
    const bool fits = fit.foot.value_or(0) >= kFoot && fit.contrast >= kFits * lowest &&
                      square->edge >= kSmallest * edge;
    if (level > 1 && !fits) continue;
    best = fit;
  }
  return best;
}

/// What the sides of a doubtful top on the table say.
enum class Sides : std::uint8_t { kOfNone, kPerhaps, kOfCube };

/// @param nearest  edges, to the middle of the next top
Sides sides_of(const TableFit& fit, double nearest) {
  constexpr double kFoot = 12, kSureFoot = 17, kSureSquare = 17.5;  // of 8-bit RGB
  // Sides that touch others of their color have no contrast; three of four are more than that.
  constexpr double kTouches = 1.42, kTouching = 14;
  constexpr double kHides = 1.75;  // so near a top may hide where the side faces behind it end
  if (!fit.is_sure) return Sides::kPerhaps;
  const bool has_foot = nearest < kHides || fit.foot.value_or(kFoot) >= kFoot;
  if (fit.contrast < (nearest < kTouches ? kTouching : kSquare) || !has_foot) {
    return Sides::kOfNone;
  }
  const bool sure = fit.contrast >= kSureSquare && fit.foot.value_or(0) >= kSureFoot;
  return sure ? Sides::kOfCube : Sides::kPerhaps;
}

bool is_whole(const Picture& picture, const Quad& quad) {
  return std::ranges::all_of(quad, [&](Pixel p) {
    return p.x > 1 && p.y > 1 && p.x < picture.width - 1 && p.y < picture.height - 1;
  });
}

/// Middles of all tops: of cubes, and of what may be one.
std::vector<Vec3> tops_of(const Detection& detection, const TableCamera& camera, double edge) {
  std::vector<Vec3> tops;
  for (const SeenCube& cube : detection.cubes) tops.push_back(cube.position->top_W);
  for (const RefusedShape& shape : detection.refused) {
    if (shape.height != Height::kLikely) continue;
    if (const auto square = square_at(camera, shape.outline, edge)) tops.push_back(square->top_W);
  }
  return tops;
}

/// Edges: cubes beside each other are farther apart.
constexpr double kSame = 0.95;

/// m, seen from above
double apart(const Vec3& one_W, const Vec3& other_W) {
  return std::hypot(one_W.x - other_W.x, one_W.y - other_W.y);
}

/// Of the doubtful tops those whose sides are those of a cube become cubes, and those that have no
/// sides are no likely obstacles.
void decide_by_sides(Detection& detection, const Picture& picture, const TableCamera& camera,
                     double edge, const std::vector<bool>& hidden) {
  const std::vector<Vec3> tops = tops_of(detection, camera, edge);
  std::optional<WhiteBalance> balance;
  const auto becomes_cube = [&](RefusedShape& shape) {
    const auto fit = best_fit(picture, camera, shape.outline, edge, hidden);
    if (!fit || !is_whole(picture, shape.outline)) return false;
    const Vec3& top_W = fit->position.top_W;
    std::vector<Vec3> others;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& other_W : tops) {
      const double far = apart(top_W, other_W) / edge;
      if (far < kSame) continue;  // itself, seen twice
      others.push_back(other_W);
      nearest = std::min(nearest, far);
    }
    const Sides sides = sides_of(*fit, nearest);
    if (sides == Sides::kOfNone && !shape.is_sure) shape.height = Height::kPerhaps;
    const bool is_new = std::ranges::none_of(detection.cubes, [&](const SeenCube& other) {
      return apart(top_W, other.position->top_W) < kSame * edge;
    });
    if (sides != Sides::kOfCube || !shape.cube || !is_new) return false;
    SeenCube cube = *shape.cube;
    if (!shape.has_color) {
      if (!balance) balance.emplace(picture);
      const auto color = side_color(picture, *balance, camera, fit->position, edge, others, hidden);
      if (!color) return false;
      cube.color = *color;
    }
    cube.position = fit->position;
    detection.cubes.push_back(cube);
    return true;
  };
  std::vector<RefusedShape> kept;
  for (RefusedShape& shape : detection.refused) {
    if (shape.height == Height::kLikely && becomes_cube(shape)) continue;
    kept.push_back(std::move(shape));
  }
  detection.refused = std::move(kept);
}

/// Whether a point is over an object.
bool holds(const ThingPosition& thing, const Vec3& p_W) {
  const Vec3 d = p_W - thing.top_W;
  const double c = std::cos(thing.yaw), s = std::sin(thing.yaw);
  return std::abs(c * d.x + s * d.y) < thing.half_x && std::abs(c * d.y - s * d.x) < thing.half_y;
}

/// Nothing where a robot is before it, or it is a side of a cube.
std::optional<ThingPosition> position_of(const RefusedShape& shape, const Picture& picture,
                                         const TableCamera& camera, double edge,
                                         const Detection& detection,
                                         const std::vector<bool>& hidden) {
  constexpr double kSmallest = 0.4, kLargest = 3;  // of a cube's edge
  constexpr double kFace = 0.65;                   // of it; half of a side face is less
  const auto [width, height] = std::pair(camera.model.width, camera.model.height);
  const Pixel middle = middle_of(shape.outline);
  const auto cell = cell_of(grid_of(width, height), width, height, middle);
  if (!cell || (!hidden.empty() && hidden[*cell])) return std::nullopt;
  const auto square = square_at(camera, shape.outline, edge);
  if (!square || square->edge < kSmallest * edge || square->edge > kLargest * edge) {
    return std::nullopt;
  }
  const auto face_W = on_plane(camera, middle, edge / 2);
  if (!face_W) return std::nullopt;
  const auto thing =
      shape.height == Height::kPerhaps
          ? thing_position(picture, camera, middle, edge)
          : std::optional(ThingPosition{square->top_W, square->yaw, edge / 2, edge / 2});
  if (!thing) return std::nullopt;
  const bool is_large = std::max(thing->half_x, thing->half_y) > kFace * edge;
  const bool of_cube = std::ranges::any_of(detection.cubes, [&](const SeenCube& cube) {
    const Vec3& top_W = cube.position->top_W;
    if (is_large) return holds(*thing, top_W);
    // The middle of a side face is half an edge below the top.
    return apart(top_W, thing->top_W) < kSame * edge || apart(top_W, *face_W) < kFace * edge;
  });
  if (of_cube) return std::nullopt;
  return thing;
}

}  // namespace

std::optional<Vec3> on_plane(const TableCamera& camera, Pixel p, double height) {
  const Vec3 toward = camera.X_WC.R * camera.model.direction(p);
  const double fall = height - camera.X_WC.p.z;
  constexpr double kFlattest = 1e-3;
  if (std::abs(toward.z) < kFlattest || fall / toward.z <= 0) return std::nullopt;
  return camera.X_WC.p + fall / toward.z * toward;
}

std::optional<double> sheet_shift(const TableCamera& camera, const TagBoard& sheet,
                                  const std::vector<SeenTag>& tags) {
  const BoardCorners seen = corners_in(sheet, tags);
  std::vector<double> shifts;
  for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
    const auto p_W = on_plane(camera, seen.pixels[i], 0);
    if (p_W) shifts.push_back(norm(*p_W - seen.points_B[i]));
  }
  if (shifts.empty()) return std::nullopt;
  const auto half = shifts.begin() + static_cast<std::ptrdiff_t>(shifts.size() / 2);
  std::ranges::nth_element(shifts, half);
  return *half;
}

std::expected<CubePosition, NotPlaced> cube_position(const Picture& picture,
                                                     const TableCamera& camera,
                                                     const SeenCube& cube, double edge,
                                                     const std::vector<bool>& hidden) {
  // A round top, and a brick's, has few edges along the sides of a square. Cubes that the detection
  // is sure of may have little contrast to the table.
  constexpr double kSure = 0.9;  // confidence
  const auto fit = best_fit(picture, camera, cube.top, edge, hidden);
  if (fit && !fit->is_sure) {
    return std::unexpected(NotPlaced{"a robot hides it in part", Height::kLikely});
  }
  if (fit && fit->contrast < kSquare && cube.confidence < kSure) {
    return std::unexpected(NotPlaced{"its top is no square of a cube's size"});
  }
  if (fit) return fit->position;
  const auto square = square_at(camera, cube.top, edge);
  return std::unexpected(
      NotPlaced{square ? "its top measures " + number_text(to_mm(square->edge), 0) +
                             " mm, that of a cube " + number_text(to_mm(edge), 0) + " mm"
                       : "it is above the horizon of the table"});
}

void place_on_table(Detection& detection, const Picture& picture, const TableCamera& camera,
                    double edge, const std::vector<bool>& hidden) {
  std::vector<SeenCube> kept;
  for (SeenCube& cube : detection.cubes) {
    const auto position = cube_position(picture, camera, cube, edge, hidden);
    if (!position) {
      detection.refused.push_back({cube.top, position.error().why, position.error().height});
      continue;
    }
    cube.position = *position;
    kept.push_back(cube);
  }
  detection.cubes = std::move(kept);
  decide_by_sides(detection, picture, camera, edge, hidden);
  for (RefusedShape& shape : detection.refused) {
    if (shape.height == Height::kFlat) continue;
    shape.position = position_of(shape, picture, camera, edge, detection, hidden);
  }
}

}  // namespace sinew::vision
