#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/planning/paths/move_path.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::planning {

inline constexpr std::array kPathRobots{"robot-arm-2", "puma560", "learm",
                                        "bigrobotarm", "maxarm",  "hexapod"};

/// A robot of the product with what its path tests need at hand.
struct PathRobot {
  explicit PathRobot(std::string_view id)
      : model(test::robot(id)), space(model), builder(space), path(space.size()) {}

  std::span<const double> joints(const JointArray& q) const { return {q.data(), space.size()}; }

  bool is_hexapod() const { return space.hexapod() != nullptr; }

  RobotPlace place(const JointArray& q, const PoseBT& X_near) const {
    const auto found = builder.place_at(joints(q), X_near);
    EXPECT_TRUE(found) << describe(found.error());
    return found ? *found : RobotPlace{};
  }

  /// Somewhere inside the limits; a hexapod's platform near its home.
  RobotPlace random_place(test::Random& random) const {
    RobotPlace place;
    if (is_hexapod()) {
      const auto some = [&](double scale) {
        return Vec3{random.uniform(-scale, scale), random.uniform(-scale, scale),
                    random.uniform(-scale, scale)};
      };
      const PoseBT X_home = space.home();
      place.X_BT = {rotation_from_vector(some(0.15)) * X_home.R, X_home.p + some(0.03)};
      place.q = *space.inverse_near(space.point(place.X_BT), {});
      return place;
    }
    do {
      for (std::size_t j = 0; j < space.size(); ++j) {
        const Joint& joint = model.joints[j];
        place.q[j] = random.uniform(joint.lower, joint.upper);
      }
      place.X_BT = *space.forward(joints(place.q), {});
    } while (!can_be(place));
    return place;
  }

  /// Not with a palletizer's elbow turned over, or its nozzle behind the base.
  bool can_be(const RobotPlace& place) const {
    const auto q = space.inverse_near(space.point(place.X_BT), place.q);
    if (!q) return false;
    for (std::size_t j = 0; j < space.size(); ++j) {
      if (std::abs((*q)[j] - place.q[j]) > 1e-6) return false;
    }
    return true;
  }

  /// Somewhere whose joints are at most `stride` (rad) from those of `from`, inside the limits.
  RobotPlace random_neighbour(test::Random& random, const RobotPlace& from, double stride) const {
    if (is_hexapod()) return random_place(random);
    RobotPlace place;
    do {
      for (std::size_t j = 0; j < space.size(); ++j) {
        const Joint& joint = model.joints[j];
        place.q[j] = random.uniform(std::max(joint.lower, from.q[j] - stride),
                                    std::min(joint.upper, from.q[j] + stride));
      }
      place.X_BT = *space.forward(joints(place.q), {});
    } while (!can_be(place));
    return place;
  }

  const RobotModel& model;
  ToolSpace space;
  MovePathBuilder builder;
  PlannedPath path;
};

/// Name of a parametrised test: GoogleTest takes letters, digits and underscores.
inline std::string path_robot_name(const testing::TestParamInfo<const char*>& robot) {
  std::string name = robot.param;
  for (char& letter : name) letter = letter == '-' ? '_' : letter;
  return name;
}

inline Move line_to(const PoseBT& X_BT) {
  return {.way = MoveL{{X_BT}}};
}
inline Move joints_to(const JointArray& q) {
  return {.way = MoveJ{q}};
}

/// q, dq and ddq of each piece end where those of the next one begin.
inline void expect_smooth(const JointPath& path) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    PathPoint before;
    PathPoint behind;
    const double h = path.begin(i + 1) - path.begin(i);
    path.sample_piece(i, h, before);
    path.sample_piece(i + 1, 0, behind);
    for (std::size_t j = 0; j < path.joints(); ++j) {
      EXPECT_NEAR(before.q[j], behind.q[j], 1e-11);
      EXPECT_NEAR(before.dq[j], behind.dq[j], 1e-8 * (1 + std::abs(before.dq[j])));
      EXPECT_NEAR(before.ddq[j], behind.ddq[j], 1e-6 * (1 + std::abs(before.ddq[j]) + 1 / h));
    }
  }
}

}  // namespace sinew::planning
