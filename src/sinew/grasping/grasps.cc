#include "sinew/grasping/grasps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/model/tool_body.h"
#include "sinew/model/tool_state.h"
#include "sinew/planning/collision/shape_distance.h"

namespace sinew::grasping {
namespace {

constexpr double kMargin = 2e-3;       // m, of heights, and of what stands on what
constexpr double kEnter = 3e-3;        // m, beside the cube on each side, as it may lie off so far
constexpr double kBeside = 8e-3;       // m, beside it: wider jaws meet more
constexpr double kBesideMost = 15e-3;  // m, where nothing else can be had
constexpr double kGripLow = 7e-3;   // m above what it stands on; the table has a margin of its own
constexpr double kGripShare = 0.4;  // of the edge, above what it stands on
constexpr double kHand = 25e-3;     // m, from the tips of closed jaws up to the hand
const Vec3 kHandHalf{14e-3, 42e-3, 25e-3};  // m, of the hand: across, along the jaws, up
constexpr double kCupRadius = 12e-3;        // m
constexpr double kHold = 5e-3;              // m, that closed tips reach below a cube's top
constexpr double kSkewMax = 0.22;           // sine of the angle between the jaws and the table
constexpr double kTiltStep = from_deg(1.25);
constexpr double kTiltMax = from_deg(50);
/// m, of the tips above where they hold best: a joint may end a little too early for that.
constexpr std::array kHeights{0.0, 3e-3, -2e-3};
constexpr std::array kPoorHeights{6e-3, -5e-3};

/// An upright rectangle seen from above.
struct Plan {
  Vec3 middle;  ///< z does not count
  double turn = 0;
  double half_u = 0, half_v = 0;  ///< m, along the turned x and y
};

bool apart_along(const Plan& a, const Plan& b, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const auto reach = [&](const Plan& plan) {
    const double turn = plan.turn - angle;
    return std::abs(std::cos(turn)) * plan.half_u + std::abs(std::sin(turn)) * plan.half_v;
  };
  const Vec3 between = b.middle - a.middle;
  return std::abs(c * between.x + s * between.y) >= reach(a) + reach(b);
}

bool overlap(const Plan& a, const Plan& b) {
  for (const double angle : {a.turn, a.turn + kPi / 2, b.turn, b.turn + kPi / 2}) {
    if (apart_along(a, b, angle)) return false;
  }
  return true;
}

Plan plan_of(const Body& body, double swell) {
  return {body.p_BO, body.yaw, body.half.x + swell, body.half.y + swell};
}

double top(const Body& body) {
  return body.p_BO.z + body.half.z;
}

/// A cube to take, and what is beside it.
struct Scene {
  Cube cube;
  Body body;
  std::vector<Body> beside;  ///< the cubes first, in their order

  Scene(std::span<const Cube> cubes, std::size_t which, std::span<const Body> others)
      : cube(cubes[which]), body(body_of(cube)) {
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      if (i != which) beside.push_back(body_of(cubes[i]));
    }
    beside.insert(beside.end(), others.begin(), others.end());
  }
  bool is_covered() const {
    return std::ranges::any_of(beside, [&](const Body& other) {
      return other.p_BO.z > top(body) && overlap(plan_of(body, 0), plan_of(other, -kMargin));
    });
  }
};

/// The roll that turns the jaws' direction, seen from above, to `angle` from the plane's.
double roll_for(double angle, double pitch) {
  double roll = std::atan2(-std::cos(angle) / std::cos(pitch), std::sin(angle));
  if (roll > kPi / 2) roll -= kPi;
  if (roll <= -kPi / 2) roll += kPi;
  return roll;
}

/// Jaws along one pair of a cube's faces, at one tilt and height.
struct Stand {
  Pose<frame::Base, frame::Tool> X_BT;  ///< of the closed tips: y across the jaws, z ahead
  double pitch = 0, roll = 0;
};

/// Jaws around one cube among others.
class JawPlaces {
 public:
  JawPlaces(const RobotModel& robot, const JawGripper& gripper, const Scene& scene)
      : gripper_(gripper), finger_(finger_half(robot)), cube_(scene.cube) {
    // Farther than any part of the hand is from the cube.
    const double kFar = 2 * kHand + 2 * kHandHalf.z + kHandHalf.y;
    for (const Body& body : scene.beside) {
      if (norm(body.p_BO - cube_.p_BO) > kFar + norm(body.half)) continue;
      beside_.push_back({{rotation_z(body.yaw), body.p_BO}, body.half});
    }
  }

  /// m, beside a face: the least that a finger takes, its own thickness included.
  double needed() const { return 2 * finger_.y + kEnter; }
  /// As far as jaws open, `most` beside the cube.
  double widest(double most) const {
    return 2 * finger_.y + std::min(most, (gripper_.width_max - cube_.edge) / 2);
  }

  /// Nothing where they would hold too little of the cube, or stand askew.
  /// @param along  rad, the direction of the jaws. @param tilt  rad, from straight down, outward
  /// @param up     m, higher than usual
  std::optional<Stand> stand(double along, double tilt, double up) const {
    const double yaw = std::atan2(cube_.p_BO.y, cube_.p_BO.x);
    Stand stand;
    stand.pitch = kPi - tilt;
    stand.roll = roll_for(along - yaw, stand.pitch);
    stand.X_BT.R = rotation_z(yaw) * rotation_y(stand.pitch) * rotation_z(stand.roll);
    stand.X_BT.p = cube_.p_BO;
    stand.X_BT.p.z += grip() + lower(stand, close()) + up;
    const bool is_held = stand.X_BT.p.z < top(body_of(cube_)) - kHold;
    if (std::abs(stand.X_BT.R.y.z) > kSkewMax || !is_held) return std::nullopt;
    return stand;
  }

  /// m, how far a finger may be from the cube's faces, its thickness included, up to `most`; 0
  /// where a neighbour leaves no room for the hand.
  double room_at(const Stand& stand, double most) const {
    constexpr double kExact = 0.05e-3;  // m
    const Vec3 behind{0, 0, -kHand - kHandHalf.z};
    if (meets({{stand.X_BT.R, stand.X_BT * behind}, kHandHalf})) return 0;
    double room = most;
    for (const double side : {1.0, -1.0}) {
      const auto is_free = [&](double far) { return !meets(swept(stand, side, far)); };
      if (is_free(room)) continue;
      double free = 0;
      for (double end = room; end - free > kExact;) {
        const double middle = (free + end) / 2;
        (is_free(middle) ? free : end) = middle;
      }
      room = free;
    }
    return room;
  }

  /// Nothing where the tips would come too near to what the cube stands on.
  std::optional<JawGrasp> grasp(const Stand& stand, double room) const {
    JawGrasp grasp;
    grasp.pitch = stand.pitch;
    grasp.roll = stand.roll;
    grasp.room = room - 2 * finger_.y;
    grasp.open = cube_.edge + 2 * grasp.room;
    grasp.close = close();
    const Vec3& approach = stand.X_BT.R.z;
    const double ahead = ahead_of(grasp.open);
    grasp.p_BT = stand.X_BT.p - ahead * approach;
    const double floor = cube_.p_BO.z - cube_.edge / 2;
    if (grasp.p_BT.z - lower(stand, grasp.open) < floor + kGripLow - kMargin) return std::nullopt;
    return grasp;
  }

 private:
  double close() const { return std::max(0.0, cube_.edge - kSqueeze); }
  /// m, above the cube's middle
  double grip() const {
    const double half = cube_.edge / 2;
    return std::min(half, std::max(kGripLow, kGripShare * cube_.edge)) - half;
  }
  /// m, that tips go on as the jaws close
  double ahead_of(double open) const {
    return jaw_reach(gripper_, close()) - jaw_reach(gripper_, open);
  }
  /// m, that the lowest point of two tilted fingers is lower than the middle of their tips.
  double lower(const Stand& stand, double width) const {
    const Rotation& R = stand.X_BT.R;
    return finger_.x * std::abs(R.x.z) + std::abs(R.y.z) * (width / 2 + 2 * finger_.y);
  }
  /// What a finger fills as it closes from so far (m) beside the face.
  planning::PlacedBox swept(const Stand& stand, double side, double far) const {
    const double ahead =
        std::max(0.0, ahead_of(cube_.edge + 2 * std::max(0.0, far - 2 * finger_.y)));
    const Vec3 half{finger_.x, far / 2, finger_.z + ahead / 2};
    return {{stand.X_BT.R, stand.X_BT * Vec3{0, side * (cube_.edge / 2 + half.y), -half.z}}, half};
  }
  bool meets(const planning::PlacedBox& box) const {
    return std::ranges::any_of(beside_, [&](const planning::PlacedBox& other) {
      const double apart = norm(other.X.p - box.X.p) - norm(box.half) - norm(other.half);
      return apart < kApart && planning::distance(box, other) < kApart;
    });
  }

  const JawGripper& gripper_;
  Vec3 finger_;  ///< m, half: x along the faces, y across the jaws, z ahead
  const Cube& cube_;
  std::vector<planning::PlacedBox> beside_;
};

/// rad, the least is the best: its tilt, and where fingers have little room 4 deg for each mm less.
/// An arm that sags and a picture that is off touch rather what is tightly beside a finger than
/// what one passes tilted.
double poorness(const JawGrasp& grasp) {
  constexpr double kEnough = kEnter + 2e-3;         // m
  constexpr double kPerMetre = from_deg(4) / 1e-3;  // rad/m
  return std::abs(grasp.pitch - kPi) + kPerMetre * std::max(0.0, kEnough - grasp.room);
}

}  // namespace

Expected<std::vector<JawGrasp>> jaw_grasps(const RobotModel& robot, std::span<const Cube> cubes,
                                           std::size_t which, std::span<const Body> others) {
  const auto* arm = std::get_if<SerialGeometry>(&robot.geometry);
  SINEW_ASSERT(arm != nullptr && arm->gripper && which < cubes.size());
  const JawGripper& gripper = *arm->gripper;
  const Scene scene(cubes, which, others);
  const Cube& cube = scene.cube;
  if (scene.is_covered()) return std::unexpected(Error{ErrorCode::kCubeCovered});
  if (cube.edge + 2 * kEnter > gripper.width_max) {
    return std::unexpected(
        Error{ErrorCode::kCubeTooWide, -1, cube.edge, gripper.width_max - 2 * kEnter});
  }
  const JawPlaces places(robot, gripper, scene);
  const double needed = places.needed();
  std::vector<JawGrasp> grasps;
  std::size_t sorted = 0;
  double most = 0;
  const auto add = [&](const Stand& stand, double widest, double tried) {
    const double room = places.room_at(stand, widest);
    most = std::max(most, room);
    if (room < needed || room <= tried) return;
    // As far from a neighbour as from the cube. Wide jaws may come too near to the arm itself.
    // Few widths: hands of one width share their collision model.
    constexpr double kStep = 0.5e-3;  // m
    double open = room < widest ? (needed + room) / 2 : room;
    open = needed + kStep * std::floor((open - needed) / kStep + 1e-6);
    if (const auto grasp = places.grasp(stand, open)) grasps.push_back(*grasp);
    if (open < needed + kMargin || tried > 0) return;
    if (const auto grasp = places.grasp(stand, needed)) grasps.push_back(*grasp);
  };
  // `tried` (m): with no more room the same grasps are there already.
  const auto add_at = [&](std::span<const double> heights, double widest, double tried = 0) {
    constexpr int kSteps = static_cast<int>(kTiltMax / kTiltStep + 0.5);
    for (const double along : {cube.yaw, cube.yaw + kPi / 2}) {
      for (int step = -kSteps; step <= kSteps; ++step) {
        for (const double up : heights) {
          if (const auto stand = places.stand(along, step * kTiltStep, up))
            add(*stand, widest, tried);
        }
      }
    }
    std::ranges::stable_sort(std::span(grasps).subspan(sorted), [](const auto& a, const auto& b) {
      const double first = poorness(a), second = poorness(b);
      return std::abs(first - second) > 1e-9 ? first < second : a.room > b.room;
    });
    sorted = grasps.size();
  };
  add_at(kHeights, places.widest(kBeside));
  add_at(kPoorHeights, places.widest(kBesideMost));
  add_at(kHeights, places.widest(kBesideMost), places.widest(kBeside));
  if (grasps.empty()) return std::unexpected(Error{ErrorCode::kCubeCrowded, -1, most, needed});
  return grasps;
}

Expected<Vec3> cup_grasp(std::span<const Cube> cubes, std::size_t which,
                         std::span<const Body> others) {
  const Scene scene(cubes, which, others);
  const Cube& cube = scene.cube;
  if (scene.is_covered()) return std::unexpected(Error{ErrorCode::kCubeCovered});
  const Plan cup{cube.p_BO, 0, kCupRadius, kCupRadius};
  for (const Body& other : scene.beside) {
    if (top(other) <= top(scene.body) + kMargin) continue;
    if (!overlap(cup, plan_of(other, kApart))) continue;
    const Vec3 between = other.p_BO - cube.p_BO;
    const double room = std::hypot(between.x, between.y) - std::max(other.half.x, other.half.y);
    return std::unexpected(
        Error{ErrorCode::kCubeCrowded, -1, std::max(0.0, room), kCupRadius + kApart});
  }
  return cube.p_BO + Vec3{0, 0, cube.edge / 2};
}

std::vector<std::size_t> order_of(std::span<const Cube> cubes) {
  std::vector<std::size_t> order(cubes.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](std::size_t i) {
    return std::pair(Scene(cubes, i, {}).is_covered(),
                     std::hypot(cubes[i].p_BO.x, cubes[i].p_BO.y));
  };
  std::ranges::stable_sort(order, {}, key);
  return order;
}

}  // namespace sinew::grasping
