#pragma once

#include <stdint.h>

#include "sinew/mcu/step_pulses.h"

/// Motion of five stepper axes, a millisecond at a time, in whole numbers: the same on a chip
/// without a floating point unit and on a host, to the last bit.
namespace sinew {
namespace mcu {

/// Units of position inside: 2^-20 step. Speeds are such units per ms.
constexpr int32_t kGrain = 1048576;     ///< one step
constexpr int32_t kUnitsPerStep = 256;  ///< of the arm link
constexpr int32_t kGrainsPerUnit = kGrain / kUnitsPerStep;
constexpr int32_t kStepsPerMsMax = 12;  ///< of one axis
constexpr int32_t kSteps = 4000000;     ///< positions are within +-this
constexpr uint8_t kSegmentMsMax = 50;
constexpr uint32_t kStopMsMax = 5000;  ///< no stop takes longer, whatever it may brake with

/// One segment of a streamed motion: where the axes are at its end, and how fast. Between is the
/// cubic from where the last one ended.
struct ArmSegment {
  uint8_t ms;                    ///< 1..kSegmentMsMax
  bool begin;                    ///< begins at once; else motion begins with 30 ms in the queue
  uint16_t gripper;              ///< 1/128 deg at its end; kGripperStays: as it is
  int32_t targets[kArmAxes];     ///< 2^-8 step
  int16_t velocities[kArmAxes];  ///< 2^-10 step per ms
};
constexpr int16_t kSpeedsPerStepPerMs = 1024;
constexpr uint16_t kGripperStays = 0xFFFF;
constexpr uint16_t kServoUnitsPerDegree = 128;
constexpr uint16_t kGripperMax = 180 * kServoUnitsPerDegree;

/// A servo that goes from angle to angle at constant speed.
class ServoRamp {
 public:
  /// @param angle  1/128 deg, at most kGripperMax  @param ms  0: at once
  void go_to(uint16_t angle, uint16_t ms);
  /// One ms.
  void slice();
  /// It stays where it is.
  void stop() { left_ = 0; }
  uint16_t angle() const;
  bool moving() const;

 private:
  uint16_t angle_ = 90 * kServoUnitsPerDegree;
  uint16_t start_ = 0;
  uint16_t target_ = 0;
  uint16_t left_ = 0;  ///< ms
  uint16_t all_ = 1;
};

/// Speed and acceleration of a motion that the board plans itself: each axis a trapezoid.
struct ArmRamp {
  uint32_t steps_per_rev;  ///< of the motor
  uint16_t speed;          ///< hundredths of a motor revolution per s, 1..
  uint16_t acceleration;   ///< hundredths of a motor revolution per s^2, 1..
};

/// Why a segment was not taken.
enum class SegmentRefusal : uint8_t {
  kNone,
  kFull,      ///< the queue is; send it again later
  kRange,     ///< too far, too fast, no duration
  kStopping,  ///< a motion of another kind is under way, or a stop
};

/// slice() and freeze() belong to the slice's interrupt, all else to the main loop. @rt
class ArmMotion {
 public:
  static constexpr uint8_t kQueue = 16;  ///< segments

  /// The next millisecond of all axes goes to pulses().
  void slice();

  SegmentRefusal push(const ArmSegment& segment);
  /// Of the stream; 0 where none is under way.
  uint16_t queued_ms() const;
  /// The stream's queue ran empty in motion; the axes go on as fast as they were until stop().
  bool coasting() const { return mode_ == Mode::kCoasting; }

  /// Plans and begins a motion to `targets` (steps). At rest only, targets within +-kSteps.
  /// Speeds above kStepsPerMsMax are lowered to that.
  /// @param together  all axes with one profile, so that they arrive at the same time
  void go_to(const int32_t* targets, const ArmRamp* ramps, bool together);

  /// Brakes all axes in one time, along their present direction. A stream's queue is forgotten.
  /// @param brakings  grains per ms^2 that an axis may slow down by, at least 1
  void stop(const uint32_t* brakings);
  /// No pulse from now on.
  void freeze();
  /// The stream's queue is forgotten; what is under way is not ended.
  void clear_queue();

  bool moving() const { return mode_ != Mode::kRest; }
  bool stopping() const { return mode_ == Mode::kStopping; }
  /// 2^-8 step: where the pulses that are planned end.
  int32_t position(uint8_t axis) const;
  /// Counts from other positions on, 2^-8 step, nearest whole step. At rest only.
  void set_positions(const int32_t* positions);
  /// Segments that push() would take now.
  uint8_t queue_room() const { return static_cast<uint8_t>(kQueue - size_); }
  /// The gripper alone. @param angle  1/128 deg
  void gripper_to(uint16_t angle, uint16_t ms) { gripper_.go_to(angle, ms); }
  const ServoRamp& gripper() const { return gripper_; }
  StepPulses& pulses() { return pulses_; }
  const StepPulses& pulses() const { return pulses_; }

 private:
  enum class Mode : uint8_t { kRest, kStream, kCoasting, kRamp, kStopping };

  /// A segment of one axis, as forward differences.
  struct Differences {
    int32_t first, second, third;  ///< grains
  };
  struct Queued {
    uint8_t ms;
    bool begin;
    uint16_t gripper;
    Differences axes[kArmAxes];
    int32_t targets[kArmAxes];  ///< 2^-8 step
    bool rests;                 ///< all end velocities are 0
  };
  /// Of a segment of one axis: 2^-8 step, and grains per ms.
  struct Ends {
    int32_t start, target, from, to;
  };
  /// A trapezoid of one axis: as many ms of rise as of fall, and `flat` between. What a division
  /// leaves is handed out ms by ms, so that nothing adds up.
  struct Trapezoid {
    uint32_t rise, flat, fall;  ///< ms that are left
    uint32_t ramp;              ///< ms of a rise
    uint32_t all;               ///< ms: rise and flat
    uint32_t peak;              ///< grains per ms
    uint32_t peak_rest, peak_sum;
    uint32_t gain;  ///< of a rise, per ms
    uint32_t gain_rest, gain_sum;
    uint32_t speed;
    bool back;
    int32_t target;  ///< 2^-8 step
  };
  struct Braking {
    int32_t speed;  ///< grains per ms
    uint32_t loss;  ///< per ms
    uint32_t loss_rest, loss_sum;
  };

  static bool plan(uint8_t ms, const Ends& ends, Differences& out);
  bool may_begin();
  void end_segment();
  void slice_stream(int32_t* grains);
  void slice_ramp(int32_t* grains);
  void slice_stop(int32_t* grains);
  int32_t grains_to(int32_t target, uint8_t axis) const;
  uint64_t way_to(int32_t target, uint8_t axis) const;
  static int32_t next_of(Trapezoid& axis);

  volatile Mode mode_ = Mode::kRest;
  bool quiet_ = true;  ///< the last slice had no way in it
  StepPulses pulses_;
  ServoRamp gripper_;
  int32_t positions_[kArmAxes] = {};  ///< 2^-8 step, and
  uint16_t grains_[kArmAxes] = {};    ///< what is beyond it, below kGrainsPerUnit
  int32_t speeds_[kArmAxes] = {};     ///< grains that the last slice went

  // Stream: the main loop fills the queue, the slice empties it.
  Queued queue_[kQueue] = {};
  volatile uint8_t first_ = 0;
  volatile uint8_t size_ = 0;
  uint8_t segment_left_ = 0;  ///< ms of the segment under way
  uint8_t waited_ = 0;        ///< ms of a first segment that waits for more
  volatile uint16_t queued_ms_ = 0;
  int32_t end_targets_[kArmAxes] = {};  ///< where the last one of the queue ends, 2^-8 step
  int32_t end_speeds_[kArmAxes] = {};   ///< grains per ms

  Trapezoid ramps_[kArmAxes] = {};
  Braking stop_[kArmAxes] = {};
  uint32_t stop_left_ = 0;  ///< ms
  uint32_t stop_all_ = 0;
};

}  // namespace mcu
}  // namespace sinew
