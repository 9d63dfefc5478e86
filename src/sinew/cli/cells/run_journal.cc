#include "sinew/cli/cells/run_journal.h"

#include "sinew/cli/cells/local_cell.h"

namespace sinew::cli {

std::expected<std::unique_ptr<runtime::PositionRecord>, Outcome> open_journal(
    const std::string& name, const RobotModel& model) {
  if (const auto fine = check_journal_name(name); !fine) return std::unexpected(fine.error());
  const auto folder = runtime::positions_folder();
  if (!folder) return std::unexpected(could_not(folder.error().sentence));
  auto opened = runtime::PositionRecord::open(*folder, name, model);
  if (!opened) return std::unexpected(could_not(opened.error().sentence));
  return std::move(*opened);
}

}  // namespace sinew::cli
