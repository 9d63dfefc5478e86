#include "sinew/planning/studies/pose_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "sinew/core/split_mix.h"
#include "sinew/kinematics/palletizer.h"

namespace sinew::planning {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();
constexpr std::size_t kClimbs = 3;
constexpr int kClimbSteps = 500;
constexpr double kFirstStep = 0.1;  // of the range
constexpr double kLastStep = 1e-7;
constexpr double kGrow = 1.7, kShrink = 0.88;  // one step in five succeeds where neither wins
constexpr std::size_t kTriesPerPose = 50;
constexpr double kPlatformWay = 0.1;  // m around home
constexpr double kPlatformTurn = from_deg(30);
/// Of the score: a joint that changes it by less does not matter.
constexpr double kSame = 1e-4;
constexpr double kNothing = 1e-9;  // a score that is nothing

}  // namespace

PoseSearch::PoseSearch(const RobotModel& model) : model_(model), size_(model.joints.size()) {
  if (const auto* geometry = std::get_if<HexapodGeometry>(&model_.geometry)) {
    hexapod_.emplace(*geometry);
    for (std::size_t i = 0; i < size_; ++i) {
      upper_[i] = i < 3 ? kPlatformWay : kPlatformTurn;
      lower_[i] = -upper_[i];
    }
  } else {
    for (std::size_t i = 0; i < size_; ++i) {
      lower_[i] = model_.joints[i].lower;
      upper_[i] = model_.joints[i].upper;
    }
  }
  SplitMix64 random(1);
  shares_.push_back(share_of_home());
  for (std::size_t tries = 0; tries < kPoses * kTriesPerPose && shares_.size() < kPoses; ++tries) {
    Share share{};
    for (std::size_t i = 0; i < size_; ++i) share[i] = random.uniform(0, 1);
    if (configuration(share)) shares_.push_back(share);
  }
  for (const Share& share : shares_) {
    poses_.push_back(configuration(share).value_or(JointVector{}));
  }
}

PoseSearch::Share PoseSearch::share_of_home() const {
  Share share{};
  for (std::size_t i = 0; i < size_; ++i) {
    share[i] = hexapod_ ? 0.5 : (model_.joints[i].home - lower_[i]) / (upper_[i] - lower_[i]);
  }
  return share;
}

std::optional<JointVector> PoseSearch::configuration(const Share& share) const {
  JointVector q;
  for (std::size_t i = 0; i < size_; ++i) {
    q.push_back(std::lerp(lower_[i], upper_[i], share[i]));
  }
  if (hexapod_) {
    const auto& home = std::get<HexapodGeometry>(model_.geometry).X_BP_home;
    const kinematics::PoseBP X_BP{home.R * rotation_from_vector({q[3], q[4], q[5]}),
                                  home.p + Vec3{q[0], q[1], q[2]}};
    if (!hexapod_->check(X_BP, model_.joints).empty()) return std::nullopt;
    return hexapod_->inverse(X_BP);
  }
  if (const auto* geometry = std::get_if<PalletizerGeometry>(&model_.geometry)) {
    // Angles that the linkage can have are those that come back from where they put the nozzle.
    const auto back =
        kinematics::inverse(*geometry, model_.joints, kinematics::forward(*geometry, q).p);
    if (!back) return std::nullopt;
    for (std::size_t i = 0; i < size_; ++i) {
      if (std::abs((*back)[i] - q[i]) > 1e-6) return std::nullopt;
    }
  }
  return q;
}

PoseSearch::Found PoseSearch::climb(Share share, Found found, const Score& score,
                                    std::uint64_t seed) const {
  SplitMix64 random(seed);
  double step = kFirstStep;
  const auto accept = [&](const Share& to, double least) {
    const auto q = configuration(to);
    if (!q) return false;
    const double value = score(*q, kClimbing);
    if (!(value >= least)) return false;
    share = to;
    found = {*q, value};
    return true;
  };
  found.score = score(found.q, kClimbing);
  for (int i = 0; i < kClimbSteps && step > kLastStep; ++i) {
    Share to = share;
    // Some of the joints at a time, so that one at its limit does not hold up the others.
    const std::uint64_t chosen = random.bits();
    for (std::size_t k = 0; k < size_; ++k) {
      if ((chosen >> k & 1) == 0) continue;
      to[k] = std::clamp(to[k] + random.uniform(-step, step), 0.0, 1.0);
    }
    step *= accept(to, std::nextafter(found.score, HUGE_VAL)) ? kGrow : kShrink;
    step = std::min(step, 0.5);
  }
  const Share home = share_of_home();
  for (std::size_t k = 0; k < size_; ++k) {
    Share to = share;
    to[k] = home[k];
    accept(to, found.score - kSame * std::abs(found.score) - kNothing);
  }
  return found;
}

PoseSearch::Found PoseSearch::best(const Score& score) const {
  std::vector<double> scores;
  for (std::size_t k = 0; k < poses_.size(); ++k) scores.push_back(score(poses_[k], k));
  std::vector<std::size_t> order(poses_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto climbs = static_cast<std::ptrdiff_t>(std::min(kClimbs, order.size()));
  std::partial_sort(order.begin(), order.begin() + climbs, order.end(),
                    [&](std::size_t a, std::size_t b) {
                      return scores[a] != scores[b] ? scores[a] > scores[b] : a < b;
                    });
  Found best{poses_[0], kNever};
  for (std::ptrdiff_t k = 0; k < climbs; ++k) {
    const std::size_t from = order[static_cast<std::size_t>(k)];
    if (scores[from] == kNever) break;
    const Found found = climb(shares_[from], {poses_[from], scores[from]}, score,
                              static_cast<std::uint64_t>(k) + 1);
    if (found.score > best.score) best = found;
  }
  return best;
}

}  // namespace sinew::planning
