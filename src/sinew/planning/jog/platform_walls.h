#pragma once

#include <cstdint>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/planning/jog/jog_joint.h"
#include "sinew/planning/jog/jog_space.h"

namespace sinew::planning {

/// What a hexapod's platform may not do next: lengthen or shorten a leg any faster, tilt a cardan
/// or a ball joint farther, come nearer to a singularity. Each is a wall in the space of the
/// platform's velocities; a velocity that would go through one is turned along it. @rt
class PlatformWalls {
 public:
  /// Does nothing for other robots.
  explicit PlatformWalls(const JogSpace& space, std::span<const JogJoint> legs);

  /// @param lower, upper  how fast each leg may go at least and at most, m/s
  void look(JogFrame frame, const PoseBT& X_BT, const JointArray& lower, const JointArray& upper);

  /// Legs' velocities for a platform's, scaled as in JogSpace, turned along the walls.
  JointArray legs_for(const TaskArray& task) const;
  /// The platform's velocity that the legs make.
  TaskArray task_of(const JointArray& qd) const;

  /// The wall that turns a velocity most.
  struct Hit {
    bool any = false;
    std::int8_t leg = -1;
    bool length = false;  ///< its length, not one of its joints
  };
  Hit hit(const TaskArray& task) const;

 private:
  struct Wall {
    TaskArray normal{};
    double bound = 0;  ///< normal . task may be this much
    std::int8_t leg = -1;
    bool length = false;
  };
  void add(const TaskArray& twist_B, double bound, std::int8_t leg, bool length);
  void add_joint_angles(const PoseBT& X_BT);
  void add_condition(const PoseBT& X_BT);
  TaskArray in_frame(const TaskArray& twist_B) const;
  TaskArray turned(const TaskArray& task, Hit* hit) const;

  const JogSpace* space_;
  const HexapodGeometry* geometry_;
  double time_ = 1;  ///< s in which a way that is left is used up
  JogFrame frame_ = JogFrame::kBase;
  Rotation R_BT_;
  std::array<TaskArray, kLegs> rows_{};
  FixedVector<Wall, 4 * kLegs + 1> walls_;
};

}  // namespace sinew::planning
