// Verbs that work by themselves, and with --cell on a robot of a running cell.
#include "sinew/cli/cells/jog_and_ride.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "sinew/cli/cells/in_cell.h"
#include "sinew/cli/output/verb_options.h"
#include "sinew/cli/plans/bullride_verb.h"
#include "sinew/cli/plans/jog_verb.h"

namespace sinew::cli {

void add_jog(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<WithCell<JogRequest>>();
  JogRequest& request = own->request;
  CLI::App* verb = add_verb(app, call, "jog",
                            "what a robot does while a stick is held, simulated; nothing moves",
                            "sinew jog robot-arm-2 --from-joints 160,30,-60,0,30,0 "
                            "--velocity=-50mm/s,-50mm/s,0 --time 10s --plot jog.svg");
  verb->add_option("ROBOT", request.robot, "id or .toml file; with --cell its name there")
      ->required();
  verb->add_option("--frame", request.frame, "joint, base, tool or platform; base where left out");
  verb->add_option("--velocity", request.velocity,
                   "of the tool x,y,z and turns about them, as in 20mm/s,0,0 or "
                   "20mm/s,0,0,0,0,5deg/s; of joints one a joint")
      ->required();
  verb->add_option("--time", request.time,
                   "how long it is held; 3s where left out, with --cell 1s");
  verb->add_option("--from-joints", request.from,
                   "where it starts; home where left out, with --cell where it stands");
  verb->add_flag("--touch", request.contact, "without looking for contact with itself or a table");
  verb->add_option("--plot", request.plot,
                   "SVG file: every joint against its limits, the tool's way");
  add_cell_options(*verb, *own);
  verb->callback([&call, own, verb] {
    call.verb = [&call, own, verb] {
      if (!on_cell(*own, call)) return jog(own->request);
      if (const auto fine = check_heard(*verb, {"ROBOT", "--frame", "--velocity", "--time"});
          !fine) {
        return fine.error();
      }
      own->cell.robot = own->request.robot;
      own->cell.frame = own->request.frame;
      own->cell.velocity = own->request.velocity;
      own->cell.time = own->request.time;
      return cell_jog(own->cell);
    };
  });
}

namespace {

Outcome ride_in_cell(CellRequest& cell, const BullrideRequest& ride) {
  const auto time = ride_time(ride.time);
  if (!time) return time.error();
  cell.robot = ride.robot;
  cell.seed = ride.seed;
  cell.ride_s = *time;
  cell.ride_amplitude = ride.amplitude;
  return cell_ride(cell);
}

}  // namespace

void add_bullride(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<WithCell<BullrideRequest>>();
  BullrideRequest& request = own->request;
  CLI::App* verb = add_verb(app, call, "bullride",
                            "a program of random moves within reach and limits, on stdout",
                            "sinew bullride learm --time 30s --seed 7 > ride.sinew");
  verb->add_option("ROBOT", request.robot, "id or .toml file; with --cell its name there")
      ->required();
  verb->add_option("--time", request.time, "of the ride, 30s where left out");
  verb->add_option("--seed", request.seed, "one seed, one ride");
  verb->add_option(
      "--amplitude", request.amplitude,
      "share of the joints' ranges, as in 20%, of legs also 0.02mm; as the wire allows where "
      "left out");
  verb->add_option("--from-joints", request.from, "where it begins and ends; home where left out");
  verb->add_option("--wire", request.wire,
                   "which of the robot's wires; as in its file where left out");
  verb->add_option("--profile", request.profile,
                   "which variant of its device; an unknown name lists them");
  add_cell_options(*verb, *own);
  verb->callback([&call, own, verb] {
    call.verb = [&call, own, verb] {
      if (!on_cell(*own, call)) return bullride(own->request);
      const auto fine = check_heard(*verb, {"ROBOT", "--time", "--seed", "--amplitude"});
      return fine ? ride_in_cell(own->cell, own->request) : fine.error();
    };
  });
}

}  // namespace sinew::cli
