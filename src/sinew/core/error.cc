#include "sinew/core/error.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"

namespace sinew {
namespace {

using enum ErrorCode;
using enum Quantity;
constexpr StopCategory kNoStop = StopCategory::kNone;
constexpr StopCategory kHold = StopCategory::kStopAndHold;

// In the order of the enumerators; a test holds the two against each other.
constexpr std::array kTable = std::to_array<ErrorInfo>({
    {kOutOfReach, "out_of_reach", "out of reach by {excess}: needs {measured}, the arm has {limit}",
     kLength, true, kNoStop, 422},
    {kTooClose, "too_close", "too close by {excess}: at {measured}, the arm starts at {limit}",
     kLength, true, kNoStop, 422},
    {kJointLimit, "joint_limit", "{subject} would need {measured}, limit {limit}, {excess} too far",
     kAngle, true, kNoStop, 422},
    {kShoulderSingular, "shoulder_singular",
     "singular: the wrist is {measured} from the first axis, so that axis is free", kLength, true,
     kNoStop, 422},
    {kElbowSingular, "elbow_singular",
     "singular: the elbow is straight or folded, |sin| = {measured}", kRatio, true, kNoStop, 422},
    {kWristSingular, "wrist_singular",
     "singular: two wrist axes are in line, |sin of the bend| = {measured}", kRatio, true, kNoStop,
     422},
    {kSingular, "singular", "singular: smallest singular value {measured}, bound {limit}", kRatio,
     true, kNoStop, 422},
    {kApproachOutOfPlane, "approach_out_of_plane",
     "the tool would have to leave the arm's vertical plane by {measured}; five joints cannot",
     kAngle, true, kNoStop, 422},
    {kRollNotFree, "roll_not_free",
     "the roll about the tool axis is not free on this arm: the nearest it can have is {measured} "
     "away",
     kAngle, true, kNoStop, 422},
    {kOrientationNotReachable, "orientation_not_reachable",
     "this arm cannot turn its tool so: the nearest orientation is {measured} away", kAngle, true,
     kNoStop, 422},
    {kTaskNotSupported, "task_not_supported", "this arm cannot be asked for such a target", kNone,
     true, kNoStop, 422},
    {kLegLength, "leg_length", "{subject} would need {measured}, limit {limit}, {excess} too far",
     kLength, true, kNoStop, 422},
    {kCardanAngle, "cardan_angle",
     "the cardan of {subject} would bend {measured}, limit {limit}, {excess} too far", kAngle, true,
     kNoStop, 422},
    {kBallAngle, "ball_angle",
     "the ball joint of {subject} would tilt {measured}, limit {limit}, {excess} too far", kAngle,
     true, kNoStop, 422},
    {kConditionNumber, "condition_number",
     "too near a singularity: condition number {measured}, limit {limit}", kRatio, true, kNoStop,
     422},
    {kAmbiguousAssembly, "ambiguous_assembly",
     "ambiguous: the nearest answer is {measured} away from the last pose, limit {limit}", kAngle,
     true, kNoStop, 422},
    {kNotConverged, "not_converged",
     "no answer found: the remaining error is {measured}, tolerance {limit}", kLength, true,
     kNoStop, 422},
    {kPulseRange, "pulse_range", "{subject} would need pulse {measured}, limit {limit}", kCount,
     true, kNoStop, 422},
    {kStepRange, "step_range", "{subject} would need step {measured}, limit {limit}", kCount, true,
     kNoStop, 422},
    {kUnsendable, "unsendable",
     "{subject} at {measured} cannot be sent: the byte 0D in it would cut the command in two",
     kCount, true, kNoStop, 422},
    {kMultiplierRange, "multiplier_range",
     "multiplier {measured} of {subject} is outside 1..{limit}", kCount, true, kNoStop, 422},
    {kGripperRange, "gripper_range", "gripper position {measured} is outside 0..{limit}", kCount,
     true, kNoStop, 422},
    {kDeviceSilent, "device_silent", "{device} did not answer within {limit}", kTime, false, kHold,
     504},
    {kUnexpectedReply, "unexpected_reply",
     "the device answered byte {measured} where {limit} was due", kCount, false, kHold, 502},
    {kDeviceRefused, "device_refused", "the device called the command invalid", kNone, true, kHold,
     502},
    {kReplyMismatch, "reply_mismatch", "{subject}: the device reports {measured}, sent {limit}",
     kCount, false, kHold, 502},
    {kBusy, "busy", "a command is still under way", kNone, true, kNoStop, 409},
    {kDeviceSync, "device_sync",
     "the device's own sync mode is on, which counts positions in a frame of its own; switch it "
     "off "
     "(S0) first",
     kNone, false, kNoStop, 409},
    {kProgramTooLong, "program_too_long",
     "the program comes to {measured} orders and more, limit {limit}", kCount, true, kNoStop, 422},
    {kPortClosed, "port_closed", "the port was closed by the other side", kNone, false, kHold, 503},
    {kPositionUnknown, "position_unknown",
     "nobody knows for sure where {subject} is; home it, or say where it is", kNone, false, kNoStop,
     409},
    {kNotHomed, "not_homed",
     "{subject} is not homed, or its device knows better than a statement: run a row home, sinew "
     "home or sinew commission --procedure home (servos: a row joint that names all joints)",
     kNone, false, kNoStop, 409},
    {kSegmentTime, "segment_time", "the motion cannot take {measured}; limit {limit}", kTime, true,
     kNoStop, 422},
    {kToolNotFitted, "tool_not_fitted",
     "this robot has no such tool: name it in the robot's file, or remove the row", kNone, true,
     kNoStop, 422},
    {kDeviceKilled, "device_killed",
     "the device was told to shut down and hears nothing more: cut its power, then switch it on",
     kNone, false, kHold, 503},
    {kVersionMismatch, "version_mismatch",
     "the device speaks version {measured} of its wire, this program version {limit}", kCount, true,
     kNoStop, 502},
    {kModelMismatch, "model_mismatch",
     "the device was set up for another robot; send it this robot's settings first", kNone, true,
     kNoStop, 502},
    {kBoardVelocity, "board_velocity",
     "the board moves {subject} at {measured} at most, and the robot's file says {limit}: raise "
     "the "
     "board's own limit, or lower the file's",
     kAngularVelocity, true, kNoStop, 409},
    {kBoardAcceleration, "board_acceleration",
     "the board accelerates {subject} by {measured} at most, and the robot's file says {limit}: "
     "raise the board's own limit, or lower the file's",
     kAngularAcceleration, true, kNoStop, 409},
    {kBoardSteps, "board_steps",
     "the board makes {measured} steps for a degree or mm of {subject}, and the robot's file says "
     "{limit}: one of them is wrong",
     kRatio, true, kNoStop, 409},
    {kBoardRests, "board_rests",
     "the board switches its motors off at rest, and the arm would fall: let it keep them on "
     "(GRBL: $1=255)",
     kNone, true, kNoStop, 409},
    {kChecksum, "checksum", "{measured} messages in a row came damaged; look at the cable", kCount,
     false, kHold, 502},
    {kEmergencyStop, "emergency_stop", "the emergency stop of {subject} is latched; release it",
     kNone, true, StopCategory::kStopThenPowerOff, 409},
    {kFollowingError, "following_error", "{subject} fell too far behind its setpoint", kNone, true,
     kHold, 500},
    {kStalled, "stalled", "the motor of {subject} does not turn: blocked, or too weak", kNone, true,
     kHold, 500},
    {kEncodersDisagree, "encoders_disagree",
     "the joint's and the motor's encoder of {subject} tell different stories", kNone, false, kHold,
     500},
    {kEncoderLost, "encoder_lost",
     "an encoder of {subject} gives no reading: look at its magnet and cable", kNone, false, kHold,
     500},
    {kEndStop, "end_stop", "the end stop of {subject} closed where none should be", kNone, false,
     kHold, 500},
    {kHomingFailed, "homing_failed",
     "homing of {subject} failed: its end stop was not reached in time, or stayed closed", kNone,
     false, kHold, 500},
    {kSupplyLow, "supply_low", "the supply is down to {measured}, limit {limit}", kVoltage, false,
     kHold, 503},
    {kOverheated, "overheated", "{subject} is too hot; let it cool down", kNone, true, kHold, 503},
    {kLinkSilent, "link_silent",
     "{subject} heard nothing from this program for too long and stopped by itself", kNone, true,
     kHold, 504},
    {kSelfTestFailed, "self_test_failed", "the self-test of {subject} failed", kNone, true, kHold,
     500},
    {kMotionIgnored, "motion_ignored",
     "{subject} acknowledged a motion and did not make it; read its status", kNone, false, kHold,
     502},
    {kMissedTarget, "missed_target", "{subject} came to {measured}, sent to {limit}, {excess} off",
     kAngle, true, kHold, 502},
    {kJawWidth, "jaw_width", "jaws of {measured} are asked for; they open from 0 to {limit}",
     kLength, true, kNoStop, 422},
    {kToolAngle, "tool_angle", "the tool would need {measured}, limit {limit}", kAngle, true,
     kNoStop, 422},
    {kMotionInput, "motion_input",
     "the motion of {subject} has a state or a limit that is no number, or limits out of order",
     kNone, true, kNoStop, 422},
    {kTargetVelocity, "target_velocity",
     "{subject} would have to pass its target at {measured}, limit {limit}", kAngularVelocity, true,
     kNoStop, 422},
    {kTargetAcceleration, "target_acceleration",
     "{subject} would have to pass its target at {measured}, limit {limit}", kAngularAcceleration,
     true, kNoStop, 422},
    {kNotStraight, "not_straight",
     "the joints do not start and arrive along one line, so they cannot stay on it", kNone, true,
     kNoStop, 422},
    {kMoveInput, "move_input",
     "a target, a speed or a radius of this move is no number, or is out of its range", kNone, true,
     kNoStop, 422},
    {kArcCollinear, "arc_collinear",
     "start, via point and end of the arc lie on one line: {measured} off it, at least {limit}",
     kLength, true, kNoStop, 422},
    {kNoEndStops, "no_end_stops", "this robot has no end stops to find its zeros with", kNone, true,
     kNoStop, 422},
    {kOtherBoard, "other_board",
     "the board on this port is of another kind: it answers what the kind that was asked for "
     "cannot",
     kNone, false, kNoStop, 502},
    {kMovedUnasked, "moved_unasked",
     "{subject} is at {measured} and was left at {limit}, {excess} off: it moved without an order",
     kAngle, true, kHold, 409},
    {kForeignMotion, "foreign_motion",
     "somebody else moves this machine: a button on its board, or another program", kNone, false,
     kHold, 409},
    {kUnaskedReply, "unasked_reply",
     "what comes from the device answers nothing that was asked; its last byte was {measured}",
     kCount, false, kHold, 502},
    {kDeviceRestarted, "device_restarted",
     "the device has restarted and does not know any more where the machine is", kNone, false,
     kHold, 502},
    {kSupplyFlag, "supply_flag",
     "the board of {subject} says that its supply is, or was, too low: look at the power supply; "
     "where this comes again, switch the machine off and on",
     kNone, false, kHold, 503},
    {kCollision, "collision",
     "{subject} would come within {measured} of each other, at least {limit} is asked for", kLength,
     true, kNoStop, 422},
    {kJawsContact, "jaws_contact",
     "as they close the jaws' tips go {limit} farther, too near for {subject}: back off by that "
     "much first, as with line frame=tool {dz}",
     kLength, true, kNoStop, 422},
    {kCellContact, "cell_contact",
     "{subject} would come within {measured} of something else in its cell, at least {limit} is "
     "asked for",
     kLength, true, kNoStop, 422},
    {kCellTaken, "cell_taken",
     "{subject} would come within {measured} of where another robot of the cell moves, at least "
     "{limit} is asked for",
     kLength, true, kNoStop, 409},
    {kVelocityLimit, "velocity_limit", "{subject} would move {measured} times as fast as it may",
     kRatio, true, kHold, 422},
    {kAccelerationLimit, "acceleration_limit",
     "{subject} would accelerate {measured} times as hard as it may", kRatio, true, kHold, 422},
    {kJerkLimit, "jerk_limit", "the jerk of {subject} would be {measured} times what it may be",
     kRatio, true, kHold, 422},
    {kJump, "jump",
     "{subject} would jump: its way and its speeds differ by {measured} times what its jerk "
     "explains",
     kRatio, true, kHold, 422},
    {kLeaseHeld, "lease_held", "client {measured} moves this machine; take over, or wait", kCount,
     true, kNoStop, 409},
    {kLeaseLost, "lease_lost",
     "this client may not move the machine (any more): take the lease first", kNone, true, kHold,
     403},
    {kWrongState, "wrong_state", "the machine does not take this command as it is now", kNone, true,
     kNoStop, 409},
    {kClockGap, "clock_gap",
     "this computer stood still for {measured}; the machine was stopped, since nobody watched it",
     kTime, true, kHold, 503},
    {kCycleOverrun, "cycle_overrun",
     "the control loop came late twice in a row, by {measured}, limit {limit}: the computer is "
     "busy",
     kTime, true, kHold, 503},
    {kStreamEnded, "stream_ended", "the stream of commands ended: nothing for {measured}", kTime,
     true, kHold, 408},
    {kNotRecorded, "not_recorded",
     "where the machine goes could not be recorded (disk full, or broken), so it does not go there",
     kNone, true, kHold, 507},
    {kNotInTime, "not_in_time", "what this row waits for did not come within {limit}", kTime, true,
     kNoStop, 409},
    {kNotMeasured, "not_measured", "this machine does not tell what the row asks for", kNone, true,
     kNoStop, 409},
    {kTooManyPlaces, "too_many_places",
     "behind it the machine may stand at {measured} different places, and {limit} are checked at "
     "most: end both branches with a row that names all joints",
     kCount, true, kNoStop, 422},
    {kNotUndone, "not_undone", "what a tool or a search for zeros did is not undone by going back",
     kNone, true, kNoStop, 409},
    {kAtBeginning, "at_beginning", "the program stands where it began", kNone, true, kNoStop, 409},
    {kNudgeRange, "nudge_range",
     "one step of {subject} may be {limit} at most and not nothing; {measured} was asked for",
     kAngle, true, kNoStop, 422},
    {kRideTime, "ride_time",
     "a random move of this size and back takes {measured} on this wire; the ride has {limit}",
     kTime, true, kNoStop, 422},
    {kStopLatched, "stop_latched",
     "{subject} is held by the emergency stop that this computer set in an earlier run; "
     "acknowledge it to release it, nothing moves",
     kNone, true, kNoStop, 409},
    {kDeclaredElsewhere, "declared_elsewhere",
     "{subject} cannot stand at {measured}: it is known to be no farther than {limit}, {excess} "
     "off; who moved it has to say so",
     kAngle, true, kNoStop, 409},
    {kCountedElsewhere, "counted_elsewhere",
     "{subject} is said to stand at {measured}, but the device counts {limit}, {excess} apart; say "
     "where the device counts it, or who moved it and how (--moved, moved:)",
     kAngle, true, kNoStop, 409},
    {kNoSuchService, "no_such_service", "this device has no command for that", kNone, true, kNoStop,
     422},
    {kNoWayHome, "no_way_home",
     "no way home was found around a joint that is left out, so the joints stay beside their end "
     "stops behind the search",
     kNone, true, kNoStop, 409},
    {kNoCamera, "no_camera",
     "this row looks, and no calibrated camera is known: name one in the cell's file ([[camera]], "
     "docs/vision.md)",
     kNone, true, kNoStop, 409},
    {kCameraLost, "camera_lost",
     "the camera has given no picture for {measured}: look at its cable and start again", kTime,
     true, kNoStop, 503},
    {kCameraBlind, "camera_blind",
     "the camera shows nothing that can be told apart: it is covered, or there is no light", kNone,
     true, kNoStop, 409},
    {kCameraFrozen, "camera_frozen", "the camera gives the same picture again and again", kNone,
     true, kNoStop, 503},
    {kCameraChanged, "camera_changed",
     "the camera's pictures have another size ({measured} px) than when it was calibrated ({limit} "
     "px): set it back, or calibrate it anew",
     kCount, true, kNoStop, 409},
    {kCameraMoved, "camera_moved",
     "the camera was moved: the tags on its table seem to be {measured} from where they lay, and "
     "{limit} may be; put it back, or calibrate it anew",
     kLength, true, kNoStop, 409},
    {kCameraTagsHidden, "camera_tags_hidden",
     "none of the tags on the camera's table is seen: uncover them, or calibrate it anew", kNone,
     true, kNoStop, 409},
    {kCameraInMotion, "camera_in_motion",
     "the arm moved by {measured} while the camera on it took a picture: look once it is at rest",
     kLength, true, kNoStop, 409},
    {kViewDisturbed, "view_disturbed",
     "something came into the camera's view: paused; look at the table, then resume", kNone, true,
     kNoStop, 409},
    {kNothingSeen, "nothing_seen", "no such cube is seen", kNone, true, kNoStop, 409},
    {kCubeCovered, "cube_covered", "another cube stands on it: pick that one first", kNone, true,
     kNoStop, 409},
    {kCubeCrowded, "cube_crowded",
     "its neighbours leave {measured} for a finger, which takes {limit}", kLength, true, kNoStop,
     409},
    {kCubeTooWide, "cube_too_wide", "it is {measured} wide, and the jaws open {limit}", kLength,
     true, kNoStop, 422},
    {kNotHeld, "not_held", "nothing is held after {measured} grasps", kCount, true, kNoStop, 409},
    {kNothingHeld, "nothing_held", "nothing is held: pick something first", kNone, true, kNoStop,
     409},
    {kBasketOutOfReach, "basket_out_of_reach",
     "the basket is out of reach by {excess}: move it nearer to the robot, in the Camera view or "
     "in "
     "the cell's file",
     kLength, true, kNoStop, 422},
    {kNoBasket, "no_basket",
     "this row places into a basket, and no cell is known here: run it in a cell that has one "
     "(sinew serve CELL.toml, then sinew run --cell)",
     kNone, true, kNoStop, 409},
    {kFreeDrive, "free_drive",
     "the arm is in free drive: end it first (sinew free ROBOT --end, in the panel: Hold)", kNone,
     true, kNoStop, 409},
    {kServoSilent, "servo_silent",
     "the servo of {subject} does not reply: check its plug, its number and its supply", kNone,
     false, kHold, 504},
    {kServoMode, "servo_mode",
     "the servo of {subject} is not set up to hold positions (register 33 = 0; SCS servos: limits "
     "that are not both 0)",
     kNone, true, kNoStop, 409},
    {kServoSeries, "servo_series",
     "the servo of {subject} has its bytes in the other order: the series in the robot's file is "
     "another one",
     kNone, true, kNoStop, 409},
    {kServoTurns, "servo_turns",
     "the servo of {subject} counts {measured}, outside one turn (0 to {limit}): turn the joint "
     "back, or set its middle anew",
     kCount, true, kNoStop, 409},
    {kServoRange, "servo_range",
     "the servo of {subject} goes to {measured} by its own limit, and the robot's file says "
     "{limit}: "
     "widen the servo's limits, or narrow the file's",
     kAngle, true, kNoStop, 409},
    {kSupplyHigh, "supply_high",
     "the supply is at {measured}, and the servos bear {limit}: switch it off now", kVoltage, true,
     kHold, 503},
    {kOverloaded, "overloaded",
     "the servo of {subject} is overloaded and protects itself: take the load away, then "
     "acknowledge",
     kNone, true, kHold, 503},
    {kNoProbe, "no_probe", "this device has no input that a probe could close", kNone, true,
     kNoStop, 422},
    {kProbeClosed, "probe_closed",
     "the probe input is closed before anything has moved: take the probe off what it touches; "
     "where it touches nothing, its wires or the board's setting $6 are the wrong way round",
     kNone, true, kHold, 409},
});

/// Of the same codes where bodies are in one another.
std::string_view overlap_sentence(ErrorCode code) {
  switch (code) {
    case kCollision:
      return "{subject} would overlap by {overlap}; required clearance {limit}";
    case kCellContact:
      return "{subject} would overlap something else in its cell by {overlap}; required clearance "
             "{limit}";
    case kCellTaken:
      return "{subject} would overlap the space where another robot of the cell moves by "
             "{overlap}; required clearance {limit}";
    default:
      return {};
  }
}

/// Codes whose lengths are the tool's and the bodies', where less than 0.1 mm is nothing.
bool of_bodies(ErrorCode code) {
  return code == kOutOfReach || code == kBasketOutOfReach || code == kTooClose ||
         code == kJawsContact || !overlap_sentence(code).empty();
}

/// Codes of a joint that the device may not have named.
bool of_some_joint(ErrorCode code) {
  return code == kEndStop || code == kHomingFailed || code == kEmergencyStop || code == kStalled ||
         code == kNotHomed;
}

/// A row that backs off by so much, in tenths of a millimetre.
std::string back_off(double length) {
  constexpr double kRounding = 1e-6;
  char text[32];
  std::snprintf(text, sizeof text, "dz=-%.6gmm", std::ceil(to_mm(length) * 10 - kRounding) / 10);
  return text;
}

std::string format_value(double value, Quantity quantity) {
  char text[64];
  const auto print = [&](const char* format, double v) {
    // Rounding is nothing, and must not print as "3.1e-14" or "-0".
    constexpr double kNothing = 1e-9;
    std::snprintf(text, sizeof text, format, std::abs(v) < kNothing ? 0.0 : v);
    return std::string(text);
  };
  switch (quantity) {
    case kLength: {
      // To 0.1 mm; what is less than that keeps two digits.
      const double mm = to_mm(value);
      if (std::abs(mm) < 0.1) return print("%.2g mm", mm);
      return print("%.6g mm", std::round(mm * 10) / 10);
    }
    case kAngle:
      return print("%.6g deg", to_deg(value));
    case kTime:
      return print("%.3g s", value);
    case kCount:
      return print("%.0f", value);
    case kVoltage:
      return print("%.3g V", value);
    case kVelocity:
      return print("%.6g mm/s", to_mm(value));
    case kAcceleration:
      return print("%.6g mm/s^2", to_mm(value));
    case kAngularVelocity:
      return print("%.6g deg/s", to_deg(value));
    case kAngularAcceleration:
      return print("%.6g deg/s^2", to_deg(value));
    case kRatio:
    case kNone:
      return print("%.3g", value);
  }
  return {};
}

}  // namespace

std::span<const ErrorInfo> error_table() {
  return kTable;
}

const ErrorInfo& info(ErrorCode code) {
  const auto row = static_cast<std::size_t>(code);
  SINEW_ASSERT(row < kTable.size());
  return kTable[row];
}

std::string describe(const Error& error, std::string_view subject,
                     std::optional<Quantity> quantity) {
  const ErrorInfo& row = info(error.code);
  const Quantity unit = quantity.value_or(row.quantity);
  std::string fallback = "J" + std::to_string(error.index + 1);
  if (error.index < 0) fallback = of_some_joint(error.code) ? "the arm" : "the value";
  if (error.other >= 0) {
    fallback = "links " + std::to_string(error.index) + " and " + std::to_string(error.other);
  }
  const auto value = [&](double v) {
    constexpr double kNothing = 1e-9, kShown = 0.05e-3;  // m
    const bool little = std::abs(v) >= kNothing && std::abs(v) < kShown;
    return little && of_bodies(error.code) ? "less than 0.1 mm" : format_value(v, unit);
  };
  std::string text;
  std::string_view rest = row.sentence;
  const std::string_view overlap = overlap_sentence(error.code);
  if (error.measured < 0 && !overlap.empty()) rest = overlap;
  while (!rest.empty()) {
    const std::size_t open = rest.find('{');
    text += rest.substr(0, open);
    if (open == std::string_view::npos) break;
    const std::size_t close = rest.find('}', open);
    const std::string_view field = rest.substr(open + 1, close - open - 1);
    const std::string_view whom = subject.empty() ? std::string_view(fallback) : subject;
    if (field == "subject") {
      text += whom;
    } else if (field == "device") {
      // Of several boards it is one that is meant.
      text += error.index < 0 ? "the device" : "the board of " + std::string(whom);
    } else if (field == "measured") {
      text += value(error.measured);
    } else if (field == "limit") {
      text += value(error.limit);
    } else if (field == "overlap") {
      text += value(-error.measured);
    } else if (field == "dz") {
      text += back_off(error.limit);
    } else {
      SINEW_ASSERT(field == "excess");
      text += value(excess(error));
    }
    rest.remove_prefix(close + 1);
  }
  return text;
}

}  // namespace sinew
