#pragma once

#include <cstdint>

namespace sinew {

/// Every expected failure of Sinew. One line of meaning each; the rest is in the table of
/// error.cc: sentence, unit, what it does to the position, which stop follows, HTTP status.
enum class ErrorCode : std::uint8_t {
  kOutOfReach,          ///< the target is farther than the arm is long; measured, limit: m
  kTooClose,            ///< the target is inside the arm's inner reach; measured, limit: m
  kJointLimit,          ///< index: joint; measured, limit: rad
  kShoulderSingular,    ///< measured: distance of the wrist from the first axis, m
  kElbowSingular,       ///< measured: |sin| of the elbow's angle from straight or folded
  kWristSingular,       ///< measured: |sin| of the wrist's bend
  kSingular,            ///< measured: smallest singular value of the scaled Jacobian
  kApproachOutOfPlane,  ///< measured: angle of the approach axis out of the arm's plane, rad
  kRollNotFree,  ///< measured: angle about the tool axis to the nearest roll it can have, rad
  kOrientationNotReachable,  ///< measured: angle to the nearest orientation that can be had, rad
  kTaskNotSupported,         ///< this arm has no such task (a pitch for an arm that has none)
  kLegLength,                ///< index: leg; measured, limit: m
  kCardanAngle,              ///< index: leg; measured, limit: rad
  kBallAngle,                ///< index: leg; measured, limit: rad
  kConditionNumber,          ///< measured, limit: condition number of the platform's Jacobian
  kAmbiguousAssembly,        ///< measured, limit: rad between the answer and the last pose
  kNotConverged,             ///< measured: remaining error; limit: tolerance
  kPulseRange,               ///< index: joint; measured, limit: device units
  kStepRange,                ///< index: joint; measured, limit: steps
  kUnsendable,               ///< index: joint; measured: value that would cut its own frame
  kMultiplierRange,          ///< index: joint; measured, limit: device units
  kGripperRange,             ///< measured, limit: device units
  kDeviceSilent,             ///< measured: time waited; limit: time allowed, s
  kUnexpectedReply,          ///< the device answered something else than what was asked
  kDeviceRefused,            ///< the device said that the command is invalid
  kReplyMismatch,            ///< index: joint; measured: what it reported; limit: what was sent
  kBusy,                     ///< a command is still under way
  kDeviceSync,               ///< the device moves its joints in a frame that it does not report
  kProgramTooLong,           ///< measured, limit: orders
  kPortClosed,               ///< the port went away
  kPositionUnknown,          ///< index: joint; it is lost or uncertain, so nothing plans with it
  kNotHomed,                 ///< index: joint
  kSegmentTime,              ///< measured, limit: s; longer or shorter than this wire can say
  kToolNotFitted,            ///< this robot has no such tool
  kDeviceKilled,             ///< the device answers nothing more until its power is cut
  kVersionMismatch,          ///< measured: what the device speaks; limit: what the host does
  kModelMismatch,            ///< the device was set up for another robot
  kBoardVelocity,            ///< index: joint; measured: the board's own limit; limit: the file's
  kBoardAcceleration,        ///< likewise
  kBoardSteps,               ///< likewise; per degree
  kBoardRests,               ///< the board switches its motors off at rest
  kChecksum,                 ///< a message came damaged, again and again; measured: how often
  kEmergencyStop,            ///< index: joint; latched until it is released
  kFollowingError,           ///< index: joint; the device is too far behind its setpoint
  kStalled,                  ///< index: joint; the motor does not turn
  kEncodersDisagree,         ///< index: joint; its two encoders tell different stories
  kEncoderLost,              ///< index: joint; an encoder gives no reading
  kEndStop,                  ///< index: joint; an end stop closed where none should
  kHomingFailed,             ///< index: joint; the end stop was not found, or stayed closed
  kSupplyLow,                ///< measured, limit: V
  kOverheated,               ///< index: joint
  kLinkSilent,               ///< index: joint; the device heard nothing from us for too long
  kSelfTestFailed,           ///< index: joint
  kMotionIgnored,            ///< index: joint; the device acknowledged a motion and did not make it
  kMissedTarget,             ///< index: joint; measured: where it is, limit: where it was sent, rad
  kJawWidth,                 ///< measured, limit: m
  kToolAngle,                ///< measured, limit: rad
  kMotionInput,         ///< index: joint; a state or a limit is not finite, or limits out of order
  kTargetVelocity,      ///< index: joint; measured, limit: rad/s, at or beside the target
  kTargetAcceleration,  ///< index: joint; measured, limit: rad/s^2
  kNotStraight,         ///< the states do not lie along one line of joint space
  kMoveInput,           ///< a target, speed or radius of a move is not finite or out of its range
  kArcCollinear,        ///< measured, limit: m that the via point is off the line to the end
  kNoEndStops,          ///< this robot cannot find its zeros by itself
  kOtherBoard,          ///< the board answers what the kind that was asked for cannot
  kMovedUnasked,        ///< index: joint; measured: where it is, limit: where it was left, rad
  kForeignMotion,       ///< somebody else moves the machine
  kUnaskedReply,        ///< bytes that answer nothing; measured: the last of them
  kDeviceRestarted,     ///< what it knew of its position is gone
  kSupplyFlag,          ///< index: joint; its board says that the supply was too low, or away
  kCollision,    ///< index, other: links (model/collision_links.h); measured, limit: m between them
  kJawsContact,  ///< index, other: links; measured: m between them; limit: m that the tips go on
  kCellContact,  ///< index: link; measured, limit: m to something else in the cell
  kCellTaken,    ///< likewise; what is there moves, and will be gone
  kVelocityLimit,      ///< index: joint; measured: asked for over allowed
  kAccelerationLimit,  ///< likewise
  kJerkLimit,          ///< likewise
  kJump,               ///< index: joint; measured: what its way and its speeds differ by, likewise
  kLeaseHeld,          ///< measured: the client that has it
  kLeaseLost,          ///< it has ended, or somebody else has it
  kWrongState,         ///< a command that this state of the machine does not take
  kClockGap,           ///< measured, limit: s between two cycles
  kCycleOverrun,       ///< measured, limit: s, twice in a row
  kStreamEnded,        ///< measured: s since the last command of a stream; limit: its life
  kNotRecorded,        ///< what the machine would do next could not be recorded
  kNotInTime,          ///< what a row waits for did not come; limit: s
  kNotMeasured,        ///< what a row asks for is nothing that this machine tells
  kTooManyPlaces,      ///< measured, limit: places where a row of a program may begin
  kNotUndone,          ///< a step back over what a tool or a search for zeros did
  kAtBeginning,        ///< a step back where none was made
  kNudgeRange,         ///< index: joint; measured, limit: rad or m, of one step that nobody plans
  kRideTime,           ///< measured: time of a random move and back; limit: what was given, s
  kStopLatched,        ///< index: joint; held by a stop that this host set in an earlier run
  kDeclaredElsewhere,  ///< index: joint; measured: declared, limit: as far as it can be, rad or m
  kCountedElsewhere,   ///< index: joint; measured: said, limit: where the device counts it
  kNoSuchService,      ///< the device has no command for what a person asks of it
  kNoWayHome,          ///< behind a search for zeros: no way home is clear of what was left out
  kNoCamera,           ///< a program looks, and no camera is configured
  kCameraLost,         ///< measured: s without a picture
  kCameraBlind,        ///< the picture shows nothing: black, covered, over-exposed
  kCameraFrozen,       ///< the same picture again and again
  kCameraChanged,      ///< measured: width of its pictures; limit: when it was calibrated, px
  kCameraMoved,        ///< measured: where its tags seem to be now; limit: what may be, m
  kCameraTagsHidden,   ///< none of the tags of its table is seen
  kCameraInMotion,     ///< measured: what the arm that carries it went while it took a picture, m
  kViewDisturbed,      ///< something came into the camera's view while the arm moved
  kNothingSeen,        ///< no such cube on the table
  kCubeCovered,        ///< another cube stands on it
  kCubeCrowded,        ///< measured: room beside a cube; limit: what a finger takes, m
  kCubeTooWide,        ///< measured: the cube; limit: how far the jaws open, m
  kNotHeld,            ///< measured: so many grasps, and nothing was held
  kNothingHeld,        ///< a row releases what was never picked
  kBasketOutOfReach,   ///< measured, limit: as kOutOfReach
  kNoBasket,           ///< a row places into one, and no cell is known that has it
  kFreeDrive,          ///< the motors are off so that the arm can be guided by hand
  kServoSilent,        ///< index: joint; its servo does not reply on the bus
  kServoMode,          ///< index: joint; its servo is set up as a wheel, not to hold positions
  kServoSeries,        ///< index: joint; its servo is of a series with other bytes
  kServoTurns,         ///< index: joint; measured: what its servo counts, limit: of one turn
  kServoRange,   ///< index: joint; measured: where its servo's own limit ends it, limit: the file's
  kSupplyHigh,   ///< measured, limit: V
  kOverloaded,   ///< index: joint; its servo protects itself and holds with a part of its torque
  kNoProbe,      ///< the device has no input that ends a way where it closes
  kProbeClosed,  ///< .. and it is closed before the way begins
};

}  // namespace sinew
