// `sinew`: composition and text. Verbs live in their own files and return an Outcome.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>

#include "sinew/cli/forward_verb.h"
#include "sinew/cli/inverse_verb.h"
#include "sinew/cli/robots_verb.h"
#include "sinew/cli/run_verb.h"
#include "sinew/cli/sim_verb.h"

namespace sinew::cli {
namespace {

/// The parts of one call: options land in the requests, the chosen verb in `verb`.
struct Call {
  bool json = false;
  std::function<Outcome()> verb;
  std::string robot;
  ForwardRequest forward;
  InverseRequest inverse;
  SimRequest sim;
  RunRequest run;
};

CLI::App* add_verb(CLI::App& app, Call& call, const std::string& name, const std::string& what,
                   const std::string& example) {
  CLI::App* verb = app.add_subcommand(name, what);
  verb->add_flag("--json", call.json, "one JSON document on stdout, for machines");
  verb->footer("Example:\n  " + example + "\n");
  return verb;
}

void add_robots(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "robots", "the robots that Sinew knows, or all about one",
                            "sinew robots learm");
  verb->add_option("ROBOT", call.robot, "id or .toml file; all built-in ones where left out");
  verb->callback([&call] {
    call.verb = [&call] { return call.robot.empty() ? list_robots() : show_robot(call.robot); };
  });
}

void add_forward(CLI::App& app, Call& call) {
  CLI::App* verb =
      add_verb(app, call, "fk", "forward kinematics: where the tool is at given joints",
               "sinew fk learm --joints-deg 0,90,0,0,0");
  ForwardRequest& request = call.forward;
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--joints-deg", request.joints_deg, "one angle a joint: a,b,...");
  verb->add_option("--legs-mm", request.legs_mm, "hexapod: six lengths, anchor to anchor");
  verb->add_option("--near-pose-mm-deg", request.near_pose_mm_deg,
                   "hexapod: the last pose x,y,z,rx,ry,rz; home where left out");
  verb->add_option("--gripper-mm", request.gripper_mm,
                   "width between the jaws; open where left out");
  verb->add_flag("--frames", request.frames, "the DH table and every link's matrix");
  verb->callback([&call] { call.verb = [&call] { return forward(call.forward); }; });
}

void add_inverse(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "ik", "inverse kinematics: all joints that reach a target",
                            "sinew ik learm --point-mm 200,0,20");
  InverseRequest& request = call.inverse;
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--pose-mm-deg", request.pose_mm_deg,
                   "x,y,z,rx,ry,rz of the tool; rotation about fixed axes x, y, z");
  verb->add_option("--point-mm", request.point_mm, "x,y,z of the tool's tip");
  verb->add_option("--pitch-deg", request.pitch_deg,
                   "with --point-mm: tool from straight up (90 level, 180 down); chosen where left "
                   "out");
  verb->add_option("--gripper-mm", request.gripper_mm,
                   "width between the jaws; open where left out");
  verb->add_option("--near-joints-deg", request.near_joints_deg,
                   "where the arm is: sorts the answers and settles free joints");
  verb->add_option("--near-pose-mm-deg", request.near_pose_mm_deg,
                   "hexapod: accepted for symmetry with fk; legs have one answer only");
  verb->callback([&call] { call.verb = [&call] { return inverse(call.inverse); }; });
}

void add_sim(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "sim", "a robot's device, simulated behind a real port",
                            "sinew sim bigrobotarm --link /tmp/arm");
  SimRequest& request = call.sim;
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--link", request.link, "a name for the port, kept while the simulation runs");
  verb->add_option("--time-scale", request.time_scale, "the device's time against real time");
  verb->add_option("--log", request.log, "every byte both ways, with its time");
  verb->callback([&call] {
    call.verb = [&call] {
      call.sim.json = call.json;
      return simulate(call.sim);
    };
  });
}

void add_run(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "run", "a program on a robot, or on its simulated device",
                            "sinew run robots/bigrobotarm/sequence.txt --robot bigrobotarm");
  RunRequest& request = call.run;
  verb->add_option("FILE", request.file, "the program")->required();
  verb->add_option("--robot", request.robot, "id or .toml file")->required();
  verb->add_option("--port", request.port, "serial device; the simulated device where left out");
  verb->add_option("--wire", request.wire, "byte or text; as in the robot's file where left out");
  verb->add_option("--record", request.record, "CSV file: t, q, qd of every sample");
  verb->add_option("--plot", request.plot, "SVG file: the same, drawn");
  verb->add_option("--log", request.log, "every byte both ways, with its time");
  verb->add_option("--time-scale", request.time_scale, "simulated device only: faster or slower");
  verb->callback([&call] {
    call.verb = [&call] {
      call.run.quiet = call.json;
      return run_program(call.run);
    };
  });
}

int print(const Outcome& outcome, bool json) {
  const std::string text = json ? outcome.json.dump(2) + "\n" : outcome.text;
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
  if (!outcome.complaint.empty()) std::fprintf(stderr, "sinew: %s\n", outcome.complaint.c_str());
  return static_cast<int>(outcome.exit);
}

int run(int argc, char** argv) {
  CLI::App app{"Sinew: one controller for the robot arms that people build themselves"};
  app.require_subcommand(1);
  app.set_version_flag("--version", SINEW_VERSION);
  app.footer(
      "Try:\n  sinew robots\n  sinew fk learm --joints-deg 0,90,0,0,0\n"
      "  sinew VERB --help shows an example of each verb.\n");
  Call call;
  add_robots(app, call);
  add_forward(app, call);
  add_inverse(app, call);
  add_sim(app, call);
  add_run(app, call);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "sinew: %s; sinew --help shows the way\n", error.what());
    return static_cast<int>(ExitCode::kBadInput);
  }
  return print(call.verb(), call.json);
}

}  // namespace
}  // namespace sinew::cli

int main(int argc, char** argv) {
  return sinew::cli::run(argc, argv);
}
