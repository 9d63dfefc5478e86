#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "sinew/driver/driver.h"
#include "sinew/model/device.h"
#include "sinew/wire/spi.h"

namespace sinew {

/// The waits of one transaction; the defaults are the document's.
struct AxisRegisterTiming {
  Duration setup = axis_registers::kSelectSetup;
  Duration step_pause = axis_registers::kStepPause;
  Duration validation_pause = axis_registers::kValidationPause;
  Duration error_pause = axis_registers::kErrorPause;
  Duration syn_retry_pause = axis_registers::kSynRetryPause;
  Duration resync_pause = axis_registers::kResyncPause;
  /// Where the host remembers the last session's, the one behind it; else a board may refuse the
  /// first transaction (02), and the next id is tried.
  std::uint16_t first_frame_id = axis_registers::kFrameIdFirst;
  int tries = 3;  ///< transactions in a row that may fail before the axis has
};

/// What is asked of a board.
struct AxisRegisterRequest {
  std::uint8_t select = 0;  ///< bit i: axis i
  axis_registers::Operation operation = axis_registers::Operation::kRead;
  std::uint16_t address = 0;
  std::uint16_t size = 1;     ///< of the register
  axis_registers::Data data;  ///< of a WRITE, `size` bytes
  int tries = 1;
  /// To several boards at once: their answers may collide, so nothing of them is believed, and the
  /// whole script is sent.
  bool blind = false;
};

/// What became of it.
struct AxisRegisterOutcome {
  std::optional<Error> error;  ///< without an index
  axis_registers::Data value;  ///< of a READ
};

/// Register transactions over SPI, one at a time: handshake, retries with a new frame id, and the
/// resynchronisation behind every failure.
///
///   step          | what comes back       | next
///   --------------+-----------------------+-------------------------------------------------
///   kResync       | anything, 4 times     | kSyn
///   kSyn          | anything              | kSynAck
///   kSynAck       | 98                    | kAck
///   kSynAck       | anything else         | kSyn once more, then failed
///   kAck, kHeader | anything              | the next
///   kValidation   | 00                    | kData
///   kValidation   | anything else         | failed
///   kData         | good CRC, or a WRITE  | kCommit
///   kCommit       | COMMIT 00, or a READ  | done
///   failed        |                       | 50 ms, kResync, a new id; or told, no tries left
///
/// A WRITE is repeated when its COMMIT got lost, although it may have been carried out: that is
/// safe because every register says what shall be, not what shall be done on top. All @rt.
class AxisRegisterLink {
 public:
  AxisRegisterLink(const AxisRegistersDevice& device, const AxisRegisterTiming& timing);

  /// Forgets what is under way; nothing is known of any board's state.
  void reset();
  /// Not while busy().
  void start(const AxisRegisterRequest& request, Instant now);
  bool busy() const { return step_ != Step::kIdle; }

  /// Ends what is under way without carrying it out, if that is still possible: before the header
  /// it is dropped (the board takes up the next handshake from there), behind it a WRITE gets data
  /// whose CRC is wrong. No outcome follows; busy() until the board is free.
  void abandon();

  std::optional<spi::Transfer> take_transfer(Instant now);
  void exchanged(std::span<const std::uint8_t> miso, Instant now);
  std::optional<AxisRegisterOutcome> take_outcome();
  /// When the next transfer is due; the bus may be busy until then.
  std::optional<Instant> next_deadline() const;

  /// The id that the next transaction gets; worth remembering over a session.
  std::uint16_t frame_id() const { return frame_id_; }
  const DriverHealth& health() const { return health_; }

 private:
  enum class Step : std::uint8_t {
    kIdle,
    kResync,
    kSyn,
    kSynAck,
    kAck,
    kHeader,
    kValidation,
    kData,
    kCommit,
  };

  void begin_try();
  std::uint16_t take_frame_id();
  spi::Bytes bytes_of(Step step) const;
  Duration pause_behind(Step step) const;
  void check(std::span<const std::uint8_t> miso, Instant now);
  void check_data(std::span<const std::uint8_t> miso, Instant now);
  void check_commit(std::span<const std::uint8_t> miso, Instant now);
  void fail(Error error, Instant now);
  void finish(const AxisRegisterOutcome& outcome);
  bool droppable() const;

  std::uint8_t slave_id_;
  std::uint32_t clock_hz_;
  AxisRegisterTiming timing_;

  Step step_ = Step::kIdle;
  bool in_transfer_ = false;
  bool abandoned_ = false;
  Instant free_at_;  ///< no transfer before
  AxisRegisterRequest request_;
  axis_registers::SealedData sealed_;
  axis_registers::HeaderBytes header_{};
  Instant begun_;
  int tries_left_ = 0;
  int tries_made_ = 0;
  bool syn_repeated_ = false;
  int bursts_left_ = 0;
  std::uint8_t unsure_ = 0xFF;  ///< bit i: axis i may wait for anything
  std::uint16_t frame_id_;
  std::array<std::uint16_t, kMaxJoints> last_ids_{};
  axis_registers::Data value_;
  std::optional<AxisRegisterOutcome> outcome_;
  DriverHealth health_;
};

}  // namespace sinew
