#include "sinew/cli/output/program_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/plan_report.h"
#include "sinew/cli/output/plot_svg.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/truth_text.h"
#include "sinew/control/stop_rules.h"
#include "sinew/core/units.h"
#include "sinew/driver/quality_name.h"
#include "sinew/planning/paths/tool_space.h"
#include "sinew/program/language/conditions.h"
#include "sinew/vision/color_names.h"

namespace sinew::cli {
namespace {

using program::MoveOrder;
using program::Record;

constexpr Duration kSamplePeriod = std::chrono::milliseconds(10);
constexpr double kVelocityWindow = 0.2;  // s

int digits_of(const RobotModel& model) {
  return all_slide(model) ? 4 : 2;
}

std::string values_text(std::span<const double> q, const RobotModel& model) {
  std::string text;
  for (std::size_t i = 0; i < q.size(); ++i) {
    text += fmt::format("{}{:.{}f}", i == 0 ? "" : " ", shown_value(q[i], model.joints[i]) + 0.0,
                        digits_of(model));
  }
  return text;
}

/// "12.30", "-4.00..5.00", or `lost` where nobody knows.
std::string position_text(const JointPosition& position, const Joint& joint, int digits,
                          const char* lost) {
  if (position.quality == PositionQuality::kLost) return lost;
  if (position.quality == PositionQuality::kUncertain) {
    return fmt::format("{:.{}f}..{:.{}f}", shown_value(position.lower, joint), digits,
                       shown_value(position.upper, joint), digits);
  }
  return fmt::format("{:.{}f}", shown_value(position.q, joint) + 0.0, digits);
}

std::string reported_text(const Record& record, const RobotModel& model) {
  std::string text;
  for (std::size_t i = 0; i < record.reported.size(); ++i) {
    text += i == 0 ? "" : " ";
    text += position_text(record.reported[i], model.joints[i], digits_of(model), "?");
  }
  return text;
}

}  // namespace

std::string standing_text(std::span<const JointPosition> positions, const RobotModel& model) {
  std::string text;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Joint& joint = model.joints[i];
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", joint.name,
                        position_text(positions[i], joint, digits_of(model), "lost"));
  }
  return text + "; " + joints_unit(model);
}

namespace {

std::string tool_text(const ToolAction& action) {
  if (const auto* jaws = std::get_if<JawsTo>(&action)) {
    const std::string held =
        jaws->held ? fmt::format(", holds {} mm", number(to_mm(*jaws->held), 4)) : "";
    return fmt::format("jaws {} mm{}", number(to_mm(jaws->width), 4), held);
  }
  if (const auto* gripper = std::get_if<GripperTo>(&action)) {
    if (!gripper->enabled) return "gripper off";
    if (!gripper->angle) return "gripper on";
    return fmt::format("gripper {} deg", number(to_deg(*gripper->angle), 4));
  }
  if (const auto* suction = std::get_if<Suction>(&action)) {
    constexpr const char* kNames[] = {"on", "release", "off"};
    return fmt::format("suction {}", kNames[static_cast<int>(suction->state)]);
  }
  const auto& nozzle = std::get<NozzleTo>(action);
  return fmt::format("nozzle {} deg in {} s", number(to_deg(nozzle.angle), 4),
                     number(to_seconds(nozzle.duration), 3));
}

/// "joint", "line", or of several rows that are one motion "line..arc".
std::string row_name(const MoveOrder& move) {
  const auto name = [](const program::Step& row) -> std::string {
    if (std::holds_alternative<program::JointStep>(row.what)) return "joint";
    if (std::holds_alternative<program::SplineStep>(row.what)) return "spline";
    constexpr const char* kNames[] = {"move", "line", "arc"};
    return kNames[static_cast<int>(std::get<program::ToolMoveStep>(row.what).way)];
  };
  const std::string first = name(move.rows.front());
  return move.rows.size() == 1 ? first : first + ".." + name(move.rows.back());
}

/// "4", "4..7"; of a called program "place 4".
std::string lines_text(const program::Order& order, const program::Run& run) {
  const std::string first = first_line(order, run);
  return order.line == order.last_line ? first : fmt::format("{}..{}", first, order.last_line);
}

std::string wait_text(const program::WaitOrder& wait, const RobotModel& model) {
  const std::string time = number(to_seconds(wait.duration), 3) + " s";
  using For = program::WaitStep::For;
  if (wait.what == For::kTime) return "wait " + time;
  if (wait.what == For::kSettled) return "wait settled for " + time;
  return "wait until " + program::condition_text(wait.until, model) + " for " + time;
}

std::string pick_text(const Record& record) {
  if (!record.cube) return "pick";
  const Vec3& p = record.cube->p_BO;
  return fmt::format("pick {} cube at {}, {} mm",
                     vision::name(static_cast<vision::ColorName>(record.cube->color)),
                     number(to_mm(p.x), 0), number(to_mm(p.y), 0));
}

std::string command_text(const Record& record, const RobotModel& model) {
  const auto& what = record.order->what;
  if (const auto* move = std::get_if<MoveOrder>(&what)) {
    return row_name(*move) + " " + values_text({record.q.data(), record.q.size()}, model);
  }
  if (const auto* wait = std::get_if<program::WaitOrder>(&what)) {
    return wait_text(*wait, model);
  }
  if (const auto* tool = std::get_if<program::ToolOrder>(&what)) return tool_text(tool->action);
  if (const auto* branch = std::get_if<program::BranchOrder>(&what)) {
    return "if " + program::condition_text(branch->condition, model) +
           (record.holds.value_or(false) ? ": yes" : ": no");
  }
  if (std::holds_alternative<program::LookOrder>(what)) return "look";
  if (std::holds_alternative<program::PlaceOrder>(what)) return "place";
  if (std::holds_alternative<program::PickOrder>(what)) return pick_text(record);
  return "home";
}

std::string predicted_text(const Record& record) {
  if (record.duration <= 0) return "";
  const bool bound = std::holds_alternative<program::HomeOrder>(record.order->what);
  return fmt::format("{}{:.2f}", bound ? "at most " : "", record.duration);
}

double took(const Record& record) {
  return to_seconds(record.done - record.asked);
}

/// Largest distance of a reported joint from where it was sent; nothing where one is not known.
std::optional<double> largest_error(const Record& record, const RobotModel& model) {
  if (!std::holds_alternative<MoveOrder>(record.order->what)) return std::nullopt;
  double largest = 0;
  for (std::size_t i = 0; i < record.q.size(); ++i) {
    const JointPosition& position = record.reported[i];
    if (position.quality < PositionQuality::kCommanded) return std::nullopt;
    largest = std::max(largest, std::abs(shown_value(position.q - record.q[i], model.joints[i])));
  }
  return largest;
}

PositionQuality worst_of(std::span<const JointPosition> positions) {
  PositionQuality worst = PositionQuality::kMeasured;
  for (const JointPosition& position : positions) worst = std::min(worst, position.quality);
  return worst;
}

const char* result_name(const ProgramReport& report) {
  if (report.left_at_once) return "left";
  switch (report.run.phase()) {
    case program::Run::Phase::kDone:
      return "done";
    case program::Run::Phase::kStopped:
      return "stopped";
    default:
      return "failed";
  }
}

}  // namespace

Json positions_json(std::span<const JointPosition> positions, const RobotModel& model) {
  Json list = Json::array();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const JointPosition& position = positions[i];
    const Joint& joint = model.joints[i];
    const std::string unit = std::string("_") + shown_unit(joint);
    Json one{{"joint", joint.name}, {"quality", quality_name(position.quality)}};
    if (position.quality != PositionQuality::kLost) {
      one["q" + unit] = shown_value(position.q, joint);
      one["lower" + unit] = shown_value(position.lower, joint);
      one["upper" + unit] = shown_value(position.upper, joint);
    }
    list.push_back(one);
  }
  return list;
}

namespace {

/// Where the tool is; nothing while a joint's position is not known.
std::optional<kinematics::PoseBT> tool_of(const program::Run& run, const RobotModel& model) {
  if (worst_of(run.machine().positions()) < PositionQuality::kCommanded) return std::nullopt;
  JointVector q;
  for (const JointPosition& position : run.machine().positions()) q.push_back(position.q);
  const planning::ToolSpace space(model, run.machine().tool().jaws);
  const auto X_BT = space.forward({q.data(), q.size()}, space.home());
  return X_BT ? std::optional(*X_BT) : std::nullopt;
}

Json health_json(const DriverHealth& health) {
  Json json{{"requests", health.requests},
            {"retries", health.retries},
            {"planned_repeats", health.repeats},
            {"timeouts", health.timeouts},
            {"unexpected", health.unexpected}};
  if (health.supply_volts) json["supply_v"] = *health.supply_volts;
  if (health.temperature_c) json["temperature_c"] = *health.temperature_c;
  return json;
}

/// How long the machine may still move, s, though the run is over.
double goes_on_for(const ProgramReport& report) {
  const auto until = report.run.machine().goes_on_until();
  return until ? std::max(0.0, to_seconds(*until - report.now)) : 0;
}

Json notices_json(const program::Run& run, const RobotModel& model) {
  Json list = Json::array();
  for (const program::Notice& notice : run.notices()) {
    Json one = error_json(notice.error, model);
    one["t_s"] = to_seconds(notice.at - run.opened_at());
    one["line"] = notice.line;
    if (notice.file != 0) {
      one["file"] = run.program().files[static_cast<std::size_t>(notice.file)];
    }
    list.push_back(one);
  }
  return list;
}

std::string notices_text(const program::Run& run, const RobotModel& model) {
  if (run.notices_told() == 0) return {};
  std::string text = "  told meanwhile:\n";
  for (const program::Notice& notice : run.notices()) {
    text += "    " + notice_text(notice, run, model) + "\n";
  }
  if (const std::size_t more = run.notices_told() - run.notices().size(); more > 0) {
    text += fmt::format("    and {} more\n", more);
  }
  return text;
}

/// s from the first order to the last one's end, or to the end of a run that broke off.
double ran_for(const ProgramReport& report) {
  const auto& run = report.run;
  if (!run.begun_at()) return 0;
  const bool done = run.phase() == program::Run::Phase::kDone && !run.records().empty();
  return to_seconds((done ? run.records().back().done : report.now) - *run.begun_at());
}

}  // namespace

std::string notice_text(const program::Notice& notice, const program::Run& run,
                        const RobotModel& model) {
  const std::string line = notice.line > 0 ? fmt::format(", line {}", notice.line) : "";
  return fmt::format("{:.2f} s{}: {}", to_seconds(notice.at - run.opened_at()), line,
                     error_text(notice.error, model));
}

std::string first_line(const program::Order& order, const program::Run& run) {
  if (order.file == 0) return fmt::format("{}", order.line);
  const std::string& path = run.program().files[static_cast<std::size_t>(order.file)];
  const std::string name = path.substr(path.rfind('/') + 1);
  return fmt::format("{} {}", name.substr(0, name.rfind(".sinew")), order.line);
}

std::string goes_on_text(const ProgramReport& report) {
  const double left = goes_on_for(report);
  if (left <= 0) return {};
  return fmt::format(
      "; the machine goes on for up to {:.0f} s: this wire cannot end the motion that is under "
      "way; to end it at once hold the machine and cut its power",
      std::ceil(left));
}

void SampleRecorder::end(const program::Run& run, Instant now) {
  next_ = now;
  look(run, now);
}

void SampleRecorder::look(const program::Run& run, Instant now) {
  if (run.phase() == program::Run::Phase::kOpening) return;
  if (samples_.empty()) start_ = now;
  if (!samples_.empty() && now < next_) return;
  next_ = now + kSamplePeriod;
  JointSample sample;
  sample.t = to_seconds(now - start_);
  sample.worst = worst_of(run.machine().positions());
  for (const JointPosition& position : run.machine().positions()) {
    const bool known = position.quality != PositionQuality::kLost;
    constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
    sample.q.push_back(known ? position.q : kNowhere);
    sample.within.push_back(known ? JointInterval{position.lower, position.upper}
                                  : JointInterval{kNowhere, kNowhere});
  }
  samples_.push_back(sample);
}

Json program_json(const ProgramReport& report) {
  const auto& [model, run, health, bytes, left_at_once, truth, now] = report;
  Json json{{"result", result_name(report)},
            {"predicted_s", run.plan().duration},
            {"predicted_min_s", run.plan().duration_min},
            {"homing_at_most_s", run.plan().homing_max},
            {"ran_s", ran_for(report)},
            {"notes", unheard_notes(run.plan(), model, "was")},
            {"orders_planned", run.plan().orders.size()},
            {"bytes_to_device", bytes.to_device},
            {"bytes_to_host", bytes.to_host},
            {"health", health_json(health)},
            {"orders", Json::array()}};
  for (const Record& record : run.records()) {
    Json order{
        {"line", record.order->line},
        {"last_line", record.order->last_line},
        {"round", record.order->round},
        {"command", command_text(record, model)},
        {"took_s", took(record)},
        {"positions", positions_json({record.reported.data(), record.reported.size()}, model)}};
    if (record.order->file != 0) {
      order["file"] = run.program().files[static_cast<std::size_t>(record.order->file)];
    }
    if (record.holds) order["holds"] = *record.holds;
    if (std::holds_alternative<MoveOrder>(record.order->what)) {
      order["commanded"] = joints_json({record.q.data(), record.q.size()}, model);
      order["predicted_s"] = record.duration;
      order["predicted_arrival_s"] = record.arrival;
    } else if (std::holds_alternative<program::HomeOrder>(record.order->what)) {
      order["at_most_s"] = record.duration;
    }
    json["orders"].push_back(order);
  }
  json["positions"] = positions_json(run.machine().positions(), model);
  if (const auto X_BT = tool_of(run, model)) json["pose"] = pose_json(X_BT->p, X_BT->R);
  json["goes_on_s"] = goes_on_for(report);
  json["notices"] = notices_json(run, model);
  json["notices_told"] = run.notices_told();
  if (truth) json["truth"] = truth_json(*truth, model);
  if (run.stopped_by()) json["stopped_by"] = control::stop_rule(*run.stopped_by()).name;
  if (run.failure()) {
    json["refusal"] = error_json(run.failure()->error, model);
    json["refusal"]["line"] = run.failure()->line;
    if (run.failure()->file != 0) {
      json["refusal"]["file"] = run.program().files[static_cast<std::size_t>(run.failure()->file)];
    }
  }
  return json;
}

std::string program_text(const ProgramReport& report) {
  const auto& [model, run, health, bytes, left_at_once, truth, now] = report;
  const auto records = run.records();
  std::string text;
  if (!records.empty()) {
    std::string names;
    for (const Joint& joint : model.joints) names += " " + joint.name;
    const std::string unit = joints_unit(model);
    Table table({"#", "line", "round", "order, " + unit, "then known, " + unit, "off", "known how",
                 "predicted s", "took s"});
    table.left(3).left(4).left(6);
    for (std::size_t i = 0; i < records.size(); ++i) {
      const Record& record = records[i];
      const auto error = largest_error(record, model);
      table.add(
          {fmt::format("{}", i + 1), lines_text(*record.order, run),
           fmt::format("{}/{}", record.order->round, record.order->rounds),
           command_text(record, model), reported_text(record, model),
           error ? number(*error, 3) : "",
           std::string(quality_name(worst_of({record.reported.data(), record.reported.size()}))),
           predicted_text(record), fmt::format("{:.2f}", took(record))});
    }
    text += fmt::format("\n  joints:{}\n\n{}\n", names, table.text());
  }
  text += fmt::format("  {}: {} of {} orders, {:.2f} s, {} bytes out, {} in\n", result_name(report),
                      records.size(), run.plan().orders.size(), ran_for(report), bytes.to_device,
                      bytes.to_host);
  if (run.phase() != program::Run::Phase::kDone) {
    text +=
        "  as far as is known it is at: " + standing_text(run.machine().positions(), model) + "\n";
  }
  if (const auto X_BT = tool_of(run, model)) {
    text += "  the tool is at\n" + pose_text(X_BT->p, X_BT->R) + "\n";
  }
  text += notices_text(run, model);
  if (health.retries + health.timeouts + health.unexpected > 0) {
    text +=
        fmt::format("  on the wire: {} retries, {} answers that never came, {} that fit nothing\n",
                    health.retries, health.timeouts, health.unexpected);
  }
  if (health.repeats > 0) {
    text += fmt::format("  on the wire: {} frames said again, as planned\n", health.repeats);
  }
  for (const std::string& note : unheard_notes(run.plan(), model, "was")) {
    text += "  note: " + note + "\n";
  }
  if (truth) text += "  where it really stands: " + truth_line(*truth, model) + "\n";
  return text;
}

std::string program_csv(const RobotModel& model, const std::vector<JointSample>& samples) {
  std::string csv = "t_s";
  for (const Joint& joint : model.joints) csv += "," + joint.name + "_" + shown_unit(joint);
  csv += ",quality";
  for (const Joint& joint : model.joints) {
    const char* unit = shown_unit(joint);
    csv += fmt::format(",{0}_lower_{1},{0}_upper_{1}", joint.name, unit);
  }
  csv += "\n";
  const auto value = [](double q, const Joint& joint) {
    return std::isfinite(q) ? fmt::format(",{:.6f}", shown_value(q, joint)) : std::string(",");
  };
  for (const JointSample& sample : samples) {
    csv += fmt::format("{:.6f}", sample.t);
    for (std::size_t i = 0; i < sample.q.size(); ++i) csv += value(sample.q[i], model.joints[i]);
    csv += fmt::format(",{}", quality_name(sample.worst));
    for (std::size_t i = 0; i < sample.within.size(); ++i) {
      csv += value(sample.within[i].lower, model.joints[i]);
      csv += value(sample.within[i].upper, model.joints[i]);
    }
    csv += "\n";
  }
  return csv;
}

std::string program_svg(const RobotModel& model, const std::vector<JointSample>& samples,
                        const std::string& title) {
  const std::string unit = joints_unit(model);
  Panel position{"position, " + unit, {}};
  Panel velocity{"velocity, " + unit + "/s", {}};
  std::vector<double> t;
  t.reserve(samples.size());
  for (const JointSample& sample : samples) t.push_back(sample.t);
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    position.curves.push_back({model.joints[i].name, {}});
    velocity.curves.push_back({model.joints[i].name, {}});
    std::size_t before = 0;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const double q = shown_value(samples[k].q[i], model.joints[i]);
      position.curves[i].values.push_back(q);
      // Readings come in steps; over a fifth of a second they make a speed.
      while (t[k] - t[before] > kVelocityWindow) ++before;
      const double dt = t[k] - t[before];
      const double last = shown_value(samples[before].q[i], model.joints[i]);
      velocity.curves[i].values.push_back(dt > 0 ? (q - last) / dt : 0);
    }
  }
  const bool guessed = std::ranges::any_of(samples, [](const JointSample& sample) {
    return sample.worst == PositionQuality::kUncertain;
  });
  constexpr const char* kGuessed = "; uncertain in part: best guesses, intervals in the CSV";
  return plot_svg(title + (guessed ? kGuessed : ""), t, {position, velocity});
}

}  // namespace sinew::cli
