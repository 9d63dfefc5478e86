#include "sinew/program/formats/recorded_way.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sinew/core/number_text.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/joint_value.h"

namespace sinew::program {
namespace {

/// Of the tolerance a corner may be off, and its blend: together they make all of it.
constexpr double kCornerPart = 0.5;
constexpr double kShareMin = 0.01;
/// To where a way begins, from wherever the machine stands.
constexpr double kApproachShare = 0.25;

class RowMaker {
 public:
  RowMaker(std::span<const WaySample> way, const RobotModel& robot, const WayOptions& options)
      : way_(way), robot_(robot), options_(options), corner_(way.size(), 0) {}

  WayRows rows() {
    std::size_t from = stand_end(0);
    double stood = 0;
    while (from + 1 < way_.size()) {
      const std::size_t to = motion_end(from);
      if (text().empty()) {
        put(from, kApproachShare, false);
      } else {
        text() += "wait " + number_text(stood, 1) + "s\n";
      }
      put_motion(from, to);
      const std::size_t next = stand_end(to);
      stood = way_[next].t - way_[to].t;
      from = next;
    }
    return out_;
  }

 private:
  std::string& text() { return out_.text; }

  double tolerance(std::size_t joint) const {
    return robot_.joints[joint].slides() ? options_.leg_tolerance : options_.tolerance;
  }

  /// How far two places are apart, the worst joint counting, in shares of what is noise.
  bool still(const JointVector& a, const JointVector& b) const {
    for (std::size_t j = 0; j < a.size(); ++j) {
      const double noise = robot_.joints[j].slides() ? kWayStillLeg : kWayStill;
      if (std::abs(a[j] - b[j]) > noise) return false;
    }
    return true;
  }

  /// The last sample that is still where `i` is.
  std::size_t stand_end(std::size_t i) const {
    std::size_t end = i;
    while (end + 1 < way_.size() && still(way_[i].q, way_[end + 1].q)) ++end;
    return end;
  }

  /// Where a motion from `from` on comes to a stand that is long enough, or the way to its end.
  std::size_t motion_end(std::size_t from) const {
    for (std::size_t i = from + 1; i < way_.size(); ++i) {
      const std::size_t end = stand_end(i);
      const bool last = end + 1 == way_.size();
      if (last || way_[end].t - way_[i].t >= options_.rest_min) return i;
    }
    return way_.size() - 1;
  }

  /// How far sample `k` is from the straight way between a and b, in shares of the tolerance: at
  /// the place of that way where it comes nearest.
  double off(std::size_t a, std::size_t b, std::size_t k) const {
    double along = 0;
    double whole = 0;
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const double scale = 1 / (tolerance(j) * tolerance(j));
      const double chord = way_[b].q[j] - way_[a].q[j];
      along += scale * chord * (way_[k].q[j] - way_[a].q[j]);
      whole += scale * chord * chord;
    }
    const double u = whole > 0 ? std::clamp(along / whole, 0.0, 1.0) : 0;
    double worst = 0;
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const double there = way_[a].q[j] + u * (way_[b].q[j] - way_[a].q[j]);
      worst = std::max(worst, std::abs(way_[k].q[j] - there) / tolerance(j));
    }
    return worst;
  }

  /// Marks the corners between a and b: the sample that is farthest off splits, as long as it is
  /// too far (Douglas and Peucker).
  void mark_corners(std::size_t a, std::size_t b) {
    std::vector<std::pair<std::size_t, std::size_t>> left{{a, b}};
    while (!left.empty()) {
      const auto [from, to] = left.back();
      left.pop_back();
      double worst = kCornerPart;
      std::size_t where = from;
      for (std::size_t k = from + 1; k < to; ++k) {
        const double here = off(from, to, k);
        if (here <= worst) continue;
        worst = here;
        where = k;
      }
      if (where == from) continue;
      corner_[where] = 1;
      left.emplace_back(from, where);
      left.emplace_back(where, to);
    }
  }

  void put_motion(std::size_t from, std::size_t to) {
    mark_corners(from, to);
    std::size_t last = from;
    for (std::size_t k = from + 1; k <= to; ++k) {
      if (k < to && corner_[k] == 0) continue;
      put(k, share_of(last, k), k < to);
      last = k;
    }
  }

  /// As much of the joints' speed limits as the way between two samples took.
  double share_of(std::size_t a, std::size_t b) const {
    const double time = way_[b].t - way_[a].t;
    double share = kShareMin;
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const double speed = std::abs(way_[b].q[j] - way_[a].q[j]) / time;
      share = std::max(share, speed / robot_.joints[j].velocity_max);
    }
    return std::min(share, 1.0);
  }

  void put(std::size_t k, double share, bool blends) {
    text() += "joint";
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const Joint& joint = robot_.joints[j];
      const double q = std::clamp(way_[k].q[j], joint.lower, joint.upper);
      note_outside(way_[k].q[j], joint);
      text() += " " + joint.name + "=" +
                number_text(shown_value(q, joint), joint.slides() ? 4 : 3) + shown_unit(joint);
    }
    if (share < 1) text() += " speed=" + number_text(std::max(1.0, 100 * share), 0) + "%";
    if (blends) text() += " blend=" + blend();
    text() += "\n";
  }

  void note_outside(double q, const Joint& joint) {
    const double beyond = std::max(joint.lower - q, q - joint.upper);
    if (beyond <= 0) return;
    ++out_.outside;
    out_.outside_max = std::max(out_.outside_max, beyond);
  }

  std::string blend() const {
    const double part = 1 - kCornerPart;
    return prismatic_joints(robot_) != 0
               ? number_text(to_mm(part * options_.leg_tolerance), 3) + "mm"
               : number_text(to_deg(part * options_.tolerance), 3) + "deg";
  }

  std::span<const WaySample> way_;
  const RobotModel& robot_;
  const WayOptions& options_;
  std::vector<char> corner_;
  WayRows out_;
};

}  // namespace

WayRows rows_of_way(std::span<const WaySample> way, const RobotModel& robot,
                    const WayOptions& options) {
  return RowMaker(way, robot, options).rows();
}

}  // namespace sinew::program
