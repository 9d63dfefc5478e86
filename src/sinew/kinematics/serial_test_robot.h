#pragma once

#include <algorithm>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <string>

#include "sinew/kinematics/serial_arm.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::kinematics {

/// A serial robot of the product with what its tests need at hand.
struct SerialRobot {
  explicit SerialRobot(std::string_view id)
      : model(test::robot(id)),
        geometry(std::get<SerialGeometry>(model.geometry)),
        arm(geometry, model.joints, tool_pose(geometry)) {}

  JointVector random_joints(test::Random& random) const {
    JointVector q;
    for (const Joint& joint : model.joints) q.push_back(random.uniform(joint.lower, joint.upper));
    return q;
  }

  /// The same chain for KDL; its frames are built from the DH rows by KDL's own function.
  KDL::Chain kdl_chain() const {
    KDL::Chain chain;
    for (const DhRow& row : geometry.rows) {
      chain.addSegment(kdl_segment(row));
    }
    return chain;
  }

  static KDL::Segment kdl_segment(
      const DhRow& row, const KDL::RigidBodyInertia& body = KDL::RigidBodyInertia::Zero()) {
    const bool slides = row.kind == JointKind::kPrismatic;
    return KDL::Segment(KDL::Joint(slides ? KDL::Joint::TransZ : KDL::Joint::RotZ),
                        KDL::Frame::DH(row.a, row.alpha, row.d, row.theta_offset), body);
  }

  const RobotModel& model;
  const SerialGeometry& geometry;
  SerialArm arm;
};

inline constexpr std::array kSerialRobots{"robot-arm-2", "puma560", "learm", "bigrobotarm",
                                          "scara"};

/// Name of a parametrised test: GoogleTest takes letters, digits and underscores.
inline std::string test_name(const testing::TestParamInfo<const char*>& robot) {
  std::string name = robot.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

inline double position_error(const PoseBT& A, const PoseBT& B) {
  return norm(A.p - B.p);
}

}  // namespace sinew::kinematics
