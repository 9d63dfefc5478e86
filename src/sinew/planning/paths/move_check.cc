#include "sinew/planning/paths/move_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/model/joint_value.h"

namespace sinew::planning {
namespace {

/// Coefficients of one joint's polynomial in Bernstein's basis: it stays within their hull.
using Hull = std::array<double, 6>;

/// Divisions of one piece until what is left of a hull cannot hide anything: 2^-16 of a piece.
constexpr int kDepthMax = 16;

/// rad or m that a joint on its way in may go back: what fitting a way leaves.
constexpr double kTurnBack = 1e-9;

/// A hexapod is looked at so often, m of the path.
constexpr double kLook = 2e-3;

/// One piece by its ends, which say all of a polynomial of degree 5.
struct PieceEnds {
  double h = 0;
  PathPoint from;
  PathPoint to;

  PieceEnds(const JointPath& path, std::size_t i) : h(path.begin(i + 1) - path.begin(i)) {
    path.sample_piece(i, 0, from);
    path.sample_piece(i, h, to);
  }

  /// @param sign  -1: of the joint mirrored
  Hull hull(std::size_t j, double sign) const {
    const double step = h / 5;
    const double bend = h * h / 20;
    return {sign * from.q[j],
            sign * (from.q[j] + step * from.dq[j]),
            sign * (from.q[j] + 2 * step * from.dq[j] + bend * from.ddq[j]),
            sign * (to.q[j] - 2 * step * to.dq[j] + bend * to.ddq[j]),
            sign * (to.q[j] - step * to.dq[j]),
            sign * to.q[j]};
  }
};

double top(const Hull& hull) {
  return *std::max_element(hull.begin(), hull.end());
}

/// De Casteljau at the middle.
void halve(const Hull& whole, Hull& left, Hull& right) {
  Hull row = whole;
  for (std::size_t k = 0; k < row.size(); ++k) {
    left[k] = row[0];
    right[row.size() - 1 - k] = row[row.size() - 1 - k];
    for (std::size_t i = 0; i + 1 < row.size() - k; ++i) row[i] = (row[i] + row[i + 1]) / 2;
  }
}

bool never_rises(const Hull& hull) {
  for (std::size_t k = 0; k + 1 < hull.size(); ++k) {
    if (hull[k + 1] > hull[k] + kTurnBack) return false;
  }
  return true;
}

/// The first u in [0, 1] at which the polynomial is above `limit`; where it begins above, at which
/// it rises before it is below.
/// @param room  the limit, or how far above it may be at the begin; on return, at the end.
std::optional<double> first_above(const Hull& hull, double limit, double& room, int depth = 0) {
  const auto come_in = [&](double q) { room = std::max(limit, std::min(room, q)); };
  if (top(hull) <= limit) {
    room = limit;
    return std::nullopt;
  }
  const bool outside = room > limit;
  const double slack = outside ? kTurnBack : 0;
  if (hull.front() > room + slack) return 0.0;
  come_in(hull.front());
  if (outside && never_rises(hull)) {
    come_in(hull.back());
    return std::nullopt;
  }
  if (depth == kDepthMax) {
    if (hull.back() > room + slack) return 1.0;
    come_in(hull.back());
    return std::nullopt;
  }
  Hull left;
  Hull right;
  halve(hull, left, right);
  if (const auto u = first_above(left, limit, room, depth + 1)) return *u / 2;
  if (const auto u = first_above(right, limit, room, depth + 1)) return 0.5 + *u / 2;
  return std::nullopt;
}

/// The polynomial's greatest value, if it is above `least`.
double greatest(const Hull& hull, double least, int depth = 0) {
  const double ends = std::max({hull.front(), hull.back(), least});
  if (depth == kDepthMax || top(hull) <= ends) return ends;
  Hull left;
  Hull right;
  halve(hull, left, right);
  return greatest(right, greatest(left, ends, depth + 1), depth + 1);
}

/// The farthest that joint j goes to the side of `sign` on these pieces.
double farthest(const JointPath& path, PieceRange pieces, std::size_t j, double sign) {
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t i = pieces.first; i < pieces.last; ++i) {
    most = greatest(PieceEnds(path, i).hull(j, sign), most);
  }
  return sign * most;
}

}  // namespace

JointRoom::JointRoom(std::span<const Joint> joints, const JointArray& q) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    lower[j] = std::min(joints[j].lower - kJointLimitTolerance, q[j]);
    upper[j] = std::max(joints[j].upper + kJointLimitTolerance, q[j]);
  }
}

std::optional<PathFault> first_limit_break(const JointPath& path, PieceRange pieces,
                                           std::span<const Joint> joints) {
  JointRoom inside;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    inside.lower[j] = joints[j].lower - kJointLimitTolerance;
    inside.upper[j] = joints[j].upper + kJointLimitTolerance;
  }
  return first_limit_break(path, pieces, joints, inside);
}

std::optional<PathFault> first_limit_break(const JointPath& path, PieceRange pieces,
                                           std::span<const Joint> joints, JointRoom room) {
  for (std::size_t i = pieces.first; i < pieces.last; ++i) {
    const PieceEnds ends(path, i);
    std::optional<PathFault> first;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const Joint& joint = joints[j];
      for (const double sign : {1.0, -1.0}) {
        const double limit = sign > 0 ? joint.upper : joint.lower;
        double& bound = sign > 0 ? room.upper[j] : room.lower[j];
        double way_out = sign * bound;
        const auto out =
            first_above(ends.hull(j, sign), sign * limit + kJointLimitTolerance, way_out);
        bound = sign * way_out;
        if (!out) continue;
        const double s = path.begin(i) + ends.h * *out;
        if (first && first->s <= s) continue;
        const double q = farthest(path, {i, pieces.last}, j, sign);
        first = PathFault{beyond_limit(joint, j, q, limit), s};
      }
    }
    if (first) return first;
  }
  return std::nullopt;
}

std::optional<PathFault> first_hexapod_refusal(const ToolSpace& space, const JointPath& path,
                                               PieceRange pieces, PoseBT& X_first) {
  const kinematics::Hexapod& hexapod = *space.hexapod();
  const auto look = [&](double s, PoseBT& X_near) -> std::optional<Error> {
    PathPoint at;
    path.sample(s, at);
    const auto X_BT = space.forward(std::span<const double>(at.q.data(), space.size()), X_near);
    if (!X_BT) return X_BT.error();
    X_near = *X_BT;
    for (const Error& wrong :
         hexapod.check(relabel<frame::Base, frame::Platform>(*X_BT), space.joints())) {
      if (wrong.code != ErrorCode::kLegLength) return wrong;
    }
    return std::nullopt;
  };
  const double begin = path.begin(pieces.first);
  const double length = path.begin(pieces.last) - begin;
  const auto looks = static_cast<std::size_t>(std::ceil(std::max(1.0, length / kLook)));
  double good = begin;
  for (std::size_t k = 0; k <= looks; ++k) {
    double s = begin + length * static_cast<double>(k) / static_cast<double>(looks);
    PoseBT X_near = X_first;
    auto wrong = look(s, X_near);
    if (!wrong) {
      good = s;
      X_first = X_near;
      continue;
    }
    // Narrowed down to a tenth of a micrometre.
    while (k > 0 && s - good > 1e-7) {
      const double middle = (good + s) / 2;
      X_near = X_first;
      if (const auto nearer = look(middle, X_near)) {
        s = middle;
        wrong = nearer;
      } else {
        good = middle;
        X_first = X_near;
      }
    }
    return PathFault{*wrong, s};
  }
  return std::nullopt;
}

SlowestPlace slowest_place(const JointPath& path, PieceRange pieces, std::span<const Joint> joints,
                           double joint_share, double shared_velocity) {
  SlowestPlace slowest{path.begin(pieces.first), std::numeric_limits<double>::infinity(), 0, {}};
  for (std::size_t i = pieces.first; i < pieces.last; ++i) {
    const double h = path.begin(i + 1) - path.begin(i);
    for (const double share : {0.0, 0.5, 1.0}) {
      PathPoint at;
      path.sample_piece(i, share * h, at);
      // Of its square, which needs one root in the end; a joint that stays allows anything.
      double square = std::numeric_limits<double>::infinity();
      double speeds = 0;
      PathLimit by;
      const auto holds = [&](double other, LimitKind kind, std::size_t j) {
        if (!(other < square)) return;
        square = other;
        by = {kind, static_cast<std::int8_t>(j)};
      };
      for (std::size_t j = 0; j < joints.size(); ++j) {
        const double rate = joint_share * joints[j].velocity_max / at.dq[j];
        speeds += std::abs(at.dq[j]);
        holds(rate * rate, LimitKind::kJointVelocity, j);
        holds(joints[j].acceleration_max / std::abs(at.ddq[j]), LimitKind::kJointAcceleration, j);
      }
      double rate = std::sqrt(square);
      if (const double shared = joint_share * shared_velocity / speeds; shared < rate) {
        rate = shared;
        by = {LimitKind::kWire, -1};
      }
      slowest.rate_elsewhere = std::max(slowest.rate_elsewhere, rate);
      if (rate >= slowest.rate) continue;
      slowest.rate = rate;
      slowest.by = by;
      slowest.s = path.begin(i) + share * h;
    }
  }
  return slowest;
}

}  // namespace sinew::planning
