#include <fmt/format.h>

#include <array>
#include <functional>

#include "sinew/cli/cells/device_verb.h"
#include "sinew/core/error_code.h"
#include "sinew/devices/axis/axis_device_setup_model.h"
#include "sinew/devices/axis_link/axis_link_driver_setup.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/io/interrupt.h"
#include "sinew/model/error_sentence.h"
#include "sinew/model/left_out.h"
#include "sinew/runtime/links/robot_link.h"

/// What a person may ask of axis boards: to take back a latched emergency stop, and to test
/// themselves.
namespace sinew::cli {
namespace {

/// Each board of itself; the first that fails is the complaint.
Outcome self_test(const DeviceRequest& /*request*/, LocalCell& cell) {
  if (const auto why = cell.enable()) return could_not(cell.sentence(*why));
  const RobotModel& model = cell.station().robot();
  const runtime::StationView before = cell.station().view();
  const control::ControlEvent end = cell.carry_out(control::Service{DeviceService::kSelfTest});
  if (end.error.code == ErrorCode::kNoSuchService) {
    return could_not(cell.sentence(end.error) +
                     "; boards of the profile as-built tell nothing of themselves");
  }
  if (end.kind != control::ControlEvent::Kind::kDone) return not_done(cell, end);
  Outcome outcome;
  outcome.json = {{"done", "test"}, {"boards", Json::array()}};
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const bool asked = !is_left_out(model, j);
    const bool turned = asked && before.positions[j].quality != PositionQuality::kLost;
    const char* what = turned  ? "passed; its motor turned a full step and back"
                       : asked ? "passed; a motor turns only where its joint is known"
                               : "left out";
    outcome.text += fmt::format("  {}: {}\n", model.joints[j].name, what);
    outcome.json["boards"].push_back(
        {{"joint", model.joints[j].name}, {"tested", asked}, {"turned", turned}});
  }
  tell_positions(cell.station(), outcome);
  return outcome;
}

bool is_latched_stop(ErrorCode code) {
  return code == ErrorCode::kEmergencyStop || code == ErrorCode::kStopLatched;
}

/// The latch of an emergency stop is taken back, and nothing moves.
Outcome release(const DeviceRequest& request, LocalCell& cell) {
  const auto why = cell.enable();
  Outcome outcome;
  outcome.text = "no emergency stop is latched\n";
  if (why && !is_latched_stop(why->code)) return could_not(cell.sentence(*why));
  if (why) {
    const control::ControlEvent end = cell.carry_out(control::Acknowledge{});
    if (end.kind != control::ControlEvent::Kind::kDone) return not_done(cell, end);
    const bool own = why->code == ErrorCode::kStopLatched;
    outcome.text = own ? "released: an earlier run on this computer had set the latch; nothing has "
                         "moved\n"
                       : "released; no record says that this computer had set the latch. Nothing "
                         "has moved\n";
    outcome.json["set_by"] = own ? "this computer" : "unknown";
  }
  outcome.json["done"] = request.action;
  tell_positions(cell.station(), outcome);
  return outcome;
}

/// "set up now; before it was set up as J2"
std::string told(bool written, const std::optional<AxisSetup>& before, const RobotModel& model) {
  if (!written) return "has this setup already";
  if (!before) return "set up now, for the first time";
  const bool known = before->axis_number < model.joints.size();
  const std::string was = known ? model.joints[before->axis_number].name
                                : "axis " + std::to_string(before->axis_number + 1);
  return "set up now; before it was set up as " + was;
}

/// One board after the other, below driver and controller.
/// @param talk  with the board of a joint, over its line
/// @error  of the first that fails
using TalkWithBoard =
    std::function<std::expected<void, Error>(std::size_t joint, const axis_link::SetupLine& line)>;
std::expected<void, Outcome> with_each_board(const RobotOptions& where, const RobotModel& model,
                                             const TalkWithBoard& talk) {
  const auto could_not = [](const std::string& why) {
    return std::unexpected(cli::could_not(why));
  };
  if (!model.device.settings.is<AxisLinkDevice>()) {
    return could_not(model.id +
                     ": only boards of the axis link keep a setup and tell what runs on them; "
                     "--wire link, or protocol = \"axis_link\" in its file, says that these are");
  }
  const std::string& port = *where.port;
  if (const auto wrong = runtime::wrong_port(model, port)) {
    return std::unexpected(bad_input(*wrong));
  }
  const io::Clock clock = runtime::clock_for(port, 1);
  const auto bus = runtime::open_spi(model, port, clock);
  if (!bus) return could_not(bus.error().sentence);
  const auto& link = model.device.settings.get<AxisLinkDevice>();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (is_left_out(model, j)) continue;
    const auto select = static_cast<std::uint8_t>(1U << j);
    const axis_link::SetupLine line{
        .exchange =
            [&](std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso) {
              constexpr Duration kSelect = std::chrono::microseconds(20);
              return (*bus)->exchange(select, mosi, miso, kSelect, link.clock_hz).has_value();
            },
        .wait =
            [&](Duration time) {
              if (!clock.is_simulated()) return clock.pause_until(clock.now() + time);
              clock.pass_to(clock.now() + time);
              clock.keep_pace();
            }};
    if (io::interrupts() > 0) {
      return could_not("stopped; " + model.joints[j].name +
                       " and those behind it are as they were");
    }
    if (const auto done = talk(j, line); !done) {
      return could_not(sentence_of(done.error(), model));
    }
  }
  return {};
}

/// Each board for its joint, as the robot's file says.
Outcome set_up(const DeviceRequest& request, const RobotModel& model) {
  Outcome outcome;
  outcome.json = {{"done", request.action}, {"boards", Json::array()}};
  const auto write = [&](std::size_t j,
                         const axis_link::SetupLine& line) -> std::expected<void, Error> {
    const auto report = axis_link::write_setup(encode_setup(axis_setup(model, j)),
                                               static_cast<std::int8_t>(j), line);
    if (!report) return std::unexpected(report.error());
    const auto before = decode_setup(report->before);
    outcome.text +=
        fmt::format("  {}: {}\n", model.joints[j].name, told(report->written, before, model));
    outcome.json["boards"].push_back({{"joint", model.joints[j].name},
                                      {"written", report->written},
                                      {"was_set_up", before.has_value()}});
    return {};
  };
  if (const auto all = with_each_board(request.robot, model, write); !all) return all.error();
  return outcome;
}

/// What runs on each board.
std::expected<std::vector<BoardSaid>, Outcome> images(const RobotOptions& where,
                                                      const RobotModel& model) {
  std::vector<BoardSaid> boards;
  const auto read = [&](std::size_t j,
                        const axis_link::SetupLine& line) -> std::expected<void, Error> {
    const auto image = axis_link::read_board_image(static_cast<std::int8_t>(j), line);
    if (!image) return std::unexpected(image.error());
    boards.push_back({model.joints[j].name, *image});
    return {};
  };
  if (const auto all = with_each_board(where, model, read); !all) {
    return std::unexpected(all.error());
  }
  return boards;
}

constexpr std::array<DeviceAction, 4> kBoardsAll{
    {{.name = "setup",
      .note = "writes into each board what its axis is built of; its motor is without current for "
              "0.1 s then",
      .alone = set_up},
     {.name = "firmware", .note = "which image runs on each board", .alone = tell_firmware},
     {.name = "release", .note = "a latched emergency stop, nothing moves", .run = release},
     {.name = "test",
      .note = "each board of itself; a homed motor turns a full step and back",
      .run = self_test}}};

}  // namespace

extern const DeviceActions kAxisActions;
constexpr DeviceActions kAxisActions{
    .whose = "axis boards on SPI",
    .are_of = [](const Device& device) { return !boards_of(device).empty(); },
    .all = kBoardsAll,
    .images = images};

}  // namespace sinew::cli
