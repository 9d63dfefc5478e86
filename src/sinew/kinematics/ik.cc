#include "sinew/kinematics/ik.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/core/trig.h"
#include "sinew/model/joint_value.h"

namespace sinew::kinematics {

void sort_by_distance(IkBranches& branches, std::span<const double> near) {
  const auto key = [&](const IkBranch& branch) {
    double largest = 0;
    for (std::size_t i = 0; i < branch.q.size(); ++i) {
      const double from = i < near.size() ? near[i] : 0;
      largest = std::max(largest, std::abs(branch.q[i] - from));
    }
    return std::pair(!branch.within_limits, largest);
  };
  std::sort(branches.begin(), branches.end(),
            [&](const IkBranch& a, const IkBranch& b) { return key(a) < key(b); });
}

LimitViolations limit_violations(std::span<const Joint> joints, std::span<const double> q) {
  SINEW_ASSERT(joints.size() == q.size());
  LimitViolations violations;
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (within_limits(joints[i], q[i])) continue;
    violations.push_back(beyond_limit(joints[i], i, q[i]));
  }
  return violations;
}

Error nearest_violation(std::span<const Joint> joints, const IkBranches& branches) {
  Error nearest{ErrorCode::kJointLimit, 0, std::numeric_limits<double>::infinity(), 0};
  for (const IkBranch& branch : branches) {
    const LimitViolations violations = limit_violations(joints, branch.q);
    const auto worst =
        std::max_element(violations.begin(), violations.end(),
                         [&](const Error& a, const Error& b) { return excess(a) < excess(b); });
    if (worst != violations.end() && excess(*worst) < excess(nearest)) nearest = *worst;
  }
  return nearest;
}

JointRanges::JointRanges(std::span<const Joint> joints) : size_(joints.size()) {
  SINEW_ASSERT(size_ <= kMaxJoints);
  for (std::size_t i = 0; i < size_; ++i) {
    slides_[i] = joints[i].slides();
    lower_[i] = joints[i].lower - kJointLimitTolerance;
    upper_[i] = joints[i].upper + kJointLimitTolerance;
    turn_up_below_[i] = std::min(lower_[i], upper_[i] - 2 * kPi);
    turn_down_above_[i] = std::max(upper_[i], lower_[i] + 2 * kPi);
  }
}

void JointRanges::settle(IkBranch& branch, std::span<const double> near) const {
  bool inside = true;
  for (std::size_t i = 0; i < size_; ++i) {
    double q = branch.q[i];
    if (!slides_[i]) q = turned(q, i < near.size() ? near[i] : 0, i);
    inside &= q >= lower_[i] && q <= upper_[i];
    branch.q[i] = q;
  }
  branch.within_limits = inside;
}

bool JointRanges::contains(std::span<const double> q) const {
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (!(q[i] >= lower_[i] && q[i] <= upper_[i])) return false;
  }
  return true;
}

}  // namespace sinew::kinematics
