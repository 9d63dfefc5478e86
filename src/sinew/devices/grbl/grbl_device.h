#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/instant.h"
#include "sinew/devices/grbl/grbl_device_planner.h"
#include "sinew/devices/grbl/grbl_wire.h"

namespace sinew::grbl {

/// What is stored in a board, `$$`.
struct BoardSettings {
  struct Axis {
    double steps_per_unit = 1;  ///< $100 ..
    AxisRates rates;            ///< $110 .. (per min there), $120 ..
    double travel = 0;          ///< $130 .., units
    bool homes_down = true;     ///< $23: its switch is at the lower end
    double homed_at = 0;        ///< its position behind a homing cycle, units
  };
  Firmware firmware = Firmware::kGrbl;
  FixedVector<Axis, kAxesMax> axes;
  double deviation = 0.01;     ///< $11, units
  std::uint8_t idle_ms = 255;  ///< $1: 255 keeps its motors on
  bool homing = false;         ///< $22: there are switches; it begins in an alarm
  double homing_rate = 20;     ///< $25, units/s; $24 is a twentieth of it
  double pull_off = 2;         ///< $27, units

  /// FluidNC has lines for more; GRBL 1.1 counts 128 characters.
  std::size_t bytes() const { return firmware == Firmware::kGrbl ? 128 : 1024; }
};

/// Firmware of a board that speaks GRBL: its lines, its states and alarms, its planner. What its
/// motors do is asked for, what its switches do is set. @rt
///
///   state  | what                                       | next
///   -------+--------------------------------------------+-------------------------------
///   kIdle  | a motion                                   | kRun
///   kRun   | the last motion is over                    | kIdle
///   kRun   | `!`                                        | kHold; `~`: kRun
///   kIdle  | jog                                        | kJog; over, or cancelled: kIdle
///   kIdle  | probe                                      | kRun; touched, or over: kIdle
///   kIdle  | probe, whose input is closed               | kAlarm (4)
///   kIdle, kAlarm | `$H`                                | kHome; each axis found: kIdle
///   any    | reset (0x18): at rest                      | kIdle, or kAlarm as before
///   any    | reset in a motion                          | kAlarm (3, 6), position not known
///   any    | a switch closes in a motion                | kAlarm (1), position not known
///   kAlarm | `$X`                                       | kIdle
class GrblDevice {
 public:
  GrblDevice(const BoardSettings& settings, Instant boot);

  void advance(Instant now);
  /// When it will say something by itself.
  std::optional<Instant> next_event() const;
  void receive(std::uint8_t byte, Instant now);
  std::size_t take_output(std::span<std::uint8_t> out) { return output_.take_front(out); }

  /// Of a motor since it was built, units: whole steps.
  double turned(std::size_t axis) const;
  double velocity(std::size_t axis) const { return planner_.velocity(axis); }
  /// Where it believes to be, units.
  double believed(std::size_t axis) const { return turned(axis) - zero_[axis]; }
  State state() const { return state_; }
  bool moving() const;
  std::uint64_t bytes_lost() const { return bytes_lost_; }

  /// Switches that are closed from now on.
  void set_switches(AxisMask closed) { switches_ = closed; }
  void set_probe(bool closed) { probe_closed_ = closed; }
  void set_emergency_stop(bool pressed);
  /// Its power is away until power_up().
  void lose_power();
  void power_up(Instant now);
  bool powered() const { return powered_; }

 private:
  /// For a switch: quickly, off it, once more slowly, off it.
  enum class Search : std::uint8_t { kNone, kSeek, kBackOff, kLocate, kPullOff };

  void step(Duration dt);
  void settle();
  void step_homing();
  void step_probing();
  void begin_search(std::size_t axis, Search phase);
  void real_time(RealTime what);
  void read_lines();
  void answer(std::string_view line);
  void answer(const Request& request);
  void answer(const Move& move);
  void answer(const Jog& jog);
  void answer(const Probe& probe);
  void show_settings();
  void show_build();
  void say(const Reply& reply);
  void reset();
  void alarm(std::uint16_t code);
  void begin();
  Status status();
  Values believed() const;
  Values rounded(const Values& motor) const;

  BoardSettings settings_;
  Planner planner_;
  Values zero_;  ///< of its motors' turns, where it counts 0
  Instant now_;
  std::optional<Instant> boots_;

  State state_ = State::kIdle;
  std::uint16_t alarm_ = 0;
  bool powered_ = true;
  bool emergency_ = false;
  bool critical_ = false;  ///< hears nothing but a reset
  AxisMask switches_ = 0;
  bool probe_closed_ = false;
  bool probes_ = false;            ///< a probe's way is under way
  std::optional<Values> touched_;  ///< where its input closed, and it brakes
  std::size_t homing_axis_ = 0;
  Search search_ = Search::kNone;

  FixedVector<std::uint8_t, 1024> received_;
  LineDecoder lines_;
  bool line_waits_ = false;  ///< of lines_, for room in the planner
  double tool_z_ = 0;        ///< G43.1; work coordinates are machine coordinates minus it
  int offset_due_ = 0;       ///< reports until one has the work coordinates' offset again
  std::uint64_t bytes_lost_ = 0;
  FixedVector<std::uint8_t, 2048> output_;
};

}  // namespace sinew::grbl
