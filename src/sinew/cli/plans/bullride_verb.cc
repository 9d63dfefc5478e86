#include "sinew/cli/plans/bullride_verb.h"

#include <fmt/format.h>

#include <cmath>

#include "sinew/cli/output/device_argument.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/plan_report.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/core/error_code.h"
#include "sinew/core/quantity.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/bullride.h"
#include "sinew/runtime/links/robot_variant.h"

namespace sinew::cli {

std::expected<double, Outcome> ride_time(const std::optional<std::string>& text) {
  const auto time = parse_quantity(text.value_or("30s"), Measure::kTime, UnitRule::kOptional);
  if (!time) return std::unexpected(bad_input("--time: " + time.error()));
  if (!(*time >= program::kRideMin && *time <= program::kRideMax)) {
    return std::unexpected(bad_input("--time: a ride takes 1 s to 1 h"));
  }
  return *time;
}

namespace {

/// Of legs; 0 where joints turn.
double stroke_of(const RobotModel& model) {
  const Joint& leg = model.joints[0];
  const bool legs = std::holds_alternative<HexapodGeometry>(model.geometry);
  return legs ? leg.upper - leg.lower : 0;
}

/// A share of the joints' ranges, and of legs how far that is to either side.
std::string amplitude_text(double share, const RobotModel& model) {
  const std::string text = fmt::format("{:.2g}%", 100 * share);
  const double stroke = stroke_of(model);
  return stroke > 0 ? fmt::format("{:.2g}mm", to_mm(share * stroke / 2)) : text;
}

}  // namespace

std::expected<double, Outcome> ride_amplitude(const std::optional<std::string>& text,
                                              double stroke) {
  if (!text) return 0.0;
  if (const auto length = parse_quantity(*text, Measure::kLength, UnitRule::kRequired);
      length && stroke > 0) {
    if (*length > 0 && *length <= stroke / 2) return 2 * *length / stroke;
    return std::unexpected(bad_input(fmt::format("--amplitude: of legs above 0 and at most {} mm",
                                                 number(to_mm(stroke / 2), 3))));
  }
  const auto share = parse_quantity(*text, Measure::kShare, UnitRule::kOptional);
  if (!share) return std::unexpected(bad_input("--amplitude: " + share.error()));
  if (!(*share > 0 && *share <= 1)) {
    return std::unexpected(bad_input("--amplitude: has to be above 0 and at most 100%"));
  }
  return *share;
}

Outcome bullride(const BullrideRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const auto variant = runtime::variant_of(file->model, request.profile, request.wire);
  if (!variant) return bad_input(variant.error());
  const RobotModel& model = *variant;
  if (const auto fine = check_seed(request.seed); !fine) return fine.error();
  const auto time = ride_time(request.time);
  if (!time) return time.error();
  const auto amplitude = ride_amplitude(request.amplitude, stroke_of(model));
  if (!amplitude) return amplitude.error();
  JointVector q = home_joints(model);
  if (request.from) {
    const auto given = parse_joints("--from-joints", *request.from, model);
    if (!given) return bad_input(given.error());
    q = *given;
  }
  const program::RideOrder order{
      .duration = *time, .seed = static_cast<std::uint64_t>(request.seed), .amplitude = *amplitude};
  const auto ride = program::make_ride(model, q, order);
  if (!ride) {
    const Error& error = ride.error().error;
    const bool too_long = error.code == ErrorCode::kRideTime;
    const double fits = too_long ? program::fitting_ride(model, q, order) : 0;
    return could_not(error_text(error, model) +
                     (too_long ? fmt::format("; --amplitude {} fits, or --time {:.0f}s",
                                             amplitude_text(fits, model), std::ceil(error.measured))
                               : std::string()));
  }
  Outcome outcome;
  outcome.json = {{"robot", model.id},
                  {"seed", request.seed},
                  {"moves", ride->moves},
                  {"duration_s", ride->duration},
                  {"amplitude", ride->amplitude},
                  {"program", ride->text}};
  outcome.text = fmt::format(
      "# {} moves in {:.1f} s with {:.4g} % of the joints' ranges{}, seed {}, for {}.\n{}",
      ride->moves, ride->duration, 100 * ride->amplitude,
      stroke_of(model) > 0 ? ": each leg " + amplitude_text(ride->amplitude, model) + " to a side"
                           : "",
      request.seed, model.id, ride->text);
  return outcome;
}

}  // namespace sinew::cli
