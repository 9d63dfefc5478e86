#include "sinew/cli/run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/plot_svg.h"
#include "sinew/cli/table.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/program/sequence_samples.h"

namespace sinew::cli {
namespace {

using sequence::MoveOrder;
using sequence::Record;

constexpr double kSamplePeriod = 0.01;  // s

std::string angles_text(const BigRobotArmAngles& q) {
  std::string text;
  for (const double angle : q)
    text += fmt::format("{}{}", text.empty() ? "" : " ", number(to_deg(angle), 2));
  return text;
}

std::string words_text(const sequence::Words& words) {
  std::string text;
  for (const std::int32_t word : words) text += fmt::format("{}{}", text.empty() ? "" : " ", word);
  return text;
}

/// What an order asked for, as people read it.
std::string commanded_text(const sequence::Order& order) {
  if (const auto* move = std::get_if<MoveOrder>(&order.what)) {
    return (move->home ? "home " : "move ") + angles_text(move->q_asked);
  }
  if (const auto* speeds = std::get_if<sequence::SpeedsOrder>(&order.what)) {
    return "speeds " + words_text(speeds->multipliers);
  }
  if (const auto* accelerations = std::get_if<sequence::AccelerationsOrder>(&order.what)) {
    return "accelerations " + words_text(accelerations->multipliers);
  }
  if (const auto* gripper = std::get_if<sequence::GripperOrder>(&order.what)) {
    return gripper->enabled ? fmt::format("gripper {}", gripper->position) : "gripper off";
  }
  return "here is zero";
}

double took(const Record& record) {
  return to_seconds(record.done - record.asked);
}

const MoveOrder* move_of(const Record& record) {
  return std::get_if<MoveOrder>(&record.order->what);
}

double largest_error(const MoveOrder& move, const Record& record) {
  double largest = 0;
  for (std::size_t i = 0; i < move.q.size(); ++i) {
    largest = std::max(largest, std::abs(record.q_reported[i] - move.q_asked[i]));
  }
  return largest;
}

const char* result_name(const sequence::Run& run, const runtime::SessionEnd& end) {
  if (end.left_at_once) return "left";
  switch (run.phase()) {
    case sequence::Run::Phase::kDone:
      return "done";
    case sequence::Run::Phase::kStopped:
      return "stopped";
    default:
      return "failed";
  }
}

kinematics::PoseBT tool_at(const RobotModel& model, const BigRobotArmAngles& q) {
  const auto& geometry = std::get<SerialGeometry>(model.geometry);
  return kinematics::SerialArm(geometry, model.joints, kinematics::tool_pose(geometry)).forward(q);
}

}  // namespace

Json run_json(const RobotModel& model, const sequence::Run& run, const runtime::SessionEnd& end) {
  Json json{{"result", result_name(run, end)},
            {"counts_from_power_up", run.looked_like_boot()},
            {"predicted_s", run.plan().duration},
            {"orders_planned", run.plan().orders.size()},
            {"bytes_to_device", end.total.to_device},
            {"bytes_to_host", end.total.to_host},
            {"orders", Json::array()}};
  const auto records = run.records();
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Record& record = records[i];
    Json order{{"line", record.order->line},
               {"round", record.order->round},
               {"command", commanded_text(*record.order)},
               {"took_s", took(record)},
               {"bytes_to_device", end.bytes[i].to_device},
               {"bytes_to_host", end.bytes[i].to_host}};
    if (const MoveOrder* move = move_of(record)) {
      order["commanded_deg"] = joints_json(move->q_asked, model);
      order["reported_deg"] = joints_json(record.q_reported, model);
      order["predicted_s"] = move->duration;
    }
    json["orders"].push_back(order);
  }
  if (!records.empty()) {
    const auto X_BT = tool_at(model, records.back().q_reported);
    json["pose"] = pose_json(X_BT.p, X_BT.R);
    json["joints_deg"] = joints_json(records.back().q_reported, model);
    json["took_s"] = to_seconds(records.back().done - records.front().asked);
  }
  if (run.failure()) {
    json["refusal"] = error_json(run.failure()->error, model);
    json["refusal"]["line"] = run.failure()->line;
  }
  return json;
}

std::string run_text(const RobotModel& model, const sequence::Run& run,
                     const runtime::SessionEnd& end) {
  const auto records = run.records();
  if (records.empty()) return "";
  std::string names;
  for (const Joint& joint : model.joints) names += " " + joint.name;
  Table table({"#", "line", "round", "commanded, deg", "reported, deg", "off deg", "predicted s",
               "took s", "bytes out", "in"});
  table.left(3).left(4);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Record& record = records[i];
    const MoveOrder* move = move_of(record);
    table.add({fmt::format("{}", i + 1), fmt::format("{}", record.order->line),
               fmt::format("{}/{}", record.order->round, record.order->rounds),
               commanded_text(*record.order), move ? angles_text(record.q_reported) : "as asked",
               move ? number(to_deg(largest_error(*move, record))) : "",
               move ? fmt::format("{:.3f}", move->duration) : "",
               fmt::format("{:.3f}", took(record)), fmt::format("{}", end.bytes[i].to_device),
               fmt::format("{}", end.bytes[i].to_host)});
  }
  std::string text = fmt::format("\n  joints:{}\n\n{}", names, table.text());
  const double time = to_seconds(records.back().done - records.front().asked);
  const auto X_BT = tool_at(model, records.back().q_reported);
  text += fmt::format(
      "\n  {}: {} of {} orders, {:.2f} s of motion predicted, {:.2f} s taken, {} bytes out, {} in\n"
      "  The device reports targets, never live positions; the tool is now at\n{}",
      result_name(run, end), records.size(), run.plan().orders.size(), run.plan().duration, time,
      end.total.to_device, end.total.to_host, pose_text(X_BT.p, X_BT.R));
  return text;
}

std::string run_csv(const RobotModel& model, const sequence::Run& run) {
  std::string csv = "t_s";
  for (const Joint& joint : model.joints) csv += "," + joint.name + "_deg";
  for (const Joint& joint : model.joints) csv += "," + joint.name + "_deg_s";
  csv += ",source\n";
  for (const auto& sample : sequence::sample(run.records(), kSamplePeriod)) {
    csv += fmt::format("{:.6f}", sample.t);
    for (const double q : sample.q) csv += fmt::format(",{:.6f}", to_deg(q));
    for (const double qd : sample.qd) csv += fmt::format(",{:.6f}", to_deg(qd));
    csv += sample.predicted ? ",predicted\n" : ",reported\n";
  }
  return csv;
}

std::string run_svg(const RobotModel& model, const sequence::Run& run, const std::string& title) {
  Panel position{"position, deg", {}};
  Panel velocity{"velocity, deg/s", {}};
  for (const Joint& joint : model.joints) {
    position.curves.push_back({joint.name, {}});
    velocity.curves.push_back({joint.name, {}});
  }
  std::vector<double> t;
  for (const auto& sample : sequence::sample(run.records(), kSamplePeriod)) {
    t.push_back(sample.t);
    for (std::size_t i = 0; i < sample.q.size(); ++i) {
      position.curves[i].values.push_back(to_deg(sample.q[i]));
      velocity.curves[i].values.push_back(to_deg(sample.qd[i]));
    }
  }
  return plot_svg(title, t, {position, velocity});
}

}  // namespace sinew::cli
