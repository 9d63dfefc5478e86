#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "sinew/devices/grbl/grbl_driver_pace.h"
#include "sinew/devices/grbl/grbl_driver_positions.h"
#include "sinew/devices/grbl/grbl_settings.h"
#include "sinew/devices/grbl/grbl_wire.h"
#include "sinew/driver/driver.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// The pieces of a streamed motion as lines for a GRBL board, and how far the board is on them: its
/// counts say where, and the pieces' own times which of two places on a path that comes back along
/// itself. @rt
class GrblMotion {
 public:
  struct Piece {
    grbl::Move line;
    double time = 0;      ///< s that the board takes for it, by its own arithmetic
    bool no_way = false;  ///< nothing to send: the next line takes its time as well
    bool rest = false;    ///< ends at rest
    bool sent = false;
    bool accepted = false;  ///< ok
    JointVector end;        ///< as it was asked for, before rounding
  };
  /// Where a board is on its way.
  struct Spot {
    std::size_t piece = 0;
    double time = 0;  ///< s since the first piece began, by their own times
  };
  static constexpr std::size_t kPiecesMax = 14;  ///< GRBL has room for 15 motions
  using Pieces = FixedVector<Piece, kPiecesMax>;

  GrblMotion(const GrblDevice& device, std::span<const Joint> joints);

  /// A new one, from where the board stands.
  void begin(const grbl::Values& counts);
  void clear() { pieces_.clear(); }
  /// The next piece, from the end of the last one.
  /// @param known  whose counts mean places
  /// @error kUnsendable, kJointLimit, kSegmentTime; nothing is taken then
  Expected<void> push(const JointMove& move, const GrblPositions& known, Instant now);
  /// The first one begins now.
  void started(Instant now) { began_ = now; }

  bool empty() const { return pieces_.empty(); }
  bool full() const { return pieces_.full(); }
  Pieces& pieces() { return pieces_; }
  const Piece& last() const { return pieces_.back(); }
  const Piece& first() const { return pieces_[0]; }
  std::size_t size() const { return pieces_.size(); }
  /// The board has a line whose motion is not over.
  bool is_to_move() const;
  /// From a count to the ends of the lines that the board has, and where the first of them begins,
  /// units: its lines are straight.
  JointInterval ahead(std::size_t joint, double count) const;
  bool all_accepted() const;
  /// Pieces that are not over, by their own times since the last status.
  std::size_t waiting(Instant now) const;
  /// Until its pieces are over by their own times.
  Duration left(Instant now) const;

  /// Nothing where the board is on none of its pieces.
  /// @param asked  when the counts were asked for
  std::optional<Spot> spot_of(const grbl::Values& counts, Instant asked) const;
  /// It is where it is sent, when it is.
  bool on_time(const grbl::Values& counts, Instant asked) const;
  /// It was there then, later or earlier than it was asked to be.
  void be_at(const Spot& spot, Instant asked) { began_ = asked - from_seconds(spot.time); }
  /// The first ones are over.
  void drop(std::size_t count);

  /// Units that a count may be from where it was sent.
  double tolerance(std::size_t joint) const;
  bool is_there(const grbl::Values& counts, const grbl::Values& target) const;

 private:
  std::optional<Error> refusal(std::size_t joint, double from, double to, Duration duration) const;
  double sayable(std::size_t joint, double count) const;

  GrblDevice device_;
  FixedVector<Joint, grbl::kAxesMax> joints_;
  GrblPace pace_;
  Pieces pieces_;
  grbl::Values begin_;   ///< counts where the first of them begins
  grbl::Values before_;  ///< .. and the one that was over last
  JointVector speed_;    ///< where the last one ends, rad/s
  double carried_ = 0;   ///< s of pieces without a way, which the next line takes as well
  Instant began_{};      ///< the first of them, by their own times
};

}  // namespace sinew
