#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>

/// What the BigRobotArm's firmware and its host say to each other, whichever of its two wires
/// carries it. docs/wires/bigrobotarm.md has the tables.
namespace sinew::bigrobotarm {

inline constexpr std::size_t kJoints = 5;

/// One number per joint: base, shoulder, elbow, wrist rotate, wrist. Motor microsteps for
/// positions, hundredths of a motor revolution per s (or s^2) for speeds (accelerations).
using Words = std::array<std::int32_t, kJoints>;

// Requests, host to device.

struct Goto {
  Words positions{};  ///< microsteps
  friend bool operator==(const Goto&, const Goto&) = default;
};
/// To 0 0 0 0 0 with an ordinary motion: the arm has no switches to find a home with.
struct Home {
  friend bool operator==(const Home&, const Home&) = default;
};
/// The place where the arm stands becomes 0 0 0 0 0.
struct Reset {
  friend bool operator==(const Reset&, const Reset&) = default;
};
struct SetSpeeds {
  Words speeds{};
  friend bool operator==(const SetSpeeds&, const SetSpeeds&) = default;
};
struct SetAccelerations {
  Words accelerations{};
  friend bool operator==(const SetAccelerations&, const SetAccelerations&) = default;
};
struct SetGripper {
  bool enabled = false;
  std::uint8_t position = 0;  ///< degrees of its servo; ignored unless enabled
  friend bool operator==(const SetGripper&, const SetGripper&) = default;
};
struct SetSync {
  bool on = false;
  friend bool operator==(const SetSync&, const SetSync&) = default;
};
struct ReadStatus {
  friend bool operator==(const ReadStatus&, const ReadStatus&) = default;
};

using Request =
    std::variant<Goto, Home, Reset, SetSpeeds, SetAccelerations, SetGripper, SetSync, ReadStatus>;

/// Ids of the byte wire: 1 + the place in `Request`.
enum class RequestId : std::uint8_t {
  kGoto = 1,
  kHome,
  kReset,
  kSpeeds,
  kAccelerations,
  kGripper,
  kSync,
  kStatus,
};

constexpr RequestId id_of(const Request& request) {
  return static_cast<RequestId>(request.index() + 1);
}

// Replies, device to host.

/// The only thing the device says before it is ready again: a motion was taken up.
struct MotionStarted {
  RequestId id = RequestId::kGoto;  ///< kGoto or kHome
  friend bool operator==(const MotionStarted&, const MotionStarted&) = default;
};
struct GotoDone {
  Words positions{};  ///< microsteps; the target, never where the arm really is
  friend bool operator==(const GotoDone&, const GotoDone&) = default;
};
struct HomeDone {
  Words positions{};
  friend bool operator==(const HomeDone&, const HomeDone&) = default;
};
struct ResetDone {
  Words positions{};
  friend bool operator==(const ResetDone&, const ResetDone&) = default;
};
struct Speeds {
  Words speeds{};
  friend bool operator==(const Speeds&, const Speeds&) = default;
};
struct Accelerations {
  Words accelerations{};
  friend bool operator==(const Accelerations&, const Accelerations&) = default;
};
struct Gripper {
  bool enabled = false;
  std::uint8_t position = 0;
  friend bool operator==(const Gripper&, const Gripper&) = default;
};
struct Sync {
  bool on = false;
  friend bool operator==(const Sync&, const Sync&) = default;
};
struct Status {
  Words positions{};
  Words accelerations{};
  Words speeds{};
  std::optional<Gripper> gripper;  ///< always there on the byte wire, never on the text wire
  bool sync = false;
  friend bool operator==(const Status&, const Status&) = default;
};
/// Done, with nothing to report: text wire only, inside and at BEGIN.
struct Accepted {
  friend bool operator==(const Accepted&, const Accepted&) = default;
};
/// The device did not know the command.
struct Invalid {
  friend bool operator==(const Invalid&, const Invalid&) = default;
};

// The queue of the text wire of 2026.

/// The motion starts now, or when those before it are over.
struct Queued {
  Words positions{};  ///< where it will end
  friend bool operator==(const Queued&, const Queued&) = default;
};
/// Four wait behind the running one: it was not taken.
struct QueueFull {
  friend bool operator==(const QueueFull&, const QueueFull&) = default;
};
struct QueueDrained {
  friend bool operator==(const QueueDrained&, const QueueDrained&) = default;
};
/// Those that waited are forgotten; the running one ends where it was sent.
struct QueueCleared {
  friend bool operator==(const QueueCleared&, const QueueCleared&) = default;
};

using Reply =
    std::variant<MotionStarted, GotoDone, HomeDone, ResetDone, Speeds, Accelerations, Gripper, Sync,
                 Status, Accepted, Invalid, Queued, QueueFull, QueueDrained, QueueCleared>;

/// What no reply of the device can hold.
struct Garbage {
  std::uint8_t seen = 0;      ///< the byte that does not fit
  std::uint8_t expected = 0;  ///< a byte that would
  friend bool operator==(const Garbage&, const Garbage&) = default;
};

}  // namespace sinew::bigrobotarm
