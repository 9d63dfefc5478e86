#include "sinew/mcu/arm_motion.h"

#include "sinew/mcu/interrupts.h"

namespace sinew {
namespace mcu {
namespace {

constexpr uint8_t kBeginMs = 30;  ///< in the queue, before a stream's motion begins

uint32_t magnitude(int32_t number) {
  return number < 0 ? 0 - static_cast<uint32_t>(number) : static_cast<uint32_t>(number);
}

/// `number` times a share of 65536ths below 1; the chip multiplies numbers of 16 bits.
int32_t share_of(int32_t number, uint16_t share) {
  const int16_t high = static_cast<int16_t>(number >> 16);
  const uint16_t low = static_cast<uint16_t>(number);
  return static_cast<int32_t>(high) * static_cast<int32_t>(share) +
         static_cast<int32_t>((static_cast<uint32_t>(low) * share) >> 16);
}

uint64_t rounded_up(uint64_t number, uint64_t divisor) {
  return (number + divisor - 1) / divisor;
}

/// The smallest number whose square is `number` or more.
uint32_t root_above(uint64_t number) {
  uint64_t root = 0;
  for (uint64_t bit = static_cast<uint64_t>(1) << 31; bit != 0; bit >>= 1) {
    const uint64_t more = root | bit;
    if (more * more <= number) root = more;
  }
  return static_cast<uint32_t>(root * root < number ? root + 1 : root);
}

}  // namespace

void ServoRamp::go_to(uint16_t angle, uint16_t ms) {
  const InterruptsOff off;
  start_ = angle_;
  target_ = angle < kGripperMax ? angle : kGripperMax;
  left_ = all_ = ms;
  if (ms == 0) angle_ = target_;
}

uint16_t ServoRamp::angle() const {
  const InterruptsOff off;
  return angle_;
}

bool ServoRamp::moving() const {
  const InterruptsOff off;
  return left_ > 0;
}

void ServoRamp::slice() {
  if (left_ == 0) return;
  --left_;
  const int32_t way = static_cast<int32_t>(target_) - start_;
  const int32_t done = static_cast<int32_t>(all_ - left_);
  angle_ = static_cast<uint16_t>(start_ + way * done / all_);
}

void ArmMotion::slice() {
  gripper_.slice();
  int32_t grains[kArmAxes] = {};
  switch (mode_) {
    case Mode::kRest:
      if (size_ > 0 && may_begin()) {
        mode_ = Mode::kStream;
        slice_stream(grains);
        break;
      }
      if (quiet_) return;
      break;
    case Mode::kStream:
      slice_stream(grains);
      break;
    case Mode::kCoasting:
      for (uint8_t i = 0; i < kArmAxes; ++i) grains[i] = speeds_[i];
      break;
    case Mode::kRamp:
      slice_ramp(grains);
      break;
    case Mode::kStopping:
      slice_stop(grains);
      break;
  }
  int32_t ways[kArmAxes];
  quiet_ = true;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    if (grains[i] != 0) quiet_ = false;
    speeds_[i] = grains[i];
    // Pulses count 16 grains; what is below stays for the next slice.
    ways[i] = (grains[i] + (grains_[i] & 15)) >> 4;
    const int32_t sum = grains[i] + grains_[i];
    positions_[i] += sum >> 12;
    grains_[i] = static_cast<uint16_t>(sum & (kGrainsPerUnit - 1));
  }
  pulses_.put(ways);
}

/// How far it is to a position (2^-8 step); so near that it fits.
int32_t ArmMotion::grains_to(int32_t target, uint8_t axis) const {
  return (target - positions_[axis]) * kGrainsPerUnit - grains_[axis];
}

/// A stream begins with some of it in the queue, or where its first segment says so, or has waited.
bool ArmMotion::may_begin() {
  if (queue_[first_].begin || queued_ms_ >= kBeginMs || waited_ >= kBeginMs) {
    waited_ = 0;
    return true;
  }
  ++waited_;
  return false;
}

void ArmMotion::slice_stream(int32_t* grains) {
  if (size_ == 0) {
    // To plan how they brake takes longer than an interrupt may.
    mode_ = Mode::kCoasting;
    for (uint8_t i = 0; i < kArmAxes; ++i) grains[i] = speeds_[i];
    return;
  }
  Queued& now = queue_[first_];
  if (segment_left_ == 0) {
    segment_left_ = now.ms;
    if (now.gripper != kGripperStays) gripper_.go_to(now.gripper, now.ms);
  }
  --segment_left_;
  queued_ms_ = static_cast<uint16_t>(queued_ms_ - 1);
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    Differences& axis = now.axes[i];
    if (segment_left_ == 0) {
      grains[i] = grains_to(now.targets[i], i);
      continue;
    }
    grains[i] = axis.first;
    axis.first += axis.second;
    axis.second += axis.third;
  }
  if (segment_left_ == 0) end_segment();
}

void ArmMotion::end_segment() {
  const bool rests = queue_[first_].rests;
  first_ = static_cast<uint8_t>((first_ + 1) % kQueue);
  size_ = static_cast<uint8_t>(size_ - 1);
  if (rests && size_ == 0) mode_ = Mode::kRest;
}

SegmentRefusal ArmMotion::push(const ArmSegment& segment) {
  Mode mode = Mode::kRest;
  uint8_t size = 0;
  uint8_t place = 0;
  {
    // A slice that ends a segment changes all of them; where the queue ends it leaves.
    const InterruptsOff off;
    mode = mode_;
    size = size_;
    place = static_cast<uint8_t>((first_ + size) % kQueue);
  }
  if (mode != Mode::kRest && mode != Mode::kStream) return SegmentRefusal::kStopping;
  if (size == kQueue) return SegmentRefusal::kFull;
  if (segment.ms < 1 || segment.ms > kSegmentMsMax) return SegmentRefusal::kRange;
  const bool follows = mode == Mode::kStream || size > 0;
  Queued& next = queue_[place];
  next.ms = segment.ms;
  next.begin = segment.begin;
  next.gripper = segment.gripper;
  next.rests = true;
  next.rests = true;
  int32_t speeds[kArmAxes];
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    const int32_t start = follows ? end_targets_[i] : position(i);
    speeds[i] = static_cast<int32_t>(segment.velocities[i]) * 1024;
    const int32_t from = follows ? end_speeds_[i] : 0;
    if (!plan(segment.ms, {start, segment.targets[i], from, speeds[i]}, next.axes[i])) {
      return SegmentRefusal::kRange;
    }
    next.targets[i] = segment.targets[i];
    next.rests = next.rests && speeds[i] == 0;
  }
  {
    const InterruptsOff off;
    // The stop line may have emptied the queue meanwhile.
    if (static_cast<uint8_t>((first_ + size_) % kQueue) != place) return SegmentRefusal::kStopping;
    size_ = static_cast<uint8_t>(size_ + 1);
    queued_ms_ = static_cast<uint16_t>(queued_ms_ + segment.ms);
  }
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    end_targets_[i] = segment.targets[i];
    end_speeds_[i] = speeds[i];
  }
  return SegmentRefusal::kNone;
}

/// The forward differences of an axis' cubic. False: farther or faster than a motor goes.
bool ArmMotion::plan(uint8_t ms, const Ends& ends, Differences& out) {
  const uint32_t way_most = static_cast<uint32_t>(kStepsPerMsMax) * kUnitsPerStep * ms;
  const uint32_t speed_most = static_cast<uint32_t>(kStepsPerMsMax) * kGrain;
  if (magnitude(ends.target) > static_cast<uint32_t>(kSteps) * kUnitsPerStep) return false;
  const int32_t way = ends.target - ends.start;
  if (magnitude(way) > way_most || magnitude(ends.to) > speed_most) return false;
  const uint16_t share = static_cast<uint16_t>(65535 / ms);  // of one ms
  const int32_t all = way * kGrainsPerUnit;
  int32_t mean = share_of(all, share);
  // What the share's 16 bits have missed would be a jump at the segment's end.
  mean += share_of(all - mean * ms, share);
  const int32_t both = ends.from + ends.to;
  if (magnitude(mean + mean / 2 - both / 4) > speed_most) return false;  // in its middle
  const int32_t square = share_of(3 * mean - ends.from - both, share);
  const int32_t cube = share_of(share_of(6 * (both - 2 * mean), share), share);
  const int32_t sixth = share_of(share_of(both - 2 * mean, share), share);
  out = {ends.from + square + sixth, 2 * square + cube, cube};
  return true;
}

uint16_t ArmMotion::queued_ms() const {
  const InterruptsOff off;
  return queued_ms_;
}

/// Grains; positions at rest are whole units.
uint64_t ArmMotion::way_to(int32_t target, uint8_t axis) const {
  return static_cast<uint64_t>(magnitude(target - positions_[axis])) * kGrainsPerUnit;
}

void ArmMotion::go_to(const int32_t* targets, const ArmRamp* ramps, bool together) {
  uint32_t rise[kArmAxes];
  uint32_t all[kArmAxes];
  uint32_t longest_rise = 1;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    const ArmRamp& ramp = ramps[i];
    Trapezoid& axis = ramps_[i];
    axis = {};
    axis.target = targets[i] * kUnitsPerStep;
    axis.back = axis.target < positions_[i];
    const uint64_t way = way_to(axis.target, i);
    // Hundredths of a revolution per s, in grains per ms; never more than the pulses carry.
    const uint64_t nominal = static_cast<uint64_t>(ramp.speed) * ramp.steps_per_rev * kGrain;
    uint64_t speed = nominal / 100000;
    const uint64_t most = static_cast<uint64_t>(kStepsPerMsMax) * kGrain;
    if (speed > most) speed = most;
    // v / a: a is hundredths of a revolution per s^2.
    const uint64_t gain = static_cast<uint64_t>(ramp.acceleration) * ramp.steps_per_rev;
    rise[i] = static_cast<uint32_t>(rounded_up(speed * 100000000 / kGrain, gain));
    if (rise[i] == 0) rise[i] = 1;
    const uint64_t whole = rounded_up(way, speed);
    all[i] = whole > 0xFFFFFFFF ? 0xFFFFFFFF : static_cast<uint32_t>(whole);
    if (all[i] < rise[i]) {
      rise[i] = root_above(rounded_up(rounded_up(way, kGrain) * 100000000, gain));
      all[i] = rise[i];
    }
    if (way == 0) rise[i] = all[i] = 0;
    if (rise[i] > longest_rise) longest_rise = rise[i];
  }
  uint32_t longest = longest_rise;
  for (uint8_t i = 0; together && i < kArmAxes; ++i) {
    if (all[i] > longest) longest = all[i];
    // No axis gains speed more quickly than its own ramp does.
    const uint64_t gain = static_cast<uint64_t>(ramps[i].acceleration) * ramps[i].steps_per_rev;
    const uint64_t way = way_to(ramps_[i].target, i);
    const uint64_t slow = rounded_up(rounded_up(way, kGrain) * 100000000, gain * longest_rise);
    if (slow > longest) longest = slow > 0xFFFFFFFF ? 0xFFFFFFFF : static_cast<uint32_t>(slow);
  }
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    Trapezoid& axis = ramps_[i];
    const uint64_t way = way_to(axis.target, i);
    if (way == 0) continue;
    axis.ramp = together ? longest_rise : rise[i];
    axis.all = together ? longest : all[i];
    axis.rise = axis.fall = axis.ramp;
    axis.flat = axis.all - axis.ramp;
    axis.peak = static_cast<uint32_t>(way / axis.all);
    axis.peak_rest = static_cast<uint32_t>(way % axis.all);
    axis.gain = axis.peak / axis.ramp;
    axis.gain_rest = axis.peak % axis.ramp;
  }
  const InterruptsOff off;
  mode_ = Mode::kRamp;
}

/// How far an axis goes in its next ms, grains; no sign yet.
int32_t ArmMotion::next_of(Trapezoid& axis) {
  const auto step = [&axis] {
    axis.gain_sum += axis.gain_rest;
    const bool more = axis.gain_sum >= axis.ramp;
    if (more) axis.gain_sum -= axis.ramp;
    return axis.gain + (more ? 1 : 0);
  };
  const uint32_t before = axis.speed;
  if (axis.rise > 0) {
    --axis.rise;
    axis.speed += step();
  } else if (axis.flat > 0) {
    --axis.flat;
    axis.peak_sum += axis.peak_rest;
    const bool more = axis.peak_sum >= axis.all;
    if (more) axis.peak_sum -= axis.all;
    return static_cast<int32_t>(axis.peak + (more ? 1 : 0));
  } else {
    --axis.fall;
    const uint32_t less = step();
    axis.speed = axis.speed > less ? axis.speed - less : 0;
  }
  return static_cast<int32_t>((before + axis.speed) / 2);
}

void ArmMotion::slice_ramp(int32_t* grains) {
  bool over = true;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    Trapezoid& axis = ramps_[i];
    if (axis.fall == 0) continue;
    const int32_t way = next_of(axis);
    grains[i] = axis.back ? -way : way;
    // The last slices take what divisions have left.
    const uint32_t near = 65536;  // units; more does not fit
    if (magnitude(axis.target - positions_[i]) < near) {
      const int32_t left = grains_to(axis.target, i);
      if (axis.fall == 0 || magnitude(left) < static_cast<uint32_t>(way)) grains[i] = left;
    }
    over = over && axis.fall == 0;
  }
  if (over) mode_ = Mode::kRest;
}

void ArmMotion::clear_queue() {
  size_ = 0;
  queued_ms_ = 0;
  segment_left_ = waited_ = 0;
  gripper_.stop();
}

void ArmMotion::stop(const uint32_t* brakings) {
  if (mode_ == Mode::kStopping) return;
  int32_t speeds[kArmAxes];
  {
    const InterruptsOff off;
    clear_queue();
    if (mode_ == Mode::kRest) return;
    if (mode_ == Mode::kStream) mode_ = Mode::kCoasting;
    for (uint8_t i = 0; i < kArmAxes; ++i) speeds[i] = speeds_[i];
  }
  stop_all_ = 1;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    const uint32_t speed = static_cast<uint32_t>(speeds[i] < 0 ? -speeds[i] : speeds[i]);
    const uint32_t needed = (speed + brakings[i] - 1) / brakings[i];
    if (needed > stop_all_) stop_all_ = needed;
  }
  if (stop_all_ > kStopMsMax) stop_all_ = kStopMsMax;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    const uint32_t speed = static_cast<uint32_t>(speeds[i] < 0 ? -speeds[i] : speeds[i]);
    stop_[i] = {speeds[i], speed / stop_all_, speed % stop_all_, 0};
  }
  stop_left_ = stop_all_;
  const InterruptsOff off;
  if (mode_ != Mode::kRest) mode_ = Mode::kStopping;
}

void ArmMotion::slice_stop(int32_t* grains) {
  if (stop_left_ == 0) {
    mode_ = Mode::kRest;
    return;
  }
  --stop_left_;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    Braking& axis = stop_[i];
    axis.loss_sum += axis.loss_rest;
    const bool more = axis.loss_sum >= stop_all_;
    if (more) axis.loss_sum -= stop_all_;
    const int32_t loss = static_cast<int32_t>(axis.loss + (more ? 1 : 0));
    axis.speed += axis.speed < 0 ? loss : -loss;
    grains[i] = axis.speed;
  }
  if (stop_left_ > 0) return;
  // On a position that the wire can name.
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    grains[i] -= (grains[i] + grains_[i]) & (kGrainsPerUnit - 1);
  }
}

void ArmMotion::freeze() {
  pulses_.freeze();
  clear_queue();
  mode_ = Mode::kRest;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    positions_[i] = pulses_.steps(i) * kUnitsPerStep;
    grains_[i] = 0;
    speeds_[i] = 0;
  }
}

int32_t ArmMotion::position(uint8_t axis) const {
  const InterruptsOff off;
  return positions_[axis];
}

void ArmMotion::set_positions(const int32_t* positions) {
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    const InterruptsOff off;
    // The motor stays where it is, also within a step: counts change by whole steps.
    const int32_t steps = (positions[i] - positions_[i] + 128) >> 8;
    positions_[i] += steps * kUnitsPerStep;
    pulses_.set_steps(i, pulses_.steps(i) + steps);
  }
}

}  // namespace mcu
}  // namespace sinew
