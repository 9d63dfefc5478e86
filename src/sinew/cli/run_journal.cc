#include "sinew/cli/run_journal.h"

#include "sinew/config/points_file.h"
#include "sinew/control/machine_identity.h"
#include "sinew/core/spelling.h"
#include "sinew/runtime/program_session.h"
#include "sinew/runtime/robot_driver.h"
#include "sinew/runtime/robot_link.h"

namespace sinew::cli {
namespace {

std::optional<std::string> journal_name(const RunRequest& request, const RobotModel& model) {
  if (request.journal) return request.journal;
  if (!request.port || runtime::may_be_simulated(*request.port)) return std::nullopt;
  return model.id;
}

}  // namespace

std::expected<std::unique_ptr<runtime::PositionRecord>, Outcome> open_journal(
    const RunRequest& request, const RobotModel& model) {
  const auto name = journal_name(request, model);
  if (!name) return nullptr;
  if (request.journal && !is_point_name(*name)) {
    return std::unexpected(bad_input(
        "--journal: '" + printable(*name) +
        "' is no name for one; a name is a letter and then letters, digits, - and _, 40 at most"));
  }
  const auto folder = runtime::positions_folder();
  if (!folder) return std::unexpected(could_not(folder.error().sentence));
  auto opened = runtime::PositionRecord::open(*folder, *name, model);
  if (!opened) return std::unexpected(could_not(opened.error().sentence));
  return std::move(*opened);
}

runtime::ControlLoop recorded_loop(const RobotModel& robot, Driver& driver, const io::Clock& clock,
                                   runtime::PositionRecord* record) {
  auto settings = runtime::session_settings(clock, runtime::opening_of(robot).limit);
  if (record == nullptr) return {robot, driver, settings, {}, nullptr};
  settings.journal = control::journal_settings(robot);
  return {robot, driver, settings, record->start(), &record->pump()};
}

}  // namespace sinew::cli
