#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "sinew/core/cubic.h"
#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/driver/driver.h"
#include "sinew/driver/send_range.h"
#include "sinew/model/robot_model.h"

/// Pieces of a streamed motion, and the setpoints between their ends. All @rt.
namespace sinew::segments {

using Setpoint = Cubic::State;  ///< rad (m), per s

/// The cubic from one setpoint to another, inside a range.
class CubicPiece {
 public:
  CubicPiece() = default;
  /// @param range  where the joint may be sent meanwhile
  CubicPiece(const Setpoint& from, const Setpoint& to, double duration, const SendRange& range);

  /// Never outside the range. @param t  s from its start, 0..duration.
  Setpoint at(double t) const;
  Setpoint end() const { return cubic_.end(); }
  /// Whether it stays in its range and inside the joint's limit of speed all along.
  /// @error kJointLimit (it swings out between its ends), kSegmentTime (limit: what it would need)
  Expected<void> check(const Joint& joint) const;

 private:
  Cubic cubic_;
  SendRange range_;
};

/// One piece for every joint.
struct Segment {
  FixedVector<CubicPiece, kMaxJoints> pieces;
  Instant start;
  Instant end;
  bool ends_at_rest = false;
};

/// The pieces that were asked for and are not over.
class SegmentQueue {
 public:
  /// As many as give a host of 20 ms segments 60 ms of reserve.
  static constexpr std::size_t kSegments = 4;

  /// The next piece from the end of the last one, or from `start` at `now` where there is none.
  /// Nothing is taken on error.
  /// @error kUnsendable (number of joints, a speed that is no number), kJointLimit, kSegmentTime,
  /// with the joint's index
  Expected<void> push(const JointMove& move, std::span<const Joint> joints,
                      std::span<const Setpoint> start, Instant now);
  bool empty() const { return segments_.empty(); }
  bool full() const { return segments_.full(); }
  std::size_t size() const { return segments_.size(); }
  void clear() { segments_.clear(); }

  /// @pre not empty
  const Segment& front() const { return segments_[0]; }
  const Segment& back() const { return segments_.back(); }
  void pop_front();
  /// Where the joint shall be at `when`; beyond the last end it is that end.
  Setpoint at(std::size_t joint, Instant when) const;

 private:
  FixedVector<Segment, kSegments> segments_;
};

}  // namespace sinew::segments
