#include "sinew/cli/device_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>

#include "sinew/cli/commission_verb.h"
#include "sinew/cli/device_argument.h"
#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/local_cell.h"
#include "sinew/cli/program_report.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/table.h"
#include "sinew/core/spelling.h"
#include "sinew/driver/icp.h"
#include "sinew/io/interrupt.h"
#include "sinew/runtime/robot_link.h"
#include "sinew/runtime/robot_variant.h"
#include "sinew/runtime/session_pace.h"
#include "sinew/wire/tmc222_words.h"

namespace sinew::cli {
namespace {

using Kind = DriverEvent::Kind;

constexpr std::array<std::string_view, 4> kHexapodActions{"status", "wake", "kill", "jog"};
constexpr std::array<std::string_view, 1> kBoardActions{"release"};
/// Microsteps of one leg in one call; 1 mm.
constexpr std::int64_t kStepsMax = 4571;

/// The driver of one hexapod on its port, one command at a time.
class Hexapod {
 public:
  Hexapod(runtime::RobotLink link, const io::Clock& clock, const RobotModel& model)
      : link_(std::move(link)),
        clock_(clock),
        model_(model),
        icp_(dynamic_cast<IcpDriver&>(link_.driver())) {}

  /// Until the device has answered. @return why it did not
  std::optional<std::string> open() {
    icp_.open(clock_.now());
    return wait([](Kind kind) { return kind == Kind::kReady; }, runtime::opening_of(model_).limit);
  }

  /// Gives a command and waits for its end. @return why it failed
  std::optional<std::string> carry_out(const std::function<Expected<void>(IcpDriver&)>& command) {
    const auto accepted = command(icp_);
    if (!accepted) return failed(accepted.error());
    return wait([](Kind kind) { return kind == Kind::kDone || kind == Kind::kStopped; },
                std::chrono::minutes(10));
  }

  Instant now() const { return clock_.now(); }
  const IcpDriver& icp() const { return icp_; }
  /// Of the last command that failed.
  const Error& trouble() const { return trouble_; }

 private:
  std::string failed(const Error& trouble) {
    trouble_ = trouble;
    return error_text(trouble, model_);
  }

  std::optional<std::string> wait(const std::function<bool(Kind)>& is_end, Duration limit) {
    const Instant end = clock_.now() + limit;
    bool stopped = false;
    Error trouble{.code = ErrorCode::kDeviceSilent, .limit = to_seconds(limit)};
    while (clock_.now() < end) {
      while (const auto event = icp_.take_event()) {
        if (is_end(event->kind)) return std::nullopt;
        if (event->kind != Kind::kFailed) continue;
        trouble = event->error;
        if (icp_.state() != DriverState::kOpening) return failed(trouble);
      }
      if (icp_.fault()) return failed(*icp_.fault());
      if (io::interrupts() > 0 && !stopped) {
        stopped = true;
        icp_.stop(clock_.now());
      }
      if (const auto turned = link_.line().turn(runtime::kSliceMax); !turned) {
        trouble_ = {ErrorCode::kPortClosed};
        return turned.error().sentence;
      }
    }
    return failed(trouble);
  }

  runtime::RobotLink link_;
  const io::Clock& clock_;
  const RobotModel& model_;
  IcpDriver& icp_;
  Error trouble_;
};

std::string flags_text(const tmc222::Flags& flags) {
  std::string text;
  for (const tmc222::FlagWord& word : tmc222::kFlagWords) {
    if (flags.*word.flag) text += (text.empty() ? "" : ", ") + std::string(word.text);
  }
  return text.empty() ? "none" : text;
}

Outcome status_outcome(const IcpDriver& icp, const RobotModel& model) {
  Outcome outcome;
  outcome.json["legs"] = Json::array();
  Table table({"leg", "motion", "last step", "flags", "the 12 bytes"});
  table.left(1).left(3).left(4);
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    const auto& status = icp.status(leg);
    if (!status) continue;
    std::string bytes;
    for (const std::uint8_t byte : icp::encode_status(*status)) {
      bytes += fmt::format("{}{:02X}", bytes.empty() ? "" : " ", byte);
    }
    const std::string flags = flags_text(status->one.flags);
    const std::string motion(tmc222::words(status->one.motion).text);
    table.add(
        {model.joints[leg].name, motion, fmt::format("{}", status->two.target), flags, bytes});
    outcome.json["legs"].push_back({{"joint", model.joints[leg].name},
                                    {"motion", motion},
                                    {"target_units", status->two.target},
                                    {"actual_units", status->two.actual},
                                    {"flags", flags},
                                    {"bytes", bytes}});
  }
  outcome.text = table.text();
  return outcome;
}

/// What the modules answered, also where that is why the driver takes no more questions.
Outcome told_in_doubt(const IcpDriver& icp, const RobotModel& model, const std::string& why) {
  Outcome outcome = status_outcome(icp, model);
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint = why;
  outcome.json["error"] = {{"sentence", why}};
  return outcome;
}

Outcome act(const DeviceRequest& request, Hexapod& hexapod, const RobotModel& model) {
  const auto fail = [&](const std::string& why) { return could_not(request.port + ": " + why); };
  if (request.action == "status") {
    for (std::size_t leg = 0; leg < kLegs; ++leg) {
      if (const auto why = hexapod.carry_out(
              [&](IcpDriver& icp) { return icp.read_status(leg, hexapod.now()); })) {
        return told_in_doubt(hexapod.icp(), model, request.port + ": " + *why);
      }
    }
    return status_outcome(hexapod.icp(), model);
  }
  Outcome outcome;
  if (request.action == "wake") {
    if (const auto why =
            hexapod.carry_out([&](IcpDriver& icp) { return icp.wake(hexapod.now()); })) {
      return fail(*why);
    }
    outcome.text = "all motors are awake\n";
  } else {
    if (const auto why =
            hexapod.carry_out([&](IcpDriver& icp) { return icp.kill(hexapod.now()); })) {
      return fail(*why);
    }
    outcome.text = "the controller is shut down; it hears nothing until its power was cut\n";
  }
  outcome.json["done"] = request.action;
  return outcome;
}

/// Where the joints are, as the controller knows them.
void tell_positions(const runtime::Station& station, Outcome& outcome) {
  const runtime::StationView view = station.view();
  const std::span positions(view.positions.data(), view.positions.size());
  outcome.text += "  known: " + standing_text(positions, station.robot()) + "\n";
  outcome.json["positions"] = positions_json(positions, station.robot());
}

Outcome failed(const DeviceRequest& request, const std::string& why) {
  return could_not(request.port + ": " + why);
}

/// In steps as large as the robot's file allows.
Outcome jog_leg(const DeviceRequest& request, LocalCell& cell) {
  const RobotModel& model = cell.station().robot();
  if (const auto why = cell.enable()) {
    return failed(
        request, error_text(*why, model) + silence_hint(model, *why, cell.station().view().health));
  }
  const auto leg = static_cast<std::uint8_t>(*request.leg - 1);
  const auto& device = std::get<IcpDevice>(model.device.settings);
  const double unit = (*request.steps < 0 ? device.units_per_down : 1) / device.units_per_m;
  const auto most = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(model.device.capability.nudge_max / unit));
  for (std::int64_t left = *request.steps; left != 0;) {
    const std::int64_t part = std::clamp(left, -most, most);
    const control::ControlEvent end =
        cell.carry_out(control::Nudge{leg, static_cast<double>(part) * unit});
    if (end.kind == control::ControlEvent::Kind::kStopped) return failed(request, "stopped");
    if (end.kind != control::ControlEvent::Kind::kDone) {
      return failed(request, error_text(end.error, model));
    }
    left -= part;
  }
  Outcome outcome;
  outcome.text = fmt::format("{}: {} microsteps\n", model.joints[leg].name, *request.steps);
  outcome.json["done"] = request.action;
  tell_positions(cell.station(), outcome);
  return outcome;
}

bool is_latched_stop(ErrorCode code) {
  return code == ErrorCode::kEmergencyStop || code == ErrorCode::kStopLatched;
}

/// The latch of an emergency stop is taken back, and nothing moves.
Outcome release(const DeviceRequest& request, LocalCell& cell) {
  const RobotModel& model = cell.station().robot();
  const auto why = cell.enable();
  Outcome outcome;
  outcome.text = "no emergency stop is latched\n";
  if (why && !is_latched_stop(why->code)) {
    return failed(
        request, error_text(*why, model) + silence_hint(model, *why, cell.station().view().health));
  }
  if (why) {
    const control::ControlEvent end = cell.carry_out(control::Acknowledge{});
    if (end.kind != control::ControlEvent::Kind::kDone) {
      return failed(request, error_text(end.error, model));
    }
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

std::expected<RobotModel, Outcome> robot_called(const DeviceRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return std::unexpected(file.error());
  auto model = runtime::variant_of(file->model, request.profile, request.wire);
  if (!model) return std::unexpected(bad_input(model.error()));
  const bool hexapod = std::holds_alternative<IcpDevice>(model->device.settings);
  if (!hexapod && boards_of(model->device).empty()) {
    return std::unexpected(
        could_not(model->id +
                  ": only the hexapod's controller and the boards of robot-arm-2 have commands of "
                  "their own; sinew doctor --robot " +
                  model->id + " --port DEVICE queries the others"));
  }
  const auto known = hexapod ? std::span<const std::string_view>(kHexapodActions)
                             : std::span<const std::string_view>(kBoardActions);
  if (std::ranges::find(known, request.action) == known.end()) {
    std::string all;
    for (const std::string_view one : known) all += (all.empty() ? "" : ", ") + std::string(one);
    return std::unexpected(bad_input("'" + printable(request.action) + "' is none of " + all));
  }
  return std::move(*model);
}

/// Through a cell of its own: controller, journal and settings as of any other motion.
Outcome act_in_cell(const DeviceRequest& request, const RobotModel& model) {
  auto cell = LocalCell::start(model,
                               {.port = request.port,
                                .profile = request.profile,
                                .journal = request.journal,
                                .seed = 1,
                                .time_scale = request.time_scale,
                                .byte_log = {},
                                .assumes_start = false},
                               {});
  if (!cell) return cell.error();
  return request.action == "release" ? release(request, **cell) : jog_leg(request, **cell);
}

std::expected<void, Outcome> check_options(const DeviceRequest& request) {
  if (request.action == "jog") {
    if (!request.leg || *request.leg < 1 || *request.leg > static_cast<std::int64_t>(kLegs)) {
      return std::unexpected(bad_input("--leg: jog needs one of 1 to 6"));
    }
    if (!request.steps || *request.steps == 0 || std::abs(*request.steps) > kStepsMax) {
      return std::unexpected(bad_input(fmt::format(
          "--steps: jog needs a number of microsteps up to {}, positive to lengthen the leg",
          kStepsMax)));
    }
    return {};
  }
  const char* option = request.leg ? "--leg" : "--steps";
  if (!request.leg && !request.steps) return {};
  const std::string whole =
      request.action == "kill" ? "shuts the whole controller down" : "asks all of them";
  return std::unexpected(bad_input(std::string(option) + ": " + request.action + " " + whole +
                                   " and takes no such option; only jog does"));
}

}  // namespace

Outcome run_device_action(const DeviceRequest& request) {
  auto model = robot_called(request);
  if (!model) return model.error();
  if (const auto fine = check_options(request); !fine) return fine.error();
  if (const auto fine = check_time_scale(request.time_scale); !fine) return fine.error();
  if (request.time_scale != 1 && is_real(request.port)) {
    return bad_input("--time-scale: a real port keeps real time");
  }
  const auto settings = use_commissioning(*model, request.settings, is_real(request.port));
  if (!settings) return settings.error();
  io::catch_interrupts();
  if (request.action == "jog" || request.action == "release") return act_in_cell(request, *model);
  const io::Clock clock = runtime::clock_for(request.port, request.time_scale);
  runtime::ByteLog log;
  auto link = runtime::RobotLink::open(*model, request.port, clock, log);
  if (!link) return could_not(link.error().sentence);
  Hexapod hexapod(std::move(*link), clock, *model);
  if (const auto why = hexapod.open()) {
    const std::string sentence = request.port + ": " + *why +
                                 silence_hint(*model, hexapod.trouble(), hexapod.icp().health());
    const bool asked = request.action == "status" && hexapod.icp().status(0);
    return asked ? told_in_doubt(hexapod.icp(), *model, sentence) : could_not(sentence);
  }
  return act(request, hexapod, *model);
}

}  // namespace sinew::cli
