#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/planning/studies/torque_study.h"
#include "sinew/program/plans/program_load.h"

namespace sinew::cli {

/// One joint, with the payload that was asked for.
struct JointTorque {
  planning::JointNeed need;
  std::optional<double> fails_from;          ///< kg, moving as the file allows
  std::optional<double> fails_from_at_rest;  ///< kg
};

/// The joint that is looked at closely, with one payload.
struct PayloadRow {
  double payload = 0;  ///< kg
  planning::JointNeed need;
  std::optional<double> acceleration;  ///< rad/s^2 of this joint alone, from rest, that first fails
  std::optional<double> reach;         ///< m from the base's axis, where it first fails
};

/// All that is to be told about a robot's torque.
struct TorqueReport {
  TorqueReport(const RobotModel& robot, const planning::TorqueStudy& of_robot)
      : model(robot), study(of_robot) {}

  const RobotModel& model;
  const planning::TorqueStudy& study;
  double payload = 0;        ///< kg
  double reach_max = 0;      ///< m
  double step_rate_max = 0;  ///< microsteps/s; 0 where nobody knows
  std::vector<JointTorque> joints;
  std::size_t weakest = 0;
  bool chosen = false;  ///< by the user, not by its need
  std::vector<PayloadRow> rows;
  std::vector<std::string> assumed_masses;  ///< names of links
  std::size_t masses = 0;
  std::string program;  ///< its file; empty where none was given
  double program_duration = 0;
  std::vector<program::JointLoad> loads;
};

Json torque_json(const TorqueReport& report);
std::string torque_text(const TorqueReport& report);

}  // namespace sinew::cli
