#pragma once

#include <array>
#include <span>

#include "sinew/core/pose.h"
#include "sinew/kinematics/serial_walk.h"
#include "sinew/model/robot_model.h"

namespace sinew::kinematics {

using PoseBF = Pose<frame::Base, frame::Flange>;
using PoseBL = Pose<frame::Base, frame::Link>;

/// Geometric Jacobian of a chain of n joints: column i is what joint i contributes to the flange's
/// twist, J_v in m/rad (velocity of the flange's origin) and J_w (angular velocity), both expressed
/// in base B. Of a prismatic joint J_v has no unit and J_w is zero.
struct Jacobian {
  std::size_t size = 0;
  std::array<Vec3, kMaxJoints> v;
  std::array<Vec3, kMaxJoints> w;
};

/// Forward kinematics of an open chain, with the constants of its DH table folded once. Every
/// function takes `q` in rad (m of a prismatic joint), one per row, |q| <= kSinCosRange. @rt
class SerialChain {
 public:
  explicit SerialChain(const SerialGeometry& geometry);

  std::size_t size() const { return size_; }
  std::span<const DhRow> rows() const { return {rows_.data(), size_}; }

  std::span<const SerialLink> links() const { return {links_.data(), size_}; }

  /// Flange in base; 1e-15 times the arm's length in m and 1e-15 rad.
  PoseBF forward(std::span<const double> q) const;

  /// Flange in base, and the Jacobian there.
  PoseBF forward(std::span<const double> q, Jacobian& J) const;

  /// Both again, in the version that they take on a processor without wide vectors.
  PoseBF forward_portable(std::span<const double> q) const;
  PoseBF forward_portable(std::span<const double> q, Jacobian& J) const;

  /// Every link in base: X[i] is the frame that row i ends with, the last one the flange.
  /// @param X  size() poses
  void frames(std::span<const double> q, std::span<PoseBL> X) const;

  /// X_{i-1,i} of one row: docs/kinematics/serial.md, eq. (1).
  PoseBF link(std::size_t row, double q) const;

  bool slides(std::size_t row) const { return rows_[row].kind == JointKind::kPrismatic; }
  bool has_slide() const { return has_slide_; }

  /// Longest distance from the base origin to the flange that the lengths, and the limits of
  /// prismatic joints, allow, m.
  double reach(std::span<const Joint> joints) const;

 private:
  using Links = std::array<SerialLink, kMaxJoints>;

  template <class V, class Visit>
  PoseBF walk(std::span<const double> q, Visit&& visit) const;
  template <class V, class Visit>
  PoseBF pass(const double* theta, const Links& links, Visit&& visit) const;
  template <class V>
  PoseBF walk(std::span<const double> q, Jacobian& J) const;
  template <class V>
  void walk(std::span<const double> q, std::span<PoseBL> X) const;

  std::size_t size_ = 0;
  std::array<DhRow, kMaxJoints> rows_{};
  Links links_{};
  std::array<double, kMaxJoints> theta_offset_{};
  bool has_slide_ = false;
};

/// Smallest singular value, and product of all of them (Yoshikawa's manipulability), of the
/// Jacobian with its linear rows divided by `length` (m), which makes both free of units.
struct Dexterity {
  double singular_value_min = 0;
  double manipulability = 0;
};
Dexterity dexterity(const Jacobian& J, double length);

}  // namespace sinew::kinematics
