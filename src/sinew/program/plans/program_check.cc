#include "sinew/program/plans/program_check.h"

#include <algorithm>

namespace sinew::program {

bool CheckedProgram::fine() const {
  const auto good = [](const RowVerdict& row) {
    return row.kind == RowVerdict::Kind::kFine || row.kind == RowVerdict::Kind::kNothing;
  };
  return !broken_off && std::ranges::all_of(rows, good);
}

CheckedProgram check(const Program& program, const RobotModel& robot, const Standing& start,
                     const Homing& homing, const WayLook& look) {
  CheckedProgram checked;
  checked.rows.resize(program.steps.size());
  OrderPlanner planner(robot, start, homing);
  planner.judge(checked.rows);
  if (look) planner.show_to(look);
  checked.broken_off = planner.take_all(program);
  checked.duration_min = planner.plan().duration_min;
  checked.duration_max = planner.plan().duration;
  checked.homing_max = planner.plan().homing_max;
  return checked;
}

}  // namespace sinew::program
