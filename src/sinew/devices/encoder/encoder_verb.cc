#include "sinew/devices/encoder/encoder_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <expected>
#include <optional>
#include <utility>

#include "sinew/devices/encoder/encoder_device_reader.h"
#include "sinew/devices/encoder/encoder_settings.h"
#include "sinew/devices/encoder/encoder_wire.h"
#include "sinew/io/clock.h"
#include "sinew/io/interrupt.h"
#include "sinew/io/port.h"
#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

using encoder_link::kTurn;
using encoder_link::Register;

constexpr int kLooks = 50;              // requests for POSITION
constexpr double kFastest = 4 * kTurn;  // ticks/s; by hand
constexpr double kLeastTurn = 0.02;     // of a turn by hand, below which no direction is said
/// Without a pause of 3 ms for longer, nothing can be asked.
constexpr Duration kNeverQuiet = std::chrono::milliseconds(500);
constexpr double kShownEach = 0.1;  // s
constexpr double kDegPerTick = 360.0 / kTurn;

/// The port with a conversation on it, waited for.
class NodeLine {
 public:
  explicit NodeLine(io::Port port) : port_(std::move(port)) {}

  /// Nothing where no good reply came in time, where Ctrl-C was pressed, or the port is gone.
  std::optional<std::uint16_t> ask(Register name) {
    const Instant begin = clock_.now();
    while (!link_.ready(clock_.now())) {
      read();
      if (clock_.now() - begin > kNeverQuiet) {
        trouble_ = "the line is never quiet: another host or another device talks on it";
      }
      if (ended()) return std::nullopt;
    }
    ++asked_;
    const Instant sent_at = clock_.now();
    const auto request = link_.ask(name, sent_at);
    if (const auto sent = port_.write(request); !sent) trouble_ = sent.error().sentence;
    echo_left_ = echoes_.value_or(true) ? request.size() : 0;
    sent_ = request;
    while (!ended()) {
      if (const auto reply = read()) {
        slowest_ = std::max(slowest_, clock_.now() - sent_at);
        ++replies_;
        return reply->value;
      }
      if (std::exchange(failed_, false)) break;
    }
    return std::nullopt;
  }

  Instant now() const { return clock_.now(); }
  int asked() const { return asked_; }
  int replies() const { return replies_; }
  Duration slowest() const { return slowest_; }
  std::uint64_t stray_bytes() const { return link_.stray_bytes(); }
  /// Why there is nothing more to ask.
  const std::optional<std::string>& trouble() const { return trouble_; }

 private:
  bool ended() const { return trouble_ || io::interrupts() > 0; }
  std::optional<encoder_link::Reply> read() {
    std::array<std::uint8_t, 64> bytes{};
    const auto count = port_.read(bytes, std::chrono::milliseconds(1));
    if (!count) {
      trouble_ = count.error().sentence;
      return std::nullopt;
    }
    std::optional<encoder_link::Reply> good;
    for (std::size_t i = 0; i < *count; ++i) {
      if (is_echo(bytes[i])) continue;
      const auto reply = link_.receive(bytes[i], clock_.now());
      if (!reply) continue;
      failed_ = !reply->has_value();
      if (*reply) good = **reply;
    }
    if (link_.poll(clock_.now())) failed_ = true;
    return good;
  }
  /// Some adapters receive what they send. The first reply begins with the bytes of its request
  /// only where one does: STATUS never says 55.
  bool is_echo(std::uint8_t byte) {
    if (echo_left_ == 0) return false;
    const std::size_t place = sent_.size() - echo_left_;
    if (!echoes_ && byte != sent_[place]) {
      // No echo: what looked like one was the reply.
      echoes_ = false;
      echo_left_ = 0;
      for (std::size_t i = 0; i < place; ++i) link_.receive(sent_[i], clock_.now());
      return false;
    }
    if (--echo_left_ == 0) echoes_ = true;
    return true;
  }

  io::Port port_;
  io::Clock clock_;
  // An adapter on USB gives bytes on every 16 ms where it is not told otherwise.
  encoder_link::Conversation link_{{.reply_timeout = std::chrono::milliseconds(60)}};
  bool failed_ = false;
  std::optional<bool> echoes_;  ///< once it is known
  std::size_t echo_left_ = 0;
  encoder_link::RequestBytes sent_{};
  int asked_ = 0;
  int replies_ = 0;
  Duration slowest_{};
  std::optional<std::string> trouble_;
};

/// Follows the shaft while it is turned by hand.
/// @error  a sentence: no direction can be said
std::expected<void, std::string> watch(NodeLine& line, double seconds, Outcome& outcome) {
  encoder_link::Unwrap unwrap(kFastest);
  std::optional<std::int64_t> first;
  std::int64_t last = 0;
  const bool live = io::stderr_is_terminal();
  const Instant begin = line.now();
  double shown = 0;
  while (to_seconds(line.now() - begin) < seconds && io::interrupts() == 0 && !line.trouble()) {
    const auto position = line.ask(Register::kPosition);
    if (!position || *position >= kTurn) continue;
    const auto ticks = unwrap.update(*position, line.now());
    if (!ticks) continue;
    if (!first) first = ticks;
    last = *ticks;
    const double at = to_seconds(line.now() - begin);
    if (!live || at < shown) continue;
    shown = at + kShownEach;
    std::fprintf(stderr, "\r  %7.2f deg, turned %+8.1f deg  ", *position * kDegPerTick,
                 static_cast<double>(last - *first) * kDegPerTick);
  }
  if (live) std::fputs("\n", stderr);
  if (!first) return std::unexpected("no position came while the shaft was watched");
  if (!unwrap.certain()) {
    return std::unexpected(
        "replies were lost while the shaft was watched, so its direction is not known: check the "
        "cable, and turn it slowly");
  }
  const double turned = static_cast<double>(last - *first) * kDegPerTick;
  const bool moved = std::abs(turned) >= kLeastTurn * 360;
  outcome.json["turned_deg"] = turned;
  outcome.text += moved ? fmt::format("  turned {:+.1f} deg: this direction counts {}\n", turned,
                                      turned > 0 ? "up" : "down")
                        : "  the shaft was not turned\n";
  return {};
}

std::string advice(Magnet magnet) {
  switch (magnet) {
    case Magnet::kNoReply:
      return "the AS5600 does not acknowledge: check SCL, SDA, its supply and its pull-ups";
    case Magnet::kMissing:
      return "the AS5600 sees no magnet: a diametric magnet sits centred, 0.5 to 3 mm above it";
    case Magnet::kTooWeak:
      return "the magnet is too weak: move it nearer to the AS5600";
    case Magnet::kTooStrong:
      return "the magnet is too strong: move it away from the AS5600";
    default:
      return {};
  }
}

/// What the node replied; nothing of a register that was silent.
struct Readings {
  std::uint16_t status = 0;
  std::optional<std::uint16_t> position = {};
  std::optional<std::int16_t> velocity = {};
  std::optional<std::int16_t> acceleration = {};
  int lost_positions = 0;
};

/// Nothing where not even STATUS came.
std::optional<Readings> read_registers(NodeLine& line) {
  auto status = line.ask(Register::kStatus);
  // One lost reply is no silence.
  if (!status && !line.trouble() && io::interrupts() == 0) status = line.ask(Register::kStatus);
  if (!status) return std::nullopt;
  Readings readings{.status = *status};
  for (int i = 0; i < kLooks && !line.trouble() && io::interrupts() == 0; ++i) {
    const auto one = line.ask(Register::kPosition);
    if (one) readings.position = one;
    if (!one) ++readings.lost_positions;
    if (i == 1 && !readings.position) return readings;
  }
  const auto with_sign = [&](Register name) -> std::optional<std::int16_t> {
    const auto value = line.ask(name);
    if (!value) return std::nullopt;
    return static_cast<std::int16_t>(*value);
  };
  readings.velocity = with_sign(Register::kVelocity);
  readings.acceleration = with_sign(Register::kAcceleration);
  return readings;
}

void report(const Readings& readings, Outcome& outcome) {
  const int errors = readings.status >> 8;
  outcome.json["magnet"] = magnet_word(magnet_in(readings.status));
  outcome.json["status"] = readings.status;
  outcome.json["i2c_errors"] = errors;
  outcome.text +=
      fmt::format("  magnet: {}; failed readings of the AS5600: {}{}\n",
                  magnet_word(magnet_in(readings.status)), errors, errors == 255 ? " or more" : "");
  if (!readings.position) return;
  const double angle = *readings.position * kDegPerTick;
  outcome.json["position_ticks"] = *readings.position;
  outcome.json["angle_deg"] = angle;
  outcome.text += fmt::format("  angle: {:.2f} deg ({} of {})", angle, *readings.position, kTurn);
  if (readings.velocity) {
    outcome.json["velocity_ticks_s"] = *readings.velocity;
    outcome.text += fmt::format(", {:.1f} deg/s", *readings.velocity * kDegPerTick);
  }
  if (readings.acceleration) {
    outcome.json["acceleration_ticks_s2"] = *readings.acceleration;
    outcome.text += fmt::format(", {:.0f} deg/s^2", *readings.acceleration * kDegPerTick);
  }
  outcome.text += "\n";
}

}  // namespace

Outcome examine_encoder(const EncoderRequest& request) {
  auto port = io::Port::open_serial(request.port, kEncoderBaud);
  if (!port) return could_not(port.error().sentence);
  io::catch_interrupts();
  NodeLine line(std::move(*port));
  const auto readings = read_registers(line);
  if (line.trouble()) return could_not(request.port + ": " + *line.trouble());
  if (io::interrupts() > 0) return could_not("stopped before everything was asked");
  if (!readings) {
    const std::string others =
        line.stray_bytes() == 0
            ? std::string(": check its supply, and A and B of RS-485 (try them swapped)")
            : fmt::format("; {} other bytes came: another host on this line, or another device",
                          line.stray_bytes());
    return could_not(fmt::format("{}: no encoder node replies at {} baud{}", request.port,
                                 kEncoderBaud, others));
  }
  Outcome outcome;
  outcome.json["port"] = request.port;
  outcome.text = fmt::format("  encoder node on {}\n", request.port);
  report(*readings, outcome);
  outcome.json["requests"] = line.asked();
  // Without a position POSITION is silent, which is no lost reply.
  outcome.json["lost_replies"] = readings->position ? readings->lost_positions : 0;
  outcome.json["slowest_reply_ms"] = std::round(to_seconds(line.slowest()) * 1e4) / 10;
  outcome.text += fmt::format("  replies: {} of {}, the slowest after {:.1f} ms\n", line.replies(),
                              line.asked(), to_seconds(line.slowest()) * 1e3);
  std::string trouble = advice(magnet_in(readings->status));
  if (readings->position && request.watch_s > 0) {
    if (const auto seen = watch(line, request.watch_s, outcome); !seen) trouble = seen.error();
  }
  if (line.trouble()) return could_not(request.port + ": " + *line.trouble());
  if (trouble.empty()) return outcome;
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint = request.port + ": " + trouble;
  return outcome;
}

}  // namespace sinew::cli
