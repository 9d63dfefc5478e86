#pragma once

#include <cstdint>
#include <vector>

#include "sinew/model/cell.h"
#include "sinew/planning/collision/collision.h"

namespace sinew::planning {

/// A body in a cell's frame W, and everything within `swell` of it.
struct CellBody {
  PlacedShape form;       ///< in W
  double swell = 0;       ///< m
  Vec3 centre;            ///< of the ball around all of it
  double ball = 0;        ///< its radius, m
  std::uint8_t link = 0;  ///< of its robot, as in model/collision_links.h
};

/// How far two bodies are apart, what they are swollen by taken off; as in shape_distance.h. @rt
double distance(const CellBody& first, const CellBody& second);
/// A bound of it that costs next to nothing. @rt
inline double ball_distance(const CellBody& first, const CellBody& second) {
  return norm(first.centre - second.centre) - first.ball - second.ball;
}

/// Everything between two corners, along the axes of W.
struct CellBlock {
  Vec3 low{1e9, 1e9, 1e9};
  Vec3 high{-1e9, -1e9, -1e9};

  void add(const CellBlock& other);
  /// m; minus infinity where they touch or overlap.
  double distance(const CellBlock& other) const;
};
CellBlock block_around(const CellBody& body);

/// An object of the cell as a body.
CellBody body_of(const CellObject& object);

/// Places of the joints: each within `half` of q.
struct JointBox {
  JointArray q{};
  JointArray half{};
};

/// What a robot fills of its cell, by where its joints are.
class RobotBodies {
 public:
  /// @param model  outlives this
  RobotBodies(const RobotModel& model, const Pose<frame::World, frame::Base>& X_WB);

  const RobotModel& model() const { return collision_.model(); }
  const Pose<frame::World, frame::Base>& X_WB() const { return X_WB_; }
  std::size_t size() const { return reach_.size(); }
  std::size_t joints() const { return model().joints.size(); }
  std::uint8_t link(std::size_t shape) const { return model().collision.shapes[shape].link; }
  /// Moves in no pose.
  bool stands(std::size_t shape) const { return link(shape) == 0; }
  kinematics::PoseBP start_pose() const { return collision_.start_pose(); }

  /// How far any point of a shape is at most from where it is at the middle of a box, m.
  double swell(std::size_t shape, const JointArray& half) const;
  /// Of all shapes the most.
  double swell(const JointArray& half) const;
  /// All shapes where they are at the middle of `box`, each swollen by what the box leaves open.
  /// @return  false where a hexapod's legs have no pose there
  bool place(const JointBox& box, kinematics::PoseBP& X_near, std::span<CellBody> out) const;
  /// What a shape never leaves, wherever the joints are.
  CellBody whole_reach(std::size_t shape) const;

 private:
  CollisionModel collision_;
  Pose<frame::World, frame::Base> X_WB_;
  bool hexapod_;
  std::vector<JointReach> reach_;
};

}  // namespace sinew::planning
