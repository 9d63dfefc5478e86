#include "sinew/cli/plans/torque_report.h"

#include <fmt/format.h>

#include <cmath>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"

namespace sinew::cli {
namespace {

using planning::DriveTrain;
using planning::JointNeed;
using planning::RatioAnswer;

bool slides(const TorqueReport& report, std::size_t i) {
  return report.model.joints[i].slides();
}
/// The heading of a column: of what turns, of what slides, or of both.
std::string of_kind(const TorqueReport& report, const char* turning, const char* sliding) {
  if (prismatic_joints(report.model) == 0) return turning;
  return all_slide(report.model) ? sliding : fmt::format("{} or {}", turning, sliding);
}
/// As text and as the end of a JSON key.
std::string load_unit(const TorqueReport& report) {
  return of_kind(report, "Nm", "N");
}
std::string load_key(const TorqueReport& report, std::size_t i, const char* name) {
  return fmt::format("{}_{}", name, slides(report, i) ? "n" : "nm");
}
const char* way_unit(const TorqueReport& report, std::size_t i) {
  return shown_unit(report.model.joints[i]);
}

/// A number with three digits that count.
std::string rough(double value) {
  const double size = std::abs(value);
  if (size < 5e-4) return "0";
  return fmt::format("{:.{}f}", value, size >= 99.95 ? 0 : size >= 9.995 ? 1 : size >= 1 ? 2 : 3);
}

std::string first(const std::optional<double>& value, double factor = 1) {
  return value ? rough(*value * factor) : "never";
}

/// A spindle's ratio reads as its lead.
std::string ratio_text(const TorqueReport& report, std::size_t i, double ratio) {
  return slides(report, i) ? rough(to_mm(2 * kPi / ratio)) + " mm" : rough(ratio);
}

/// Joint speed that is left with a ratio, where the steps do not suffice for the file's.
std::optional<double> slower(const TorqueReport& report, std::size_t i,
                             const std::optional<RatioAnswer>& answer) {
  if (!answer || !answer->lowest || !answer->highest_for_speed) return std::nullopt;
  if (*answer->lowest <= *answer->highest_for_speed) return std::nullopt;
  return report.study.drive(i).velocity_at(report.step_rate_max, *answer->lowest);
}

std::string ratio_cell(const TorqueReport& report, std::size_t i,
                       const std::optional<RatioAnswer>& answer) {
  if (!answer) return "-";
  if (!answer->lowest) return "none";
  const auto speed = slower(report, i, answer);
  return ratio_text(report, i, *answer->lowest) +
         (speed ? fmt::format(" ({} {}/s)", rough(shown_value(*speed, report.model.joints[i])),
                              way_unit(report, i))
                : "");
}

/// Stall torque of a servo that would do, at the speed of its hardest moment.
double stall_that_does(const DriveTrain& drive, const JointNeed& need) {
  const double left = 1 - std::abs(need.duty.velocity) / drive.servo()->no_load_speed;
  return need.demand / left;
}

std::string margin_verdict(const TorqueReport& report, std::size_t i, double margin) {
  if (margin < 1) return "fails";
  const bool stepper = report.study.drive(i).stepper() != nullptr;
  if (stepper && margin < planning::kTorqueReserve) return "does, with less than the reserve";
  return "does";
}

std::string verdict(const TorqueReport& report, std::size_t i, const JointNeed& need) {
  if (need.weight > need.holding) return "cannot hold its weight";
  return margin_verdict(report, i, need.margin());
}

std::string drives_text(const TorqueReport& report) {
  const std::string unit = load_unit(report);
  if (report.study.drive(0).servo() != nullptr) {
    Table table({"axis", "servo stalls at " + unit, "top speed deg/s", "gives " + unit + " there"});
    for (std::size_t i = 0; i < report.joints.size(); ++i) {
      const double top = report.model.joints[i].velocity_max;
      table.add({report.model.joints[i].name, rough(report.study.drive(i).available(0)),
                 rough(to_deg(top)), rough(report.study.drive(i).available(top))});
    }
    return table.text();
  }
  Table table({"axis", "motor Nm", "motors", of_kind(report, "ratio", "lead"), "efficiency",
               "gives " + unit, fmt::format("top speed {}/s", of_kind(report, "deg", "mm")),
               "gives " + unit + " there"});
  for (std::size_t i = 0; i < report.joints.size(); ++i) {
    const StepperDrive& drive = *report.study.drive(i).stepper();
    const double top = report.model.joints[i].velocity_max;
    table.add({report.model.joints[i].name, number(drive.holding_torque),
               fmt::format("{}", drive.motors), ratio_text(report, i, drive.gear_ratio),
               number(drive.gear_efficiency), rough(report.study.drive(i).available(0)),
               number(shown_value(top, report.model.joints[i]), 4),
               rough(report.study.drive(i).available(top))});
  }
  return table.text();
}

std::string needs_text(const TorqueReport& report) {
  const bool servos = report.study.drive(0).servo() != nullptr;
  const std::string unit = load_unit(report);
  std::vector<std::string> head{"axis", "weight " + unit, "moving " + unit, "gives " + unit,
                                "margin"};
  if (servos) {
    head.push_back("stall " + unit + " that does");
  } else {
    head.push_back(of_kind(report, "ratio", "lead") + " that does");
    head.emplace_back("with the reserve");
  }
  head.emplace_back("fails from kg");
  head.emplace_back("at rest from kg");
  head.emplace_back("verdict");
  Table table(head);
  table.left(head.size() - 1);
  for (std::size_t i = 0; i < report.joints.size(); ++i) {
    const JointTorque& joint = report.joints[i];
    const JointNeed& need = joint.need;
    std::vector<std::string> row{report.model.joints[i].name, rough(need.weight),
                                 rough(need.demand), rough(need.available), rough(need.margin())};
    if (servos) {
      row.push_back(rough(stall_that_does(report.study.drive(i), need)));
    } else {
      row.push_back(ratio_cell(report, i, need.ratio));
      row.push_back(ratio_cell(report, i, need.ratio_with_reserve));
    }
    row.push_back(first(joint.fails_from));
    row.push_back(first(joint.fails_from_at_rest));
    row.push_back(verdict(report, i, need));
    table.add(row);
  }
  return table.text();
}

std::string pose_text(const JointVector& q, const TorqueReport& report) {
  std::string text;
  for (std::size_t i = 0; i < q.size(); ++i) {
    text += (i == 0 ? "" : " ") + number(shown_value(q[i], report.model.joints[i]), 1);
  }
  return text;
}

std::string poses_text(const TorqueReport& report) {
  const std::string unit = joints_unit(report.model);
  Table table({"axis", "heaviest at, " + unit, "hardest to move at, " + unit});
  table.left(1).left(2);
  for (std::size_t i = 0; i < report.joints.size(); ++i) {
    const JointNeed& need = report.joints[i].need;
    table.add({report.model.joints[i].name, pose_text(need.q_weight, report),
               pose_text(need.q_demand, report)});
  }
  return table.text();
}

std::string reach_cell(const std::optional<double>& reach) {
  if (!reach) return "nowhere";
  return *reach < 1e-3 ? "everywhere" : number(to_mm(*reach), 0);
}

std::string rows_text(const TorqueReport& report) {
  const std::size_t i = report.weakest;
  const bool servo = report.study.drive(i).servo() != nullptr;
  const std::string unit = load_unit(report);
  std::vector<std::string> head{"payload kg",
                                "weight " + unit,
                                "moving " + unit,
                                "margin",
                                fmt::format("alone fails from {}/s2", way_unit(report, i)),
                                "fails from reach mm"};
  head.push_back(servo ? "stall " + unit + " that does"
                       : (slides(report, i) ? "lead that does" : "ratio that does"));
  if (!servo) head.emplace_back("with the reserve");
  Table table(head);
  for (const PayloadRow& row : report.rows) {
    std::vector<std::string> cells{
        number(row.payload),
        rough(row.need.weight),
        rough(row.need.demand),
        rough(row.need.margin()),
        row.acceleration ? rough(shown_value(*row.acceleration, report.model.joints[i])) : "never",
        reach_cell(row.reach)};
    if (servo) {
      cells.push_back(rough(stall_that_does(report.study.drive(i), row.need)));
    } else {
      cells.push_back(ratio_cell(report, i, row.need.ratio));
      cells.push_back(ratio_cell(report, i, row.need.ratio_with_reserve));
    }
    table.add(cells);
  }
  return table.text();
}

std::string program_text(const TorqueReport& report) {
  const std::string unit = load_unit(report);
  Table table({"axis", "peak " + unit, "gives " + unit, "margin", "in line", "at s", "rms " + unit,
               "verdict"});
  table.left(7);
  for (std::size_t i = 0; i < report.loads.size(); ++i) {
    const program::JointLoad& load = report.loads[i];
    if (load.line == 0) continue;
    table.add({report.model.joints[i].name, rough(load.peak), rough(load.available),
               rough(load.margin()), fmt::format("{}", load.line), number(load.time, 2),
               rough(load.rms), margin_verdict(report, i, load.margin())});
  }
  return fmt::format(
      "  {}, {} s as the device takes it; times count its motions as their limits "
      "allow, homing and the wire aside:\n\n{}\n",
      report.program, number(report.program_duration, 2), table.text());
}

std::string close_text(const TorqueReport& report) {
  const JointTorque& joint = report.joints[report.weakest];
  const JointNeed& bare = report.rows.front().need;
  const std::string name = report.model.joints[report.weakest].name;
  const std::string unit = load_unit(report);
  std::string text =
      fmt::format("  J{} {}{}: where its {} {} first fail\n\n{}\n", report.weakest + 1, name,
                  report.chosen ? "" : ", the first that a payload is too much for",
                  rough(bare.holding), unit, rows_text(report));
  const Joint& weakest = report.model.joints[report.weakest];
  text += fmt::format(
      "  alone: this joint from rest, while the others stand\n"
      "  moving means all joints at the file's top speed and, this one, {} {}/s2; {}",
      number(shown_value(weakest.acceleration_max, weakest)), way_unit(report, report.weakest),
      joint.fails_from && *joint.fails_from > 0
          ? fmt::format("so it fails from {} kg", rough(*joint.fails_from))
      : joint.fails_from ? "so it fails without payload"
                         : "so it never fails");
  if (joint.fails_from_at_rest) {
    text += fmt::format(", at rest from {} kg", rough(*joint.fails_from_at_rest));
  }
  const double others = bare.demand - bare.duty.torque;
  const double heavier = (bare.available - others) / bare.duty.torque;
  if (heavier > 1 && bare.duty.torque > 0) {
    text += fmt::format(
        "\n  without payload it would fail if all links weighed {} times what the file says",
        rough(heavier));
  }
  return text + "\n";
}

std::string notes_text(const TorqueReport& report) {
  std::string text;
  if (report.step_rate_max > 0) {
    text += fmt::format(
        "  a ratio with a speed behind it is too much for {} steps/s: that is all the joint does\n",
        number(report.step_rate_max));
  }
  if (report.study.drive(0).stepper() != nullptr) {
    text += fmt::format("  the reserve: motors give {} times what is needed\n",
                        number(planning::kTorqueReserve));
  }
  if (!report.assumed_masses.empty()) {
    text += fmt::format("  {} of {} masses are assumed: {}\n", report.assumed_masses.size(),
                        report.masses, joined(report.assumed_masses, ", "));
  }
  return text;
}

Json optional_json(const std::optional<double>& value, double factor = 1) {
  return value ? Json(*value * factor) : Json(nullptr);
}

Json need_json(const TorqueReport& report, std::size_t i, const JointNeed& need) {
  const std::string pose = std::string("_") + joints_key(report.model);
  Json json{{load_key(report, i, "weight"), need.weight},
            {"heaviest_at" + pose, joints_json(need.q_weight, report.model)},
            {load_key(report, i, "demand"), need.demand},
            {load_key(report, i, "available"), need.available},
            {"hardest_at" + pose, joints_json(need.q_demand, report.model)},
            {"margin", need.margin()}};
  if (report.study.drive(i).servo() != nullptr) {
    json["stall_that_does_nm"] = stall_that_does(report.study.drive(i), need);
  }
  const auto put = [&](const char* name, const std::optional<RatioAnswer>& answer) {
    if (!answer) return;
    json[name] = optional_json(answer->lowest);
    if (const auto speed = slower(report, i, answer)) {
      json[fmt::format("{}_velocity_{}_s", name, way_unit(report, i))] =
          shown_value(*speed, report.model.joints[i]);
    }
  };
  const bool legs = slides(report, i);
  put(legs ? "ratio_that_does_rad_m" : "ratio_that_does", need.ratio);
  put(legs ? "ratio_with_reserve_rad_m" : "ratio_with_reserve", need.ratio_with_reserve);
  if (need.ratio && need.ratio->highest_for_speed) {
    json["ratio_max_for_speed"] = *need.ratio->highest_for_speed;
  }
  return json;
}

}  // namespace

Json torque_json(const TorqueReport& report) {
  const RobotModel& model = report.model;
  Json json{{"robot", model.id},
            {"payload_kg", report.payload},
            {"reach_mm", to_mm(report.reach_max)},
            {"assumed_masses", report.assumed_masses},
            {"masses", report.masses},
            {"joints", Json::array()}};
  for (std::size_t i = 0; i < report.joints.size(); ++i) {
    const JointTorque& joint = report.joints[i];
    Json one{{"joint", model.joints[i].name}};
    if (const StepperDrive* drive = report.study.drive(i).stepper()) {
      one["motor_holding_torque_nm"] = drive->holding_torque;
      one["motors"] = drive->motors;
      one[slides(report, i) ? "gear_ratio_rad_m" : "gear_ratio"] = drive->gear_ratio;
      one["gear_efficiency"] = drive->gear_efficiency;
    }
    one[load_key(report, i, "holding")] = joint.need.holding;
    one.update(need_json(report, i, joint.need));
    one["fails_from_kg"] = optional_json(joint.fails_from);
    one["fails_at_rest_from_kg"] = optional_json(joint.fails_from_at_rest);
    one["verdict"] = verdict(report, i, joint.need);
    json["joints"].push_back(one);
  }
  Json close{{"joint", model.joints[report.weakest].name}, {"payloads", Json::array()}};
  for (const PayloadRow& row : report.rows) {
    Json one{{"payload_kg", row.payload}};
    one.update(need_json(report, report.weakest, row.need));
    one[fmt::format("fails_from_{}_s2", way_unit(report, report.weakest))] =
        optional_json(row.acceleration, shown_value(1, model.joints[report.weakest]));
    one["fails_from_reach_mm"] = optional_json(row.reach, to_mm(1));
    close["payloads"].push_back(one);
  }
  json["closely"] = close;
  if (!report.loads.empty()) {
    Json list = Json::array();
    for (std::size_t i = 0; i < report.loads.size(); ++i) {
      const program::JointLoad& load = report.loads[i];
      if (load.line == 0) continue;
      list.push_back({{"joint", model.joints[i].name},
                      {load_key(report, i, "peak"), load.peak},
                      {load_key(report, i, "available"), load.available},
                      {"margin", load.margin()},
                      {"line", load.line},
                      {"at_s", load.time},
                      {load_key(report, i, "rms"), load.rms},
                      {"verdict", margin_verdict(report, i, load.margin())}});
    }
    json["program"] = {{"file", report.program},
                       {"duration_s", report.program_duration},
                       {"at_s_counts", "motions by their limits"},
                       {"joints", list}};
  }
  return json;
}

std::string torque_text(const TorqueReport& report) {
  std::string text = fmt::format(
      "  {}: payload {} kg at the tool, which reaches {} mm\n\n  what the motors give\n\n{}\n",
      report.model.title, number(report.payload), number(to_mm(report.reach_max), 0),
      drives_text(report));
  text += fmt::format("  what the robot needs, at its worst\n\n{}\n{}\n", needs_text(report),
                      poses_text(report));
  text += close_text(report) + "\n";
  if (!report.loads.empty()) text += program_text(report);
  return text + notes_text(report);
}

}  // namespace sinew::cli
