#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <vector>

#include "firmware/emulation/emulated_board.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis_link/axis_link_driver_setup.h"
#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/wire/little_words.h"

namespace sinew::emulation {

/// A board on a bench: one that time passes for, and a host at its SPI pins.
class AxisBench : public EmulatedBoard {
 public:
  using EmulatedBoard::EmulatedBoard;

  /// Lets time pass; false where the program did what no program may.
  bool run(double seconds) {
    for (auto left = std::llround(seconds / kStep); left > 0 && !broken; --left) {
      broken = chip.run_for(kStep);
      advance_plant(kStep);
    }
    return !broken;
  }

  /// Bytes on the wire, and what came back.
  std::vector<std::uint8_t> transfer(std::span<const std::uint8_t> mosi) {
    return chip.transfer(mosi, 4'000'000, 20e-6);
  }
  /// A frame and its answer: what the axis was when the frame began. Nothing where it is none.
  std::optional<axis_link::Reply> exchange(const axis_link::Request& request) {
    const std::vector<std::uint8_t> miso = transfer(axis_link::encode(request));
    if (miso.size() != axis_link::kFrameSize) return std::nullopt;
    const auto reply = axis_link::decode_reply(
        std::span<const std::uint8_t, axis_link::kFrameSize>(miso.data(), miso.size()));
    if (!reply) return std::nullopt;
    session = reply->session;
    if (const auto* told = std::get_if<axis_link::State>(&reply->body)) state = *told;
    if (const auto* told = std::get_if<axis_link::Identity>(&reply->body)) identity = *told;
    return *reply;
  }
  /// The next frame of the session, and 10 ms, as a host at 100 Hz has it.
  bool send(axis_link::Mode mode, double q = 0, double qd = 0) {
    const axis_link::Request request{.axis = setup.axis_number,
                                     .mode = mode,
                                     .sequence = ++sequence,
                                     .target = axis_link::to_units(q).value(),
                                     .velocity = axis_link::to_velocity_units(qd).value(),
                                     .session = session};
    const bool good = exchange(request).has_value();
    return run(0.01) && good;
  }
  /// For what a host does to boards that are not in use.
  axis_link::SetupLine setup_line() {
    return {.exchange =
                [this](std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso) {
                  std::ranges::copy(transfer(mosi), miso.begin());
                  return true;
                },
            .wait = [this](Duration time) { static_cast<void>(run(to_seconds(time))); }};
  }
  /// Each word of a setup, not stored yet.
  bool write_setup_words(const SetupBytes& bytes) {
    for (std::size_t i = 0; i < kSetupWords; ++i) {
      const bool good = exchange({.axis = setup.axis_number,
                                  .mode = axis_link::Mode::kWriteSetup,
                                  .sequence = ++sequence,
                                  .target = std::bit_cast<std::int32_t>(little_word(bytes, i)),
                                  .velocity = static_cast<std::int32_t>(i),
                                  .session = session})
                            .has_value();
      if (!run(0.005) || !good) return false;
    }
    return true;
  }
  /// Asks who it is, and opens a session.
  bool open(std::optional<std::uint8_t> number = std::nullopt) {
    using axis_link::hello;
    if (!run(0.1)) return false;
    for (int i = 0; i < 3; ++i) {
      exchange(hello(number.value_or(setup.axis_number), ++sequence, identity.model_hash,
                     axis_link::kDeadlineDefault));
      if (!run(0.01)) return false;
    }
    return send(axis_link::Mode::kRead) && session != 0;
  }
  /// Until `done` holds, with frames that read; false where that takes longer.
  template <class Done>
  bool read_until(Done done, double seconds) {
    for (double t = 0; t < seconds; t += 0.01) {
      if (!send(axis_link::Mode::kRead)) return false;
      if (done()) return true;
    }
    return false;
  }
  bool home() {
    return send(axis_link::Mode::kHome) && read_until([&] { return state.homing; }, 1) &&
           read_until([&] { return state.homed && !state.moving && !state.homing; }, 60);
  }
  double told() const { return axis_link::from_units(state.position); }

  static constexpr double kStep = 1e-3;  // s, of the plant

  std::optional<std::string> broken;

  std::uint16_t sequence = 0;
  std::uint8_t session = 0;
  axis_link::State state;
  axis_link::Identity identity;
};

}  // namespace sinew::emulation
