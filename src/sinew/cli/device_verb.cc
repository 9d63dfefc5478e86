#include "sinew/cli/device_verb.h"

#include <fmt/format.h>

#include <array>
#include <functional>

#include "sinew/cli/device_argument.h"
#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/table.h"
#include "sinew/driver/icp.h"
#include "sinew/io/interrupt.h"
#include "sinew/runtime/robot_link.h"
#include "sinew/runtime/session_pace.h"
#include "sinew/wire/tmc222_words.h"

namespace sinew::cli {
namespace {

using Kind = DriverEvent::Kind;

constexpr std::array<std::string_view, 4> kActions{"status", "wake", "kill", "jog"};

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
  } else if (request.action == "kill") {
    if (const auto why =
            hexapod.carry_out([&](IcpDriver& icp) { return icp.kill(hexapod.now()); })) {
      return fail(*why);
    }
    outcome.text = "the controller is shut down; it hears nothing until its power was cut\n";
  } else {
    const auto leg = static_cast<std::size_t>(*request.leg - 1);
    if (const auto why = hexapod.carry_out(
            [&](IcpDriver& icp) { return icp.jog(leg, *request.steps, hexapod.now()); })) {
      return fail(*why);
    }
    outcome.text = fmt::format("{}: {} microsteps, {} s each\n", model.joints[leg].name,
                               *request.steps, number(to_seconds(hexapod.icp().cycle_time()), 3));
  }
  outcome.json["done"] = request.action;
  return outcome;
}

std::expected<RobotModel, Outcome> hexapod_called(const DeviceRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return std::unexpected(file.error());
  if (!std::holds_alternative<IcpDevice>(file->model.device.settings)) {
    return std::unexpected(
        could_not(file->model.id +
                  ": only the hexapod's controller has commands of its own; sinew doctor "
                  "--robot " +
                  file->model.id + " --port DEVICE asks the others how they are"));
  }
  return file->model;
}

std::expected<void, Outcome> check_options(const DeviceRequest& request) {
  if (request.action == "jog") {
    if (!request.leg || *request.leg < 1 || *request.leg > static_cast<std::int64_t>(kLegs)) {
      return std::unexpected(bad_input("--leg: jog needs one of 1 to 6"));
    }
    if (!request.steps || *request.steps == 0) {
      return std::unexpected(
          bad_input("--steps: jog needs a number of microsteps, positive to lengthen the leg"));
    }
    return {};
  }
  const char* option = request.leg ? "--leg" : "--steps";
  if (!request.leg && !request.steps) return {};
  const std::string whole =
      request.action == "kill" ? "shuts the whole controller down" : "asks all six legs";
  return std::unexpected(bad_input(std::string(option) + ": " + request.action + " " + whole +
                                   " and takes no such option; only jog does"));
}

}  // namespace

Outcome run_device_action(const DeviceRequest& request) {
  const auto model = hexapod_called(request);
  if (!model) return model.error();
  if (std::ranges::find(kActions, request.action) == kActions.end()) {
    return bad_input("'" + request.action + "' is none of status, wake, kill, jog");
  }
  if (const auto fine = check_options(request); !fine) return fine.error();
  if (const auto fine = check_time_scale(request.time_scale); !fine) return fine.error();
  if (request.time_scale != 1 && !runtime::may_be_simulated(request.port)) {
    return bad_input("--time-scale: a real port keeps real time");
  }
  io::catch_interrupts();
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
