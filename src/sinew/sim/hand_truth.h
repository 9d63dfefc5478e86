#pragma once

#include <array>
#include <optional>
#include <variant>

#include "sinew/core/fixed_vector.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/machine.h"
#include "sinew/sim/plan_shape.h"

namespace sinew::frame {
/// Where a hand touches things: the middle between the finger tips, or of a suction cup's mouth. z
/// points away from the hand, y across the jaws.
struct Tip;
}  // namespace sinew::frame

namespace sinew::sim {

/// Two fingers with parallel faces at y = +-width / 2 of the tip's frame.
struct JawTruth {
  double width = 0;  ///< m between them
  Vec3 finger_half;  ///< m, half of a finger's edges: y across the jaws, z along it
  friend bool operator==(const JawTruth&, const JawTruth&) = default;
};

/// A suction cup; its body is taken for a square post.
struct CupTruth {
  double radius = 0;     ///< m, of its mouth
  double length = 0.04;  ///< m, of what stands behind the mouth
  bool pump = false;     ///< on
  friend bool operator==(const CupTruth&, const CupTruth&) = default;
};

/// A hand at one instant, as it really is.
struct HandTruth {
  Pose<frame::World, frame::Tip> X_WT;
  std::variant<JawTruth, CupTruth> grip;
  friend bool operator==(const HandTruth&, const HandTruth&) = default;
};

/// What a hand fills: both fingers, the one at +y first, or the cup.
FixedVector<Block, 2> blocks_of(const HandTruth& hand);

/// m that a hand can be pressed onto something without harm: a cup's bellows give.
double softness(const HandTruth& hand);

/// A hand between two instants. @param share  0 to 1
/// @pre both have the same kind of grip
HandTruth between(const HandTruth& from, const HandTruth& to, double share);

/// The hand of a robot: a serial arm with jaws, or a palletizer with a suction cup. Nothing for
/// others. @pre `truth` is of that robot's machine
/// @param X_WB  its base in the world
std::optional<HandTruth> hand_of(const RobotModel& model, const Truth& truth,
                                 const Pose<frame::World, frame::Base>& X_WB);

}  // namespace sinew::sim
