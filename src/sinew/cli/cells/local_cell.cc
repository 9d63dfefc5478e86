#include "sinew/cli/cells/local_cell.h"

#include <utility>

#include "sinew/cli/cells/cell_connection.h"
#include "sinew/cli/output/device_argument.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/config/points_file.h"
#include "sinew/core/spelling.h"
#include "sinew/io/interrupt.h"
#include "sinew/runtime/links/robot_variant.h"

namespace sinew::cli {
namespace {

constexpr Duration kTurn = std::chrono::milliseconds(20);

}  // namespace

bool is_real(const std::optional<std::string>& port) {
  return !runtime::may_be_simulated(port);
}

std::expected<void, Outcome> check_journal_name(const std::optional<std::string>& name) {
  if (!name || is_point_name(*name)) return {};
  return std::unexpected(bad_input(
      "--journal: '" + printable(*name) +
      "' is no name for one; a name is a letter and then letters, digits, - and _, 40 at most"));
}

std::expected<ChosenRobot, Outcome> choose_robot(const RobotOptions& options) {
  const auto file = find_robot(options.name);
  if (!file) return std::unexpected(file.error());
  auto variant = runtime::variant_of(file->model, options.profile, options.wire, options.without);
  if (!variant) return std::unexpected(bad_input(variant.error()));
  const bool real = is_real(options.port);
  if (const auto fine = check_seed(options.seed); !fine) return std::unexpected(fine.error());
  if (const auto fine = check_time_scale(options.time_scale); !fine) {
    return std::unexpected(fine.error());
  }
  if (options.time_scale != 1 && real) {
    return std::unexpected(bad_input("--time-scale: a real port keeps real time"));
  }
  if (const auto fine = check_journal_name(options.journal); !fine) {
    return std::unexpected(fine.error());
  }
  auto settings = use_commissioning(*variant, options.settings, real);
  if (!settings) return std::unexpected(settings.error());
  return ChosenRobot{std::move(*variant), std::move(*settings)};
}

std::expected<std::unique_ptr<LocalCell>, Outcome> LocalCell::start(const RobotModel& robot,
                                                                    const RobotOptions& where,
                                                                    LocalCellOptions options) {
  if (where.journal || where.port) {
    auto positions = runtime::positions_folder();
    const bool needed = where.journal || is_real(where.port);
    if (!positions && needed) return std::unexpected(could_not(positions.error().sentence));
    options.folders.journal = positions.value_or("");
  }
  CellRobot place;
  place.name = robot.id;
  place.robot = robot.id;
  place.profile = where.profile;
  place.port = where.port;
  place.journal = where.journal;
  place.seed = static_cast<std::uint64_t>(where.seed);
  Cell cell{.title = robot.title,
            .time_scale = where.time_scale,
            .robots = {std::move(place)},
            .objects = {},
            .cameras = {},
            .baskets = {},
            .cubes = {}};
  std::unique_ptr<LocalCell> local(new LocalCell());
  auto running = runtime::RunningCell::start(std::move(cell), {robot}, options.folders,
                                             [&](runtime::StationOptions& station) {
                                               station.byte_log = options.byte_log;
                                               station.assumes_start = options.assumes_start;
                                             });
  if (!running) {
    return std::unexpected(
        could_not(running.error().sentence + (where.port ? held_by_cell(*where.port) : "")));
  }
  local->running_ = std::move(*running);
  if (const std::string trouble = local->station().trouble(); !trouble.empty()) {
    return std::unexpected(could_not(trouble + held_by_cell(*where.port)));
  }
  auto client = runtime::StationClient::make(local->station(), kClient);
  if (!client) return std::unexpected(could_not("too many clients control this robot"));
  local->client_ = std::move(*client);
  return local;
}

void LocalCell::turn() {
  client_->refresh();
  while (client_->take_event()) {
  }
  renew();
}

control::ControlEvent LocalCell::carry_out(const control::CommandWhat& what) {
  client_->refresh();
  const std::uint32_t id = client_->give(what);
  bool stopped = false;
  while (true) {
    renew();
    client_->refresh();
    while (const auto event = client_->take_event()) {
      if (event->command == id && control::is_end(event->kind)) return *event;
    }
    if (io::interrupts() > 0 && !stopped) {
      // Some devices latch a stop, and nothing moves while one is opened.
      const bool opening = client_->state() == control::MachineState::kEnabling;
      client_->give(opening ? control::CommandWhat{control::Disable{}} : control::Stop{});
    }
    stopped = io::interrupts() > 0;
  }
}

std::optional<Error> LocalCell::enable() {
  for (const control::CommandWhat& what :
       {control::CommandWhat{control::TakeLease{}}, control::CommandWhat{control::Enable{}}}) {
    const control::ControlEvent end = carry_out(what);
    if (end.kind == control::ControlEvent::Kind::kDone) continue;
    // A fault that is latched says more than that a command is refused in it.
    const auto latched = client_->latched();
    return latched ? latched->error : end.error;
  }
  return std::nullopt;
}

std::string LocalCell::sentence(const Error& error) const {
  const RobotModel& model = station().robot();
  const std::string trouble = station().trouble();
  return station().port_name() + ": " +
         (trouble.empty()
              ? error_text(error, model) + silence_hint(model, error, station().view().health)
              : trouble);
}

void LocalCell::renew() {
  client_->keep_lease(real_.now());
  station().wait_for_cycle(kTurn);
}

void abandon(std::unique_ptr<LocalCell> cell) {
  // Its end would wait for the machine to come to rest.
  (void)cell.release();
}

}  // namespace sinew::cli
