// `sinew`: composition and text. Verbs live in their own files and return an Outcome.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <span>
#include <sstream>

#include "sinew/cli/boards/firmware_verb.h"
#include "sinew/cli/cameras/camera_verb.h"
#include "sinew/cli/cameras/detect_verb.h"
#include "sinew/cli/cells/cell_verbs.h"
#include "sinew/cli/cells/commission_verb.h"
#include "sinew/cli/cells/convert_verb.h"
#include "sinew/cli/cells/device_verb.h"
#include "sinew/cli/cells/doctor_verb.h"
#include "sinew/cli/cells/jog_and_ride.h"
#include "sinew/cli/cells/record_verb.h"
#include "sinew/cli/cells/run_verb.h"
#include "sinew/cli/cells/serve_verb.h"
#include "sinew/cli/cells/sim_verb.h"
#include "sinew/cli/cells/teach_verb.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/verb.h"
#include "sinew/cli/plans/check_verb.h"
#include "sinew/cli/plans/forward_verb.h"
#include "sinew/cli/plans/inverse_verb.h"
#include "sinew/cli/plans/plan_verb.h"
#include "sinew/cli/plans/robots_verb.h"
#include "sinew/cli/plans/torque_verb.h"
#include "sinew/core/spelling.h"
#include "sinew/devices/axis/axis_verb.h"
#include "sinew/devices/feetech/feetech_verb.h"
#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

/// In the order of the help.
constexpr void (*kVerbs[])(CLI::App& app, ChosenVerb& call) = {
    add_robots,     add_forward,    add_inverse, add_sim,      add_run,      add_doctor, add_device,
    add_servos,     add_plan,       add_jog,     add_axis,     add_torque,   add_serve,  add_record,
    add_cell_verbs, add_commission, add_teach,   add_points,   add_bullride, add_check,  add_format,
    add_convert,    add_detect,     add_camera,  add_firmware,
};

/// The first word where a verb is due, if any.
std::string_view verb_word(std::span<char*> arguments) {
  for (const std::string_view argument : arguments) {
    if (!argument.starts_with('-')) return argument;
  }
  return {};
}

/// What CLI11 says about values, as a sentence.
std::string value_sentence(const CLI::ParseError& error) {
  std::string what = error.what();
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    return what.substr(0, what.find(':')) + ": takes one value, once";
  }
  const std::size_t equals = what.find(" = ");
  constexpr std::string_view kPrefix = "Could not convert: ";
  if (!what.starts_with(kPrefix) || equals == std::string::npos) return what;
  return what.substr(kPrefix.size(), equals - kPrefix.size()) + ": '" +
         printable(what.substr(equals + 3)) + "' is not a number";
}

/// A sentence for what the parser threw, which knows less about verbs than people need.
std::string parse_sentence(const CLI::App& app, const CLI::ParseError& error,
                           std::span<char*> arguments) {
  constexpr std::size_t kLongest = 300;  // bytes; an argument can have thousands
  std::vector<std::string_view> verbs;
  std::vector<std::string> names;
  for (const CLI::App* verb : app.get_subcommands({})) names.push_back(verb->get_name());
  verbs.assign(names.begin(), names.end());
  const std::string_view word = verb_word(arguments);
  if (std::find(verbs.begin(), verbs.end(), word) == verbs.end()) {
    const std::string known = "the verbs are " + joined(verbs, ", ") + "; sinew --help shows more";
    if (word.empty()) return "a verb is missing; " + known;
    const std::string_view meant = nearest_spelling(word, verbs);
    return "there is no verb '" + printable(word) + "'" +
           (meant.empty() ? "" : ", did you mean '" + std::string(meant) + "'?") + "; " + known;
  }
  std::string sentence = value_sentence(error);
  if (sentence.size() > kLongest) sentence = sentence.substr(0, kLongest) + " ...";
  return sentence + "; sinew " + std::string(word) + " --help shows the way";
}

/// Asked for JSON, however wrong the rest is.
bool wants_json(std::span<char*> arguments) {
  return std::ranges::any_of(arguments,
                             [](std::string_view argument) { return argument == "--json"; });
}

int run(std::span<char*> arguments) {
  CLI::App app{"Sinew: one controller for the robot arms that people build themselves", "sinew"};
  app.require_subcommand(1);
  app.set_version_flag("--version", SINEW_VERSION);
  app.footer(
      "Try:\n  sinew robots\n  sinew fk learm --joints-deg 0,90,0,0,0\n"
      "  sinew VERB --help shows an example of each verb.\n");
  ChosenVerb call;
  app.add_flag("--json", call.json, "one JSON document on stdout, for machines");
  for (const auto add : kVerbs) add(app, call);
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& error) {
    const bool json = wants_json(arguments);
    if (error.get_exit_code() != 0) {
      return print(bad_input(parse_sentence(app, error, arguments)), json);
    }
    std::ostringstream help;
    app.exit(error, help, help);
    Outcome outcome;
    outcome.json = {{"help", help.str()}};
    outcome.text = help.str();
    return print(outcome, json);
  }
  call.json = call.json || wants_json(arguments);
  const Outcome outcome = call.verb();
  const int code = print(outcome, call.json);
  if (outcome.at_once) {
    std::fflush(nullptr);
    std::_Exit(code);
  }
  return code;
}

}  // namespace
}  // namespace sinew::cli

int main(int argc, char** argv) {
  using namespace sinew;
  io::hold_standard_streams();
  const std::span<char*> arguments(argv + std::min(argc, 1), argv + argc);  // argv may be empty
  try {
    return cli::run(arguments);
  } catch (const std::exception& error) {
    return cli::print(
        cli::could_not(std::string("a fault of Sinew itself, please report it: ") + error.what()),
        cli::wants_json(arguments));
  }
}
