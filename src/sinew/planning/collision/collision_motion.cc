// Motions: from distances at one place to the next place that has to be looked at.

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"
#include "sinew/planning/collision/collision.h"

namespace sinew::planning {
namespace {

using kinematics::PoseBP;

/// Where even the balls around two bodies are so far beyond the margin their exact distance is not
/// worth its time, m.
constexpr double kFar = 0.1;

}  // namespace

CollisionModel::Budgets::Budgets(std::size_t pairs) {
  renew(pairs);
  std::fill_n(measured.begin(), pairs, 0.0);
}

void CollisionModel::Budgets::renew(std::size_t pairs) {
  std::fill_n(left.begin(), pairs, 0.0);
}

bool CollisionModel::Budgets::is_due(std::size_t pair) const {
  constexpr double kShare = 0.25;
  return left[pair] <= kShare * measured[pair];
}

/// What is left for each pair until it is at the margin; the nearest of those that are there.
Clearance CollisionModel::measure(const Scene& scene, double margin, const Excused* excused,
                                  Budgets& budgets) const {
  Clearance worst;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    if (!budgets.is_due(p)) continue;
    if (excused != nullptr && (*excused)[p]) {
      budgets.set(p, kInfinity);
      continue;
    }
    double apart = ball_distance(scene, pairs_[p]);
    if (apart - margin <= kFar) apart = distance(scene, pairs_[p]);
    budgets.set(p, apart - margin);
    if (apart - margin <= kResolution && apart < worst.distance) {
      worst = {apart, pairs_[p].first, pairs_[p].second};
    }
  }
  return worst;
}

/// Goes on with the joints at these speeds for `way` or until the first budget is used up.
double CollisionModel::spend(const JointArray& speeds, double way, Budgets& budgets) const {
  JointArray moves = speeds;
  if (std::holds_alternative<kinematics::Hexapod>(robot_)) {
    double squares = 0;
    for (const double speed : speeds) squares += speed * speed;
    moves = {std::sqrt(squares)};
  }
  PerPair approach;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    double sum = 0;
    for (std::size_t k = 0; k < kMaxJoints; ++k) sum += moves[k] * pairs_[p].reach[k];
    approach[p] = sum;
    if (sum * way > budgets.left[p]) way = budgets.left[p] / sum;
  }
  for (std::size_t p = 0; p < pairs_.size(); ++p) budgets.left[p] -= approach[p] * way;
  return way;
}

bool CollisionModel::bound_holds(const PoseBP& X_BP) const {
  const auto* hexapod = std::get_if<kinematics::Hexapod>(&robot_);
  if (hexapod == nullptr) return true;
  const double allowed = std::get<HexapodGeometry>(model_->geometry).condition_max;
  return hexapod->dexterity(X_BP).condition <= allowed;
}

/// The same, where each pair may be no nearer than `least`, which grows as they come apart.
Clearance CollisionModel::measure_leaving(const Scene& scene, PerPair& least,
                                          Budgets& budgets) const {
  Clearance worst;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    // One that still comes apart is looked at each time, or its way back in would not be seen.
    if (least[p] >= margin() && !budgets.is_due(p)) continue;
    double apart = ball_distance(scene, pairs_[p]);
    if (apart - margin() <= kFar) apart = distance(scene, pairs_[p]);
    if (apart - least[p] <= kResolution && apart < worst.distance) {
      worst = {apart, pairs_[p].first, pairs_[p].second};
    }
    least[p] = std::max(least[p], std::min(margin(), apart - 2 * kResolution));
    budgets.set(p, apart - least[p]);
  }
  return worst;
}

std::optional<PathContact> CollisionModel::check_path(const JointPath& path, double margin,
                                                      double begin, double end,
                                                      const PoseBP* X_near) const {
  return first_of_poses(path, begin, X_near, [&](std::size_t pose, double here) {
    Budgets budgets(pairs_.size());
    // What one pose is too near to shall not hide what another one comes near to.
    const double least = left_out_.empty() ? margin : std::min(margin, here - 2 * kResolution);
    return walk(path, begin, end, X_near, budgets, pose,
                [&](const Scene& scene) { return measure(scene, least, nullptr, budgets); });
  });
}

template <class Check>
std::optional<PathContact> CollisionModel::first_of_poses(const JointPath& path, double begin,
                                                          const PoseBP* X_near,
                                                          const Check& check) const {
  if (left_out_.empty() || path.empty()) return check(0, kInfinity);
  PathPoint from;
  path.sample(std::clamp(begin, 0.0, path.length()), from);
  const std::span<const double> q(from.q.data(), path.joints());
  std::optional<PathContact> first;
  for (std::size_t pose = 0; pose < poses_.size(); ++pose) {
    if (!possible(pose, q, X_near)) continue;
    const auto contact = check(pose, distance_in(pose, q, X_near).distance);
    if (contact && (!first || contact->s < first->s)) first = contact;
  }
  return first;
}

std::optional<PathContact> CollisionModel::check_leaving(const JointPath& path,
                                                         const PoseBP* X_near) const {
  return first_of_poses(path, 0, X_near, [&](std::size_t pose, double /*here*/) {
    Budgets budgets(pairs_.size());
    PerPair least;
    std::fill_n(least.begin(), pairs_.size(), -kInfinity);
    return walk(path, 0, path.length(), X_near, budgets, pose,
                [&](const Scene& scene) { return measure_leaving(scene, least, budgets); });
  });
}

template <class Measure>
std::optional<PathContact> CollisionModel::walk(const JointPath& path, double begin, double end,
                                                const PoseBP* X_near, Budgets& budgets,
                                                std::size_t pose, const Measure& measure) const {
  SINEW_ASSERT(path.joints() == model_->joints.size());
  if (path.empty() || pairs_.empty()) return std::nullopt;
  end = std::min(end, path.length());
  double s = std::clamp(begin, 0.0, end);
  std::size_t piece = path.piece_at(s);
  Scene scene;
  PoseBP X_BP = start(X_near);
  PathPoint point;
  const auto look = [&]() -> std::optional<PathContact> {
    path.sample_piece(piece, s - path.begin(piece), point);
    const JointArray at = posed({point.q.data(), path.joints()}, pose);
    if (!place({at.data(), path.joints()}, X_BP, scene) || !bound_holds(X_BP)) {
      return PathContact{s, {-kInfinity}};
    }
    const Clearance nearest = measure(scene);
    if (nearest.distance < kInfinity) return PathContact{s, nearest};
    return std::nullopt;
  };
  if (const auto contact = look()) return contact;
  while (s < end) {
    const double from = path.begin(piece);
    const double to = std::min(path.begin(piece + 1), end);
    path.bound_piece(piece, s - from, to - from, point);
    const double way = spend(point.dq, to - s, budgets);
    s = way < to - s ? s + way : to;
    if (s < to) {
      if (const auto contact = look()) return contact;
    } else if (piece + 1 < path.size()) {
      ++piece;
    }
  }
  return std::nullopt;
}

double CollisionModel::free_time(std::span<const double> q, std::span<const double> qd,
                                 double horizon, double margin, const PoseBP* X_near) const {
  double free = horizon;
  for (std::size_t pose = 0; pose < poses_.size() && free > 0; ++pose) {
    if (possible(pose, q, X_near)) free = free_time_in(pose, q, qd, free, margin, X_near);
  }
  return free;
}

double CollisionModel::free_time_in(std::size_t pose, std::span<const double> q,
                                    std::span<const double> qd, double horizon, double margin,
                                    const PoseBP* X_near) const {
  SINEW_ASSERT(q.size() == qd.size() && q.size() == model_->joints.size());
  Scene scene;
  PoseBP X_BP = start(X_near);
  JointArray speeds{}, at{};
  double fastest = 0;
  for (std::size_t k = 0; k < qd.size(); ++k) {
    speeds[k] = std::abs(qd[k]);
    fastest = std::max(fastest, speeds[k]);
  }
  if (fastest == 0 || pairs_.empty()) return horizon;
  const auto place_at = [&](double t) {
    for (std::size_t k = 0; k < qd.size(); ++k) at[k] = q[k] + t * qd[k];
    at = posed({at.data(), q.size()}, pose);
    return place({at.data(), q.size()}, X_BP, scene) && bound_holds(X_BP);
  };
  if (!place_at(0)) return 0;
  Budgets budgets(pairs_.size());
  Excused excused{};
  if (measure(scene, margin, nullptr, budgets).distance < kInfinity) {
    // Some are too near already. A hair's breadth on: have they come nearer still?
    const Scene before = scene;
    if (!place_at(1e-6 / fastest)) return 0;
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      if (budgets.left[p] > kResolution) continue;
      constexpr double kRounding = 1e-12;  // m
      if (distance(scene, pairs_[p]) < distance(before, pairs_[p]) - kRounding) return 0;
      excused[p] = true;
      budgets.set(p, kInfinity);
    }
  }
  constexpr int kLooksMax = 64;  // bounds the time that this takes
  double t = 0;
  for (int looks = 0; looks < kLooksMax; ++looks) {
    const double way = spend(speeds, horizon - t, budgets);
    if (way >= horizon - t) return horizon;
    t += way;
    if (!place_at(t)) return t;
    budgets.renew(pairs_.size());  // so that few looks reach far
    if (measure(scene, margin, &excused, budgets).distance < kInfinity) return t;
  }
  return t;
}

double CollisionModel::speed_share(std::span<const double> q, std::span<const double> qd,
                                   double margin, const PoseBP* X_near) const {
  // A jog at the share x of qd comes to rest over x (r x + 3 c) / 2 seconds' worth of way at qd:
  // r for the velocity to fall at the joints' accelerations, c for an acceleration to build up, and
  // twice that for one that the jog may have in the wrong direction.
  double r = 0, c = 0;
  for (std::size_t k = 0; k < qd.size(); ++k) {
    if (qd[k] == 0) continue;
    const Joint& joint = model_->joints[k];
    r = std::max(r, std::abs(qd[k]) / joint.acceleration_max);
    c = std::max(c, joint.acceleration_max / joint.jerk_max);
  }
  if (r == 0) return 1;
  const double horizon = (r + 3 * c) / 2;
  const double free = free_time(q, qd, horizon, margin, X_near);
  if (free >= horizon) return 1;
  return 4 * free / (3 * c + std::sqrt(9 * c * c + 8 * r * free));
}

}  // namespace sinew::planning
