#include "sinew/devices/axis/axis_device_encoders.h"

#include <cmath>
#include <limits>
#include <utility>

#include "sinew/core/units.h"

namespace sinew {
namespace {

constexpr std::int32_t kAs5600Positions = 4096;
/// Noise of an AS5600 and the edge of a quadrature count, beyond what the speed explains.
constexpr double kCountSlack = 8;
/// Of the velocity filter, 1/s: a step of the velocity is followed in some 20 ms, and the
/// counts of the motor's encoder show as 0.3 deg/s of the joint at most.
constexpr double kVelocityPole = 100;
constexpr double kDisagreementTime = 0.05;  // s
/// A node's reply that is lost costs three control cycles, and a joint turns slowly.
constexpr double kNodeGaps = 3;
constexpr double kNodeStart = 0.5;  // s: a node may have its power later than the board

std::int32_t wrapped_difference(std::int32_t now, std::int32_t before, std::int32_t modulus) {
  const auto difference = static_cast<std::int32_t>(static_cast<std::uint32_t>(now) -
                                                    static_cast<std::uint32_t>(before));
  if (modulus == 0) return difference;
  const std::int32_t half = modulus / 2;
  return ((difference + half) % modulus + modulus) % modulus - half;
}

}  // namespace

void EncoderChannel::wait(double dt) {
  waited_ += dt;
  gap_ += dt;
  if (gap_ > (started_ ? gap_max_ : start_max_)) lost_ = true;
}

void EncoderChannel::read(std::int32_t counts, bool ok, double dt) {
  if (modulus_ > 0 && (counts < 0 || counts >= modulus_)) ok = false;
  if (ok && !started_) {
    started_ = good_ = true;
    last_ = counts;
  }
  wait(dt);
  const double since_last = std::exchange(waited_, 0);
  const auto plausible = [&](std::int32_t from, double time) {
    const double step = wrapped_difference(counts, from, modulus_);
    return std::abs(step) <= speed_max_ * time + kCountSlack;
  };
  // The longer the gap, the more a shaft may have turned, and a glitch with it: the first reading
  // after one counts only when a second one bears it out.
  const bool borne_out = good_ || (has_candidate_ && plausible(candidate_, since_last));
  const bool possible = ok && plausible(last_, gap_);
  good_ = possible && borne_out;
  has_candidate_ = possible;
  candidate_ = counts;
  if (!good_) return;
  counts_ += wrapped_difference(counts, last_, modulus_);
  gap_ = 0;
  last_ = counts;
}

void EncoderChannel::restart() {
  lost_ = false;
  started_ = false;
  gap_ = 0;
}

AxisEncoders::AxisEncoders(const AxisEncoderSettings& settings)
    : settings_(settings), fitted_(settings.joint != JointEncoder::kNone) {
  const double turns = settings.speed_max / (2 * kPi);
  const double gap = to_seconds(settings.gap_max);
  motor_ =
      EncoderChannel(kAs5600Positions,
                     turns * settings.gear_ratio * std::abs(settings.motor_counts_per_turn), gap);
  joint_ = EncoderChannel(settings.joint == JointEncoder::kAs5600 ? kAs5600Positions : 0,
                          turns * std::abs(settings.joint_counts_per_turn),
                          settings.joint_node ? kNodeGaps * gap : gap,
                          settings.joint_node ? kNodeStart : gap);
}

double AxisEncoders::motor_angle() const {
  return static_cast<double>(motor_.counts()) * 2 * kPi / settings_.motor_counts_per_turn;
}

double AxisEncoders::raw_joint() const {
  return static_cast<double>(joint_.counts()) * 2 * kPi / settings_.joint_counts_per_turn;
}

double AxisEncoders::joint_q() const {
  return fitted_ ? raw_joint() + joint_offset_ : q_;
}

void AxisEncoders::read(const AxisInputs& inputs, double dt) {
  motor_.read(inputs.motor_counts, inputs.motor_encoder_ok, dt);
  joint_waited_ += dt;
  if (fitted_ && inputs.joint_fresh) joint_.read(inputs.joint_counts, inputs.joint_encoder_ok, dt);
  if (fitted_ && !inputs.joint_fresh) joint_.wait(dt);
  if (motor_.lost()) {
    qd_ = 0;
    return;
  }
  // A reading or two may be missing: until the next one it goes on as it did.
  q_ = motor_.good() ? motor_angle() / settings_.gear_ratio + motor_offset_ : q_ + qd_ * dt;
  if (!started_) filtered_q_ = q_;
  started_ = true;

  // Fading-memory filter with both poles at kVelocityPole: steady for any dt (N. Morrison,
  // Introduction to Sequential Smoothing and Prediction, 1969, ch. 13).
  const double memory = std::exp(-kVelocityPole * dt);
  const double predicted = filtered_q_ + qd_ * dt;
  const double residual = q_ - predicted;
  filtered_q_ = predicted + (1 - memory * memory) * residual;
  if (dt > 0) qd_ += (1 - memory) * (1 - memory) * residual / dt;

  if (!fitted_ || !inputs.joint_fresh) return;
  const double since_last = std::exchange(joint_waited_, 0);
  if (!joint_.good() || !motor_.good()) return;
  const double now = joint_q() + qd_ * inputs.joint_age - q_;
  disagreement_ += (now - disagreement_) * (1 - std::exp(-since_last / kDisagreementTime));
}

void AxisEncoders::mark() {
  motor_mark_ = motor_angle() / settings_.gear_ratio;
  joint_mark_ = raw_joint();
}

double AxisEncoders::name_mark(double joint_q, double motor_q) {
  const double jump = motor_q - motor_mark_ - motor_offset_;
  motor_offset_ = motor_q - motor_mark_;
  joint_offset_ = joint_q - joint_mark_;
  q_ += jump;
  filtered_q_ += jump;
  disagreement_ = 0;
  return jump;
}

void AxisEncoders::restart() {
  motor_.restart();
  joint_.restart();
  motor_offset_ = q_ - motor_angle() / settings_.gear_ratio;
  joint_offset_ = q_ - raw_joint();
  qd_ = 0;
  filtered_q_ = q_;
  disagreement_ = 0;
}

}  // namespace sinew
