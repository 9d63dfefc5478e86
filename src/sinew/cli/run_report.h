#pragma once

#include "sinew/cli/outcome.h"
#include "sinew/model/robot_model.h"
#include "sinew/runtime/sequence_session.h"

namespace sinew::cli {

/// What a run did, order by order: commanded, reported, time, bytes.
Json run_json(const RobotModel& model, const sequence::Run& run, const runtime::SessionEnd& end);
std::string run_text(const RobotModel& model, const sequence::Run& run,
                     const runtime::SessionEnd& end);

/// t, q and qd of every sample, deg and deg/s, and whether they are the device's predicted profile
/// or what it reported.
std::string run_csv(const RobotModel& model, const sequence::Run& run);
std::string run_svg(const RobotModel& model, const sequence::Run& run, const std::string& title);

}  // namespace sinew::cli
