#include "cubes/reach.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/model/tool_body.h"
#include "sinew/planning/collision/collision.h"
#include "sinew/planning/paths/tool_space.h"

namespace sinew::cubes {
namespace {

using grasping::Cube;
using planning::PlacedBox;
using planning::ToolSpace;

// What the refusals promise to keep, as docs/vision.md has them.
constexpr double kClear = 3e-3;             // m, to other cubes
constexpr double kEnter = 3e-3;             // m, beside the cube on each side
constexpr double kTableClear = 5e-3;        // m, below the tips
constexpr double kSqueeze = 3e-3;           // m
constexpr double kHold = 5e-3;              // m, that closed tips reach below the top
constexpr double kSkewMax = 0.22;           // sine: jaws to table
constexpr double kAbove = 20e-3;            // m, from where it goes down
constexpr double kCup = 12e-3;              // m, radius
const Vec3 kHandHalf{14e-3, 42e-3, 25e-3};  // m, of the box of the hand in learm.toml
constexpr double kHandUp = 25e-3;  // m, from the tips of closed jaws to the hand's lower end

PlacedBox box_of(const Cube& cube) {
  const double half = cube.edge / 2;
  return {{rotation_z(cube.yaw), cube.p_BO}, {half, half, half}};
}

PlacedBox box_at(const planning::PoseBT& X_BT, const Vec3& p_T, const Vec3& half) {
  return {{X_BT.R, X_BT * p_T}, half};
}

class Jaws {
 public:
  Jaws(const RobotModel& robot, std::span<const Cube> cubes, std::span<const PlacedBox> fixed,
       std::size_t which, double slack)
      : robot_(robot),
        gripper_(*std::get<SerialGeometry>(robot.geometry).gripper),
        cubes_(cubes),
        fixed_(fixed),
        which_(which),
        slack_(slack),
        collision_(robot),
        closed_(robot) {
    closed_.fit({.jaws = cubes[which].edge - kSqueeze, .held = cubes[which].edge});
  }

  bool any() {
    const Cube& cube = cubes_[which_];
    for (double open = cube.edge + 2 * kEnter; open <= gripper_.width_max; open += 3e-3) {
      const ToolSpace space(robot_, open);
      collision_.fit({.jaws = open, .held = {}});
      for (int tilt = 0; tilt <= 50; tilt += 2) {
        for (const double way : {1.0, -1.0}) {
          if (tilt == 0 && way < 0) continue;
          for (const double along : {cube.yaw, cube.yaw + kPi / 2}) {
            if (any_height(space, kPi - way * from_deg(tilt), along, open)) return true;
          }
        }
      }
    }
    return false;
  }

 private:
  bool any_height(const ToolSpace& space, double pitch, double along, double open) {
    const Cube& cube = cubes_[which_];
    const double yaw = std::atan2(cube.p_BO.y, cube.p_BO.x);
    double roll = std::atan2(-std::cos(along - yaw) / std::cos(pitch), std::sin(along - yaw));
    const Rotation R = rotation_z(yaw) * rotation_y(pitch) * rotation_z(roll);
    if (std::abs(R.y.z) > kSkewMax) return false;
    const double ahead =
        jaw_reach(gripper_, cube.edge - kSqueeze) - jaw_reach(gripper_, open);  // m
    for (double tips = -cube.edge / 2; tips <= cube.edge / 2 - kHold; tips += 1e-3) {
      const Vec3 p_closed = cube.p_BO + Vec3{0, 0, tips};
      const planning::PoseBT X_BT{R, p_closed - ahead * R.z};
      for (const double turn : {0.0, kPi}) {
        if (is_clear(X_BT, open) && is_reached(space, X_BT, pitch, roll + turn)) return true;
      }
    }
    return false;
  }

  bool is_clear(const planning::PoseBT& X_BT, double open) const {
    const Vec3 finger = finger_half(robot_);
    const Cube& cube = cubes_[which_];
    const double closed = cube.edge - kSqueeze;
    const double ahead = jaw_reach(gripper_, closed) - jaw_reach(gripper_, open);
    for (double up = 0; up <= kAbove; up += 5e-3) {
      planning::PoseBT X = X_BT;
      X.p.z += up;
      // Behind the closed tips stands the hand, ahead of it are the fingers.
      const PlacedBox hand = box_at(X, {0, 0, ahead - kHandUp - kHandHalf.z}, kHandHalf);
      for (const double side : {1.0, -1.0}) {
        const double y = side * (open / 2 + finger.y);
        const PlacedBox one = box_at(X, {0, y, -finger.z}, finger);
        if (planning::distance(one, box_of(cube)) < kEnter / 2) return false;
        // Closing, they go on ahead and to the cube; what they sweep then.
        const double inner = cube.edge / 2, outer = open / 2 + 2 * finger.y;
        const PlacedBox swept = box_at(X, {0, side * (inner + outer) / 2, ahead / 2 - finger.z},
                                       {finger.x, (outer - inner) / 2, finger.z + ahead / 2});
        const PlacedBox& body = up > 0 ? one : swept;
        if (planning::distance_above(body, 0) < kTableClear) return false;
        if (!is_apart(body)) return false;
      }
      if (!is_apart(hand)) return false;
    }
    return true;
  }

  bool is_apart(const PlacedBox& body) const {
    for (std::size_t i = 0; i < cubes_.size(); ++i) {
      if (i == which_) continue;
      if (planning::distance(body, box_of(cubes_[i])) < kClear + slack_) return false;
    }
    return std::ranges::all_of(fixed_, [&](const PlacedBox& box) {
      return planning::distance(body, box) >= kClear + slack_;
    });
  }

  bool is_reached(const ToolSpace& space, const planning::PoseBT& X_BT, double pitch, double roll) {
    for (const double up : {kAbove, kAbove / 2, 0.0}) {
      planning::TaskPoint at{X_BT.p + Vec3{0, 0, up}, {}};
      at.attitude = {pitch, std::remainder(roll, 2 * kPi), 0, 0};
      const auto branches = space.branches(at, {});
      const bool any = std::ranges::any_of(branches, [&](const planning::JointArray& q) {
        const std::span joints{q.data(), space.size()};
        return collision_.clear(joints, collision_.margin()) &&
               (up > 0 || closed_.clear(joints, closed_.margin()));
      });
      if (!any) return false;
    }
    return true;
  }

  const RobotModel& robot_;
  JawGripper gripper_;
  std::span<const Cube> cubes_;
  std::span<const PlacedBox> fixed_;
  std::size_t which_;
  double slack_;
  planning::CollisionModel collision_;  ///< with open jaws
  planning::CollisionModel closed_;
};

bool cup_takes(const RobotModel& robot, std::span<const Cube> cubes,
               std::span<const PlacedBox> fixed, std::size_t which, double slack) {
  const auto& geometry = std::get<PalletizerGeometry>(robot.geometry);
  const Cube& cube = cubes[which];
  const double top = cube.p_BO.z + cube.edge / 2;
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    if (i == which || cubes[i].p_BO.z + cubes[i].edge / 2 < top + 2e-3) continue;
    const Vec3 between = cubes[i].p_BO - cube.p_BO;
    const double near = std::hypot(between.x, between.y) - cubes[i].edge / 2;
    if (near < kCup + kClear + slack) return false;
  }
  const Vec3 lip = cube.p_BO + Vec3{0, 0, cube.edge / 2};
  const planning::PlacedCapsule cup{lip + Vec3{0, 0, kCup}, lip + Vec3{0, 0, cup_reach(robot)},
                                    kCup};
  const bool is_clear = std::ranges::all_of(
      fixed, [&](const PlacedBox& box) { return planning::distance(cup, box) >= kClear + slack; });
  if (!is_clear) return false;
  planning::CollisionModel collision(robot);
  for (const double up : {kAbove, kAbove / 2, 0.0}) {
    const Vec3 p{cube.p_BO.x, cube.p_BO.y, top + cup_reach(robot) + up};
    const auto q = kinematics::inverse(geometry, robot.joints, p);
    if (!q || !collision.clear({q->data(), q->size()}, collision.margin())) return false;
  }
  return true;
}

}  // namespace

bool can_take(const RobotModel& robot, std::span<const Cube> cubes,
              std::span<const PlacedBox> fixed, std::size_t which, double slack) {
  std::vector<Cube> moved(cubes.begin(), cubes.end());
  const auto takes = [&] {
    if (std::holds_alternative<PalletizerGeometry>(robot.geometry)) {
      return cup_takes(robot, moved, fixed, which, slack);
    }
    return Jaws(robot, moved, fixed, which, slack).any();
  };
  if (!takes()) return false;
  if (slack == 0) return true;
  for (const double x : {slack, -slack}) {
    for (const double y : {slack, -slack}) {
      moved[which].p_BO = cubes[which].p_BO + Vec3{x, y, 0};
      if (!takes()) return false;
    }
  }
  return true;
}

std::vector<bool> can_be_taken(const RobotModel& robot, std::span<const Cube> cubes,
                               std::span<const PlacedBox> fixed, double slack) {
  std::vector<bool> taken(cubes.size(), false);
  for (bool goes_on = true; goes_on;) {
    goes_on = false;
    std::vector<Cube> left;
    std::vector<std::size_t> index;
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      if (taken[i]) continue;
      left.push_back(cubes[i]);
      index.push_back(i);
    }
    for (std::size_t k = 0; k < left.size(); ++k) {
      if (!can_take(robot, left, fixed, k, slack)) continue;
      taken[index[k]] = goes_on = true;
    }
  }
  return taken;
}

}  // namespace sinew::cubes
