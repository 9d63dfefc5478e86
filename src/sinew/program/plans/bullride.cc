#include "sinew/program/plans/bullride.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/error_code.h"
#include "sinew/core/number_text.h"
#include "sinew/core/split_mix.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_value.h"

namespace sinew::program {
namespace {

/// A move takes about this long, s: one looks lively, and a device that answers slowly keeps up.
constexpr double kMoveTime = 1.5;
/// Of a ride there are so many moves at least.
constexpr double kMovesMin = 6;
constexpr double kAmplitudeMin = 1e-6;
/// Tries until a random pose can be reached.
constexpr int kTriesMax = 40;
/// Throws in a row that may take longer than what is left of the ride.
constexpr int kMisfitsMax = 20;
/// Moves from which the time of one is judged.
constexpr int kJudged = 6;

/// Digits behind the point, of degrees or mm: finer than any of the devices.
constexpr int kDigits = 5;

/// As the row's text says it, so that what is planned is what will be read.
double rounded(double value, const Joint& joint) {
  const double unit = joint.slides() ? from_mm(1) : from_deg(1);
  const double scale = std::pow(10, kDigits);
  return std::round(value / unit * scale) / scale * unit;
}

class Rider {
 public:
  Rider(const RobotModel& robot, const JointVector& q_start, std::uint64_t seed)
      : robot_(robot), planner_(robot), q_start_(q_start), random_(seed) {}

  /// s for a move to `q`, or why there is none.
  std::expected<double, Refusal> time_to(const JointVector& from, const JointVector& q) {
    const Step row = row_to(q);
    const auto motion = planner_.plan(from, {}, std::span(&row, 1));
    if (!motion) {
      last_refusal_ = motion.error();
      return std::unexpected(motion.error());
    }
    return motion->duration;
  }
  /// Why there is no ride: no pose is free, or the shortest way there and back takes too long.
  Refusal why_none(double duration) const {
    if (!std::isfinite(shortest_) && last_refusal_) return *last_refusal_;
    return {0, {ErrorCode::kRideTime, -1, shortest_, duration}, std::nullopt};
  }

  /// A pose so far around the start as `amplitude` says that can be reached from `from`, and from
  /// which the start can be; nothing after too many tries.
  struct Move {
    JointVector q;
    double there = 0;
    double back = 0;
  };
  std::optional<Move> throw_from(const JointVector& from, double amplitude) {
    for (int k = 0; k < kTriesMax; ++k) {
      Move move{.q = pose(amplitude)};
      const auto there = time_to(from, move.q);
      if (!there || *there <= 0) continue;
      const auto back = time_to(move.q, q_start_);
      if (!back) continue;
      move.there = *there;
      move.back = *back;
      shortest_ = std::min(shortest_, *there + *back);
      return move;
    }
    return std::nullopt;
  }

  /// s, of a move with this amplitude; infinite where none is found.
  double typical_time(double amplitude) {
    double sum = 0;
    JointVector q = q_start_;
    for (int k = 0; k < kJudged; ++k) {
      const auto move = throw_from(q, amplitude);
      if (!move) return std::numeric_limits<double>::infinity();
      sum += move->there;
      q = move->q;
    }
    return sum / kJudged;
  }

  std::string text_of(const JointVector& q) const {
    std::string text = "joint";
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const Joint& joint = robot_.joints[j];
      text += " " + joint.name + "=" + number_text(shown_value(q[j], joint), kDigits) +
              shown_unit(joint);
    }
    return text + "\n";
  }

 private:
  JointVector pose(double amplitude) {
    JointVector q = q_start_;
    for (std::size_t j = 0; j < q.size(); ++j) {
      const Joint& joint = robot_.joints[j];
      const double far = amplitude * (joint.upper - joint.lower) / 2;
      const double lower = std::max(joint.lower, q_start_[j] - far);
      const double upper = std::min(joint.upper, q_start_[j] + far);
      q[j] = std::clamp(rounded(random_.uniform(lower, upper), joint), joint.lower, joint.upper);
    }
    return q;
  }

  static Step row_to(const JointVector& q) {
    JointStep joint;
    joint.q = q;
    joint.given = static_cast<std::uint8_t>((1U << q.size()) - 1);
    Step step;
    step.what = joint;
    return step;
  }

  const RobotModel& robot_;
  RowPlanner planner_;
  JointVector q_start_;
  SplitMix64 random_;
  std::optional<Refusal> last_refusal_;
  double shortest_ = std::numeric_limits<double>::infinity();  ///< s, of a move and back
};

/// The largest amplitude at which moves take as long as they should; times grow with it.
double fitting_amplitude(Rider& rider, double move_time) {
  double low = kAmplitudeMin;
  double high = 1;
  if (rider.typical_time(high) <= move_time) return high;
  for (int k = 0; k < 12; ++k) {
    const double middle = std::sqrt(low * high);
    (rider.typical_time(middle) <= move_time ? low : high) = middle;
  }
  return low;
}

}  // namespace

double fitting_ride(const RobotModel& robot, const JointVector& q_start, const RideOrder& order) {
  Rider rider(robot, q_start, order.seed);
  // A move, and the way back.
  return fitting_amplitude(rider, order.duration / 2);
}

std::expected<Ride, Refusal> make_ride(const RobotModel& robot, const JointVector& q_start,
                                       const RideOrder& order) {
  const auto refused = [](double measured, double limit) {
    return std::unexpected(Refusal{0, {ErrorCode::kMoveInput, -1, measured, limit}, std::nullopt});
  };
  if (!(order.duration >= kRideMin && order.duration <= kRideMax)) {
    return refused(order.duration, kRideMax);
  }
  if (!(order.amplitude >= 0 && order.amplitude <= 1)) return refused(order.amplitude, 1);
  JointVector start = q_start;
  for (std::size_t j = 0; j < start.size(); ++j) {
    start[j] = std::clamp(rounded(start[j], robot.joints[j]), robot.joints[j].lower,
                          robot.joints[j].upper);
  }
  Rider rider(robot, start, order.seed);
  if (const auto stays = rider.time_to(q_start, start); !stays) {
    return std::unexpected(stays.error());
  }
  Ride ride;
  ride.amplitude = order.amplitude > 0
                       ? order.amplitude
                       : fitting_amplitude(rider, std::min(kMoveTime, order.duration / kMovesMin));
  JointVector q = start;
  double back = 0;
  int misfits = 0;
  while (const auto move = rider.throw_from(q, ride.amplitude)) {
    if (ride.duration + move->there + move->back > order.duration) {
      if (++misfits > kMisfitsMax) break;
      continue;
    }
    misfits = 0;
    ride.text += rider.text_of(move->q);
    ride.duration += move->there;
    ++ride.moves;
    q = move->q;
    back = move->back;
  }
  if (ride.moves == 0) return std::unexpected(rider.why_none(order.duration));
  ride.text += rider.text_of(start);
  ride.duration += back;
  return ride;
}

}  // namespace sinew::program
