#include "sinew/kinematics/hexapod.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"

namespace sinew::kinematics {
namespace {

/// A platform whose smallest singular value is below this part of the largest stands on a
/// singularity as far as double can tell.
constexpr double kSingularRatio = 1e-14;
/// A pivot below this part of its column's scale is no pivot.
constexpr double kPivotRatio = 1e-14;
/// Below this part of its scale the determinant of a 3 x 3 block costs too many digits.
constexpr double kDeterminantRatio = 1e-4;

/// A correction that shrinks the residual by less than this is the last with its factorisation.
/// Each one that goes on gains that much, so that their number is bounded too.
constexpr double kGainMin = 20;

/// One Newton step towards the nearest rotation, R (3 I - R^T R) / 2: takes the rounding of many
/// earlier updates out, so that tracking for days does not leave SO(3).
Rotation orthonormalised(const Rotation& R) {
  const double xx = 1.5 - 0.5 * dot(R.x, R.x);
  const double yy = 1.5 - 0.5 * dot(R.y, R.y);
  const double zz = 1.5 - 0.5 * dot(R.z, R.z);
  const double xy = -0.5 * dot(R.x, R.y);
  const double xz = -0.5 * dot(R.x, R.z);
  const double yz = -0.5 * dot(R.y, R.z);
  return {xx * R.x + xy * R.y + xz * R.z, xy * R.x + yy * R.y + yz * R.z,
          xz * R.x + yz * R.y + zz * R.z};
}

/// Cayley's rotation for the small rotation vector w, eq. (11): a proper rotation without sines.
Rotation cayley(const Vec3& w) {
  const Vec3 c = 0.5 * w;
  const double scale = 2 / (1 + dot(c, c));
  const Vec3 sc = scale * c;
  return {{1 - sc.y * c.y - sc.z * c.z, sc.x * c.y + sc.z, sc.x * c.z - sc.y},
          {sc.x * c.y - sc.z, 1 - sc.x * c.x - sc.z * c.z, sc.y * c.z + sc.x},
          {sc.x * c.z + sc.y, sc.y * c.z - sc.x, 1 - sc.x * c.x - sc.y * c.y}};
}

void move_by(const TwistArray& step, PoseBP& X_BP) {
  X_BP.p = X_BP.p + Vec3{step[0], step[1], step[2]};
  X_BP.R = cayley({step[3], step[4], step[5]}) * X_BP.R;
}

double cos_angle_between(const Rotation& A, const Rotation& B) {
  return 0.5 * (dot(A.x, B.x) + dot(A.y, B.y) + dot(A.z, B.z) - 1);
}

/// Over the six legs; not a number where any of them is none.
double sum_of_squares(const LegLanes& f) {
  return (f[0] * f[0] + f[1] * f[1]) + (f[2] * f[2] + f[3] * f[3]) + (f[4] * f[4] + f[5] * f[5]);
}

/// The split of these directions whose first three legs span the largest volume.
LegSplit widest_split(const std::array<Vec3, kLegs>& directions) {
  LegSplit best;
  double volume_max = -1;
  for (unsigned legs = 0; legs < 1U << kLegs; ++legs) {
    if (std::popcount(legs) != 3) continue;
    LegSplit split;
    std::size_t first = 0;
    std::size_t second = 0;
    for (std::size_t i = 0; i < kLegs; ++i) {
      ((legs >> i & 1U) != 0 ? split.first[first++] : split.second[second++]) = i;
    }
    const auto& [a, b, c] = split.first;
    const double volume = std::abs(dot(directions[a], cross(directions[b], directions[c])));
    if (volume <= volume_max) continue;
    volume_max = volume;
    best = split;
  }
  return best;
}

/// Solves with the gradient of the squared lengths: by blocks, or with a search for pivots where
/// they are too close to singular.
class LegSolver {
 public:
  /// @param longest, radius  m: scales of the gradient's linear and angular columns.
  LegSolver(const LegSplit& split, double longest, double radius)
      : split_(split), longest_(longest), radius_(radius) {
    const double volume = longest * longest * longest;
    determinant_min_ = {kDeterminantRatio * volume,
                        kDeterminantRatio * volume * radius * radius * radius};
  }

  bool factor(const LegColumns& gradient) {
    blocks_fit_ = blocks_.factor(gradient, split_, determinant_min_);
    return blocks_fit_ || factor_lu(gradient);
  }
  TwistArray solve(const LegLanes& rhs) const {
    return blocks_fit_ ? blocks_.solve(rhs) : lu_.solve(rhs);
  }

 private:
  [[gnu::noinline]] bool factor_lu(const LegColumns& gradient) {
    const double linear = kPivotRatio * longest_;
    const double angular = linear * radius_;
    return lu_.factor(gradient, {linear, linear, linear, angular, angular, angular});
  }

  LegSplit split_;
  double longest_, radius_;
  std::array<double, 2> determinant_min_;
  bool blocks_fit_ = false;
  LegBlocks blocks_;
  LegLu lu_;
};

}  // namespace

Hexapod::Hexapod(const HexapodGeometry& geometry)
    : p_BA_(lanes(geometry.p_BA)),
      p_PA_(lanes(geometry.p_PA)),
      motor_axis_B_(geometry.motor_axis_B),
      skewer_axis_P_(geometry.skewer_axis_P),
      cardan_angle_max_(geometry.cardan_angle_max),
      ball_angle_max_(geometry.ball_angle_max),
      condition_max_(geometry.condition_max),
      platform_radius_(geometry.platform_radius),
      cos_cardan_min_(std::cos(geometry.cardan_angle_max + kJointLimitTolerance)),
      sin_ball_max_(std::sin(geometry.ball_angle_max + kJointLimitTolerance)),
      cos_turn_min_(std::cos(kHexapodTurnMax)),
      cos_swing_min_(std::cos(std::min(2 * geometry.cardan_angle_max, kPi)) - 1e-9) {
  std::array<Vec3, kLegs> directions;
  for (std::size_t i = 0; i < kLegs; ++i) {
    directions[i] = geometry.X_BP_home * geometry.p_PA[i] - geometry.p_BA[i];
  }
  split_ = widest_split(directions);
}

Hexapod::LaneVectors Hexapod::lanes(const std::array<Vec3, kLegs>& vectors) {
  LaneVectors result;
  for (std::size_t i = 0; i < kLegs; ++i) {
    result.x[i] = vectors[i].x;
    result.y[i] = vectors[i].y;
    result.z[i] = vectors[i].z;
  }
  return result;
}

Hexapod::Placement Hexapod::place(const PoseBP& X_BP) const {
  const auto [R, p] = X_BP;
  Placement placement;
  auto& [u, r] = placement;
  for (std::size_t i = 0; i < kLegs; ++i) {
    const double rx = R.x.x * p_PA_.x[i] + R.y.x * p_PA_.y[i] + R.z.x * p_PA_.z[i];
    const double ry = R.x.y * p_PA_.x[i] + R.y.y * p_PA_.y[i] + R.z.y * p_PA_.z[i];
    const double rz = R.x.z * p_PA_.x[i] + R.y.z * p_PA_.y[i] + R.z.z * p_PA_.z[i];
    r.x[i] = rx;
    r.y[i] = ry;
    r.z[i] = rz;
    u.x[i] = rx + (p.x - p_BA_.x[i]);
    u.y[i] = ry + (p.y - p_BA_.y[i]);
    u.z[i] = rz + (p.z - p_BA_.z[i]);
  }
  return placement;
}

LegLanes Hexapod::squared_lengths(const LaneVectors& u) {
  LegLanes squared;
  for (std::size_t i = 0; i < kLegs; ++i) {
    squared[i] = u.x[i] * u.x[i] + u.y[i] * u.y[i] + u.z[i] * u.z[i];
  }
  return squared;
}

/// Half the gradient of the squared lengths, eq. (9): [u_i, r_i x u_i].
LegColumns Hexapod::squared_length_gradient(const Placement& placement) {
  const auto& [u, r] = placement;
  LegColumns columns{u.x, u.y, u.z};
  for (std::size_t i = 0; i < kLegs; ++i) {
    columns[3][i] = r.y[i] * u.z[i] - r.z[i] * u.y[i];
    columns[4][i] = r.z[i] * u.x[i] - r.x[i] * u.z[i];
    columns[5][i] = r.x[i] * u.y[i] - r.y[i] * u.x[i];
  }
  return columns;
}

JointVector Hexapod::inverse(const PoseBP& X_BP) const {
  const Placement placement = place(X_BP);
  LegLanes lengths = squared_lengths(placement.u);
  for (std::size_t i = 0; i < kLegs; ++i) lengths[i] = std::sqrt(lengths[i]);
  return JointVector(std::span<const double>(lengths.lane.data(), kLegs));
}

Expected<HexapodSolution> Hexapod::forward(const JointVector& legs, const PoseBP& X_BP_last) const {
  SINEW_ASSERT(legs.size() == kLegs);
  LegLanes squared_targets;
  double shortest = legs[0];
  double longest = legs[0];
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!(legs[i] > 0)) {
      return std::unexpected(Error{ErrorCode::kLegLength, static_cast<std::int8_t>(i), legs[i], 0});
    }
    squared_targets[i] = legs[i] * legs[i];
    shortest = std::min(shortest, legs[i]);
    longest = std::max(longest, legs[i]);
  }

  HexapodSolution solution{{orthonormalised(X_BP_last.R), X_BP_last.p}};
  Placement placement = place(solution.X_BP);
  const LaneVectors u_last = placement.u;
  LegSolver solver(split_, longest, platform_radius_);
  LegLanes f;
  // All errors are squares of lengths here, and their comparisons need no root.
  const double squared_end = kHexapodResidual * kHexapodResidual * shortest * shortest;
  double squared_error = 0;
  const auto converged = [&] {
    const LegLanes squared = squared_lengths(placement.u);
    for (std::size_t i = 0; i < kLegs; ++i) f[i] = 0.5 * (squared_targets[i] - squared[i]);
    squared_error = sum_of_squares(f);
    return squared_error <= squared_end;
  };
  bool done = converged();
  while (!done) {
    if (solution.iterations == kHexapodIterationsMax) {
      return std::unexpected(Error{ErrorCode::kNotConverged, -1,
                                   std::sqrt(squared_error) / shortest, kHexapodResidual});
    }
    if (!solver.factor(squared_length_gradient(placement))) {
      return std::unexpected(singular(solution.X_BP));
    }
    ++solution.iterations;
    // A correction costs a third of a factorisation: the second makes the convergence cubic, and
    // more of them pay while each gains more than a digit, eq. (12).
    bool gains = true;
    for (int correction = 0; !done && (correction < 2 || gains); ++correction) {
      const double before = squared_error;
      move_by(solver.solve(f), solution.X_BP);
      placement = place(solution.X_BP);
      done = converged();
      gains = before >= kGainMin * kGainMin * squared_error;
    }
  }
  solution.residual = std::sqrt(squared_error) / shortest;
  if (const auto refusal = other_assembly(solution.X_BP, X_BP_last, placement.u, u_last)) {
    return std::unexpected(*refusal);
  }
  return solution;
}

std::optional<Error> Hexapod::other_assembly(const PoseBP& X_BP, const PoseBP& X_BP_last,
                                             const LaneVectors& u,
                                             const LaneVectors& u_last) const {
  if (!(cos_angle_between(X_BP.R, X_BP_last.R) >= cos_turn_min_)) {
    return Error{ErrorCode::kAmbiguousAssembly, -1, angle_between(X_BP.R, X_BP_last.R),
                 kHexapodTurnMax};
  }
  const LegLanes squared = squared_lengths(u);
  const LegLanes squared_last = squared_lengths(u_last);
  // The mirrored assembly below the base has the same rotation; its legs have swung over.
  for (std::size_t i = 0; i < kLegs; ++i) {
    const double cos_swing = (u.x[i] * u_last.x[i] + u.y[i] * u_last.y[i] + u.z[i] * u_last.z[i]) /
                             std::sqrt(squared[i] * squared_last[i]);
    if (!(cos_swing >= cos_swing_min_)) {
      return Error{ErrorCode::kAmbiguousAssembly, static_cast<std::int8_t>(i),
                   std::acos(std::clamp(cos_swing, -1.0, 1.0)), 2 * cardan_angle_max_};
    }
  }
  return std::nullopt;
}

Error Hexapod::singular(const PoseBP& X_BP) const {
  return {ErrorCode::kSingular, -1, dexterity(X_BP).singular_value_min, kSingularRatio};
}

HexapodViolations Hexapod::check(const PoseBP& X_BP, std::span<const Joint> legs) const {
  SINEW_ASSERT(legs.size() == kLegs);
  HexapodViolations violations;
  const Placement placement = place(X_BP);
  const LaneVectors& u = placement.u;
  for (std::size_t i = 0; i < kLegs; ++i) {
    const auto leg = static_cast<std::int8_t>(i);
    const Vec3 leg_B{u.x[i], u.y[i], u.z[i]};
    const double length = norm(leg_B);
    if (!within_limits(legs[i], length)) {
      const double limit = length < legs[i].lower ? legs[i].lower : legs[i].upper;
      violations.push_back({ErrorCode::kLegLength, leg, length, limit});
    }
    const double cos_cardan = dot(leg_B, motor_axis_B_[i]) / length;
    if (!(cos_cardan >= cos_cardan_min_)) {
      const double angle =
          std::atan2(norm(cross(leg_B, motor_axis_B_[i])), dot(leg_B, motor_axis_B_[i]));
      violations.push_back({ErrorCode::kCardanAngle, leg, angle, cardan_angle_max_});
    }
    const double sin_ball = std::abs(dot(leg_B, X_BP.R * skewer_axis_P_[i])) / length;
    if (!(sin_ball <= sin_ball_max_)) {
      violations.push_back(
          {ErrorCode::kBallAngle, leg, std::asin(std::min(sin_ball, 1.0)), ball_angle_max_});
    }
  }
  const double condition = dexterity(X_BP).condition;
  if (!(condition <= condition_max_)) {
    violations.push_back({ErrorCode::kConditionNumber, -1, condition, condition_max_});
  }
  return violations;
}

HexapodJacobian Hexapod::jacobian(const PoseBP& X_BP) const {
  const Placement placement = place(X_BP);
  const LegColumns columns = squared_length_gradient(placement);
  const LegLanes squared = squared_lengths(placement.u);
  HexapodJacobian J{};
  for (std::size_t i = 0; i < kLegs; ++i) {
    const double inverse_length = 1 / std::sqrt(squared[i]);
    for (std::size_t k = 0; k < kTwistSize; ++k) J[i][k] = columns[k][i] * inverse_length;
  }
  return J;
}

HexapodDexterity Hexapod::dexterity(const PoseBP& X_BP) const {
  const Placement placement = place(X_BP);
  LegColumns columns = squared_length_gradient(placement);
  const LegLanes squared = squared_lengths(placement.u);
  for (std::size_t i = 0; i < kLegs; ++i) {
    const double inverse_length = 1 / std::sqrt(squared[i]);
    for (std::size_t k = 0; k < kTwistSize; ++k) {
      columns[k][i] *= k < 3 ? inverse_length : inverse_length / platform_radius_;
    }
  }
  const SingularRange range = singular_range(columns);
  const bool is_singular = range.min <= kSingularRatio * range.max;
  return {range.min, is_singular ? std::numeric_limits<double>::infinity() : range.max / range.min};
}

}  // namespace sinew::kinematics
