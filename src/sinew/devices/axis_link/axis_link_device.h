#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/axis/axis_device.h"
#include "sinew/devices/axis/axis_device_setup.h"
#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/model/robot_model.h"
#include "sinew/wire/board_image.h"
#include "sinew/wire/cobs.h"

namespace sinew {

struct AxisLinkNodeSettings {
  axis_link::AxisModel model;  ///< what the firmware was set up for, its axis number included
  std::uint16_t boot = 0;      ///< from a counter that survives a reset
  /// rad, at most, between the position that is told and the joint; of a measured joint, a count.
  double uncertainty = 2 * kPi / 4096;
  std::optional<BoardImage> image = std::nullopt;  ///< that runs on the board
};

/// Node `axis` of a robot with such a joint there.
AxisLinkNodeSettings axis_link_node_settings(const Joint& joint, std::uint8_t axis,
                                             std::uint16_t boot = 0);

/// Of a board that was set up so; of one that was not.
AxisLinkNodeSettings axis_link_node_settings(const std::optional<AxisSetup>& setup,
                                             std::uint16_t boot);

/// Axis side of the axis link (docs/wires/axis_link.md): frames in, requests to an Axis, its state
/// out. One object serves SPI (select, shift) or a stream of bytes (receive, take_output).
///
///   session | what happens                           | what it does
///   --------+----------------------------------------+-------------------------------------------
///   any     | hello of this version and model        | opens the next session, stops what moves
///   any     | hello of another model or deadline     | nothing: the answer says what it is
///   open    | the session's own hello again          | nothing
///   any     | stop, emergency stop                   | executes it, whatever session and sequence
///   none    | any other frame                        | nothing: kNoSession
///   open    | new frame of this session              | executes it, the deadline starts again
///   open    | the last one executed again            | nothing: the answer is repeated
///   open    | an older one, or another session's     | nothing
///   open    | no new frame before the deadline       | closes the session; where the axis moves or
///           |                                        | tracks, stops it and latches kLinkSilent
///
/// Frames that are not good, or for another axis, change nothing at all. All members are @rt.
class AxisLinkNode {
 public:
  /// @param setup  what the board keeps of its axis, where it can be read and written; outlives
  ///               the node
  AxisLinkNode(Axis& axis, const AxisLinkNodeSettings& settings, SetupStore* setup = nullptr);

  /// SPI: the level of its chip select. What the axis answers is fixed when it is selected; what
  /// the host sent is acted on when it is deselected.
  void select(bool selected);
  bool selected() const { return selected_; }
  /// One byte each way; 0 where it is not selected, or beyond the frame.
  std::uint8_t shift(std::uint8_t mosi);

  /// What it answers when it is selected the next time; for boards whose transfers run without the
  /// processor.
  const axis_link::Frame& next_answer() const { return prepared_; }

  /// UART and RS-485: the same frames, COBS between 00s. A frame to all has no answer.
  void receive(std::span<const std::uint8_t> bytes);
  std::size_t take_output(std::span<std::uint8_t> out);

  /// Time passes: the deadline is watched and the next answer prepared.
  void advance(Instant now);
  /// A new setup was kept, and its answer had time to be fetched: the board shall start again.
  bool restart_due() const { return restart_at_ && now_ >= *restart_at_; }
  /// When the deadline will be over, where a session is open.
  std::optional<Instant> next_event() const;

  std::uint8_t session() const { return session_; }
  std::uint64_t good_frames() const { return good_frames_; }
  std::uint64_t bad_frames() const { return bad_frames_; }

 private:
  bool take_frame(std::span<const std::uint8_t, axis_link::kFrameSize> bytes);
  void execute(const axis_link::Request& request);
  void greet(const axis_link::Request& request);
  axis_link::Verdict obey(const axis_link::Request& request);
  std::optional<std::uint32_t> word(std::int32_t index) const;
  axis_link::Verdict write_setup(const axis_link::Request& request);
  void close_session();
  void prepare();
  axis_link::State state() const;
  axis_link::Health health() const;

  Axis& axis_;
  SetupStore* setup_;
  AxisLinkNodeSettings settings_;
  std::uint32_t hash_;

  std::uint8_t last_session_;  ///< number of the last session, open or not
  std::uint8_t session_ = 0;
  std::uint16_t executed_ = 0;  ///< sequence of the last frame that was executed
  std::uint16_t greeted_ = 0;   ///< sequence of the hello that opened the session
  axis_link::Verdict verdict_ = axis_link::Verdict::kNoSession;
  axis_link::Mode asked_ = axis_link::Mode::kRead;  ///< by the last good frame
  std::optional<axis_link::SetupWord> word_;        ///< that was asked for
  std::optional<Instant> restart_at_;
  Duration deadline_ = axis_link::kDeadlineDefault;
  Instant now_;
  Instant heard_;  ///< when the last new frame of the session came

  axis_link::Frame prepared_{};
  axis_link::Frame sending_{};
  axis_link::Frame received_{};
  std::size_t shifted_ = 0;
  bool selected_ = false;
  cobs::Decoder decoder_;
  FixedVector<std::uint8_t, 4 * (axis_link::kFrameSize + 3)> output_;
  std::uint64_t good_frames_ = 0;
  std::uint64_t bad_frames_ = 0;
};

}  // namespace sinew
