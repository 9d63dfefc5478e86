#include "sinew/grasping/grasps.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"
#include "sinew/model/tool_body.h"
#include "sinew/model/tool_state.h"

namespace sinew::grasping {
namespace {

constexpr double kMargin = 2e-3;     // m, of heights, and of what stands on what
constexpr double kEnter = 3e-3;      // m, beside the cube on each side, as it may lie off so far
constexpr double kBeside = 8e-3;     // m, beside it at most: wider jaws meet more
constexpr double kGripLow = 7e-3;    // m above what it stands on; the table has a margin of its own
constexpr double kGripShare = 0.4;   // of the edge, above what it stands on
constexpr double kHand = 25e-3;      // m, from the tips of closed jaws up to the hand
constexpr double kHandHalf = 42e-3;  // m, of the hand along the jaws
constexpr double kCupRadius = 12e-3;  // m
constexpr double kHold = 5e-3;        // m, that closed tips reach below a cube's top
constexpr double kSkewMax = 0.22;     // sine of the angle between the jaws and the table
constexpr double kTiltStep = from_deg(1.25);
constexpr double kTiltMax = from_deg(50);

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

struct Fingers {
  double thick = 0;  ///< m, across the jaws
  double half_wide = 0;
};
Fingers fingers_of(const RobotModel& robot) {
  const Vec3 half = finger_half(robot);
  return {2 * half.y, half.x};
}

/// How far a finger may stand from the cube's face on this side, its thickness included, up to
/// `most`; 0 where a neighbour touches.
/// @param lean  m, how far aside tilted fingers are at a cube's top from where their tips are
double room_beside(const Scene& scene, double angle, const Fingers& fingers, double tips,
                   const Vec3& lean, double most) {
  constexpr double kStep = 0.5e-3;  // m
  const Cube& cube = scene.cube;
  const Vec3 u{std::cos(angle), std::sin(angle), 0}, v{-u.y, u.x, 0};
  // From the tips' rectangle to that at the top, and all between.
  const auto meets = [&](double begin, double end, const Vec3& over, double above) {
    const double along = dot(over, u), across = dot(over, v);
    const Plan swept{cube.p_BO + (begin + end + along) / 2 * u + across / 2 * v, angle,
                     (end - begin + std::abs(along)) / 2, fingers.half_wide + std::abs(across) / 2};
    return std::ranges::any_of(scene.beside, [&](const Body& other) {
      return top(other) >= above - kMargin && overlap(swept, plan_of(other, kApart));
    });
  };
  if (meets(0, kHandHalf, {}, tips + kHand)) return 0;
  double room = 0;
  while (room < most && !meets(cube.edge / 2, cube.edge / 2 + room + kStep, lean, tips)) {
    room += kStep;
  }
  return std::min(room, most);
}

/// The roll that turns the jaws' direction, seen from above, to `angle` from the plane's.
double roll_for(double angle, double pitch) {
  double roll = std::atan2(-std::cos(angle) / std::cos(pitch), std::sin(angle));
  if (roll > kPi / 2) roll -= kPi;
  if (roll <= -kPi / 2) roll += kPi;
  return roll;
}

/// Where tips around one cube end, of jaws along one pair of its faces.
class TipPlaces {
 public:
  TipPlaces(const RobotModel& robot, const JawGripper& gripper, const Cube& cube)
      : gripper_(gripper), fingers_(fingers_of(robot)), cube_(cube) {}

  double grip() const {
    const double half = cube_.edge / 2;
    return std::min(half, std::max(kGripLow, kGripShare * cube_.edge)) - half;
  }
  /// Nothing where they would come too near to what the cube stands on, hold too little of it, or
  /// stand askew.
  /// @param along  rad, the direction of the jaws. @param tilt  rad, from straight down, outward
  /// @param room   m, beside the cube, a finger's thickness included
  /// @param up     m, higher than usual
  std::optional<JawGrasp> place(double along, double tilt, double room, double up) const {
    const double yaw = std::atan2(cube_.p_BO.y, cube_.p_BO.x);
    JawGrasp grasp;
    grasp.pitch = kPi - tilt;
    grasp.roll = roll_for(along - yaw, grasp.pitch);
    grasp.room = room - fingers_.thick;
    grasp.open = cube_.edge + 2 * grasp.room;
    grasp.close = std::max(0.0, cube_.edge - kSqueeze);
    // What the lower one of two tilted fingers is lower than the middle of the tips.
    const double skew = std::abs(std::sin(grasp.pitch) * std::sin(grasp.roll));
    const auto lower = [&](double width) {
      return fingers_.half_wide * std::abs(std::sin(tilt)) + skew * (width / 2 + fingers_.thick);
    };
    const double ahead = jaw_reach(gripper_, grasp.close) - jaw_reach(gripper_, grasp.open);
    Vec3 p_closed = cube_.p_BO;
    p_closed.z += grip() + lower(grasp.close) + up;
    const double floor = cube_.p_BO.z - cube_.edge / 2;
    const double lowest = p_closed.z + ahead * std::cos(tilt) - lower(grasp.open);
    const bool is_held = p_closed.z < top(body_of(cube_)) - kHold;
    const bool is_clear = lowest >= floor + kGripLow - kMargin;
    if (skew > kSkewMax || !is_clear || !is_held) return std::nullopt;
    const Vec3 approach{std::sin(grasp.pitch) * std::cos(yaw),
                        std::sin(grasp.pitch) * std::sin(yaw), std::cos(grasp.pitch)};
    grasp.p_BT = p_closed - ahead * approach;
    return grasp;
  }

 private:
  const JawGripper& gripper_;
  Fingers fingers_;
  const Cube& cube_;
};

}  // namespace

Expected<std::vector<JawGrasp>> jaw_grasps(const RobotModel& robot, std::span<const Cube> cubes,
                                           std::size_t which, std::span<const Body> others) {
  const auto* arm = std::get_if<SerialGeometry>(&robot.geometry);
  SINEW_ASSERT(arm != nullptr && arm->gripper && which < cubes.size());
  const JawGripper& gripper = *arm->gripper;
  const Scene scene(cubes, which, others);
  const Cube& cube = scene.cube;
  const Fingers fingers = fingers_of(robot);
  if (scene.is_covered()) return std::unexpected(Error{ErrorCode::kCubeCovered});
  if (cube.edge + 2 * kEnter > gripper.width_max) {
    return std::unexpected(
        Error{ErrorCode::kCubeTooWide, -1, cube.edge, gripper.width_max - 2 * kEnter});
  }
  const TipPlaces places(robot, gripper, cube);
  const double tips = cube.p_BO.z + places.grip();
  const double widest = std::min(kBeside, (gripper.width_max - cube.edge) / 2) + fingers.thick;
  const double needed = fingers.thick + kEnter;
  std::vector<JawGrasp> grasps;
  // Wide jaws may come too near to the arm itself, and a joint may end a little too early.
  const auto add = [&](double along, double tilt, double room) {
    for (const double up : {0.0, 3e-3, -2e-3}) {
      for (const double open : {room, needed}) {
        if (const auto grasp = places.place(along, tilt, open, up)) grasps.push_back(*grasp);
        if (room < needed + kMargin) break;
      }
    }
  };
  double most = 0;
  const double far = std::hypot(cube.p_BO.x, cube.p_BO.y);
  const Vec3 inward = -1 / std::max(far, 1e-9) * Vec3{cube.p_BO.x, cube.p_BO.y, 0};
  const auto add_tilted = [&](double along, double way) {
    for (int step = way > 0 ? 0 : 1; step * kTiltStep <= kTiltMax + 1e-9; ++step) {
      const double tilt = way * step * kTiltStep;
      const Vec3 lean = std::tan(tilt) * (cube.edge / 2 - places.grip()) * inward;
      const double room = std::min(room_beside(scene, along, fingers, tips, lean, widest),
                                   room_beside(scene, along + kPi, fingers, tips, lean, widest));
      most = std::max(most, room);
      if (room < needed) return;  // more tilt takes more
      // As far from a neighbour as from the cube.
      add(along, tilt, room < widest ? (needed + room) / 2 : room);
    }
  };
  for (const double along : {cube.yaw, cube.yaw + kPi / 2}) {
    add_tilted(along, 1);
    add_tilted(along, -1);
  }
  if (grasps.empty()) return std::unexpected(Error{ErrorCode::kCubeCrowded, -1, most, needed});
  std::ranges::stable_sort(grasps, [](const JawGrasp& a, const JawGrasp& b) {
    const double tilt = std::abs(a.pitch - kPi), other = std::abs(b.pitch - kPi);
    return std::abs(tilt - other) > 1e-9 ? tilt < other : a.room > b.room;
  });
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
