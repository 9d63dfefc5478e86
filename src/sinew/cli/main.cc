// `sinew`: composition and text. Verbs live in their own files and return an Outcome.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <span>
#include <sstream>

#include "sinew/cli/cameras/camera_verb.h"
#include "sinew/cli/cameras/detect_verb.h"
#include "sinew/cli/cells/cell_verbs.h"
#include "sinew/cli/cells/commission_verb.h"
#include "sinew/cli/cells/convert_verb.h"
#include "sinew/cli/cells/device_verb.h"
#include "sinew/cli/cells/doctor_verb.h"
#include "sinew/cli/cells/record_verb.h"
#include "sinew/cli/cells/run_verb.h"
#include "sinew/cli/cells/serve_verb.h"
#include "sinew/cli/cells/servos_verb.h"
#include "sinew/cli/cells/sim_verb.h"
#include "sinew/cli/cells/teach_verb.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/verb.h"
#include "sinew/cli/plans/axis_verb.h"
#include "sinew/cli/plans/bullride_verb.h"
#include "sinew/cli/plans/check_verb.h"
#include "sinew/cli/plans/forward_verb.h"
#include "sinew/cli/plans/inverse_verb.h"
#include "sinew/cli/plans/jog_verb.h"
#include "sinew/cli/plans/plan_verb.h"
#include "sinew/cli/plans/robots_verb.h"
#include "sinew/cli/plans/torque_verb.h"
#include "sinew/core/spelling.h"
#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

const std::string kPorts = "serial device, tcp:HOST:PORT, spidev or simwire:unix:PATH";

/// The parts of one call: options land in the requests.
struct Call : ChosenVerb {
  std::string robot;
  ForwardRequest forward;
  InverseRequest inverse;
  SimRequest sim;
  RunRequest run;
  DoctorRequest doctor;
  DeviceRequest device;
  AxisRequest axis;
  PlanRequest plan;
  JogRequest jog;
  TorqueRequest torque;
  ServeRequest serve;
  RecordRequest record;
  CellRequest cell;
  CommissionRequest commission;
  TeachRequest teach;
  PointsRequest points;
  BullrideRequest ride;
  bool in_cell = false;  ///< `run` and `jog`: on a running cell
  CheckRequest check;
  FormatRequest format;
  ConvertRequest convert;
  DetectRequest detect;
  CameraRequest camera;
  ServosRequest servos;
};

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
  verb->add_option("--approach", request.approach,
                   "with --point-mm: x,y,z of the tool's direction, of any length; the forearm "
                   "rolls as it must");
  verb->add_option("--gripper-mm", request.gripper_mm,
                   "width between the jaws; open where left out");
  verb->add_option("--near-joints-deg", request.near_joints_deg,
                   "where the arm is: sorts the answers and settles free joints");
  verb->add_option("--near-pose-mm-deg", request.near_pose_mm_deg,
                   "hexapod: accepted for symmetry with fk; legs have one answer only");
  verb->callback([&call] { call.verb = [&call] { return inverse(call.inverse); }; });
}

/// @param options  has wire, profile and without
template <class Options>
void add_variant(CLI::App& verb, Options& options) {
  verb.add_option("--wire", options.wire,
                  "which of the robot's wires; as in its file where left out");
  verb.add_option("--profile", options.profile,
                  "which variant of its device; an unknown name lists them");
  verb.add_option("--without", options.without,
                  "joints whose boards are missing, by name or as J3, comma between; the others "
                  "can be used")
      ->delimiter(',');
}

void add_journal(CLI::App& verb, RobotOptions& robot) {
  verb.add_option("--journal", robot.journal,
                  "name of its position journal; the robot's id where left out, none for a "
                  "simulated port");
}

void add_settings(CLI::App& verb, RobotOptions& robot) {
  verb.add_option("--settings", robot.settings,
                  "what commissioning found: its file, or none; on a real port that of the state "
                  "folder where left out");
}

void add_time_scale(CLI::App& verb, RobotOptions& robot) {
  verb.add_option("--time-scale", robot.time_scale, "simulated device only: faster or slower");
}

void add_seed(CLI::App& verb, RobotOptions& robot) {
  verb.add_option("--seed", robot.seed, "simulated device only: of all its chance");
}

void add_sim(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "sim", "a robot's device, simulated behind a real port",
                            "sinew sim learm --profile bus --link /tmp/arm");
  SimRequest& request = call.sim;
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--link", request.link, "a name for the port, kept while the simulation runs");
  verb->add_option("--profile", request.profile,
                   "which variant of the device; an unknown name lists them");
  verb->add_option("--wire", request.wire,
                   "which of the robot's wires; as in its file where left out");
  verb->add_option("--simwire", request.simwire,
                   "boards on SPI: unix:PATH or stdio; a new socket where left out");
  verb->add_option("--slaves", request.slaves, "boards on SPI: how many are there");
  verb->add_option("--nss", request.nss,
                   "boards on SPI: hard, or soft for boards that always listen");
  verb->add_flag("--ready-high", request.ready_high,
                 "boards on SPI: READY never falls, as on measured boards");
  verb->add_option("--fault", request.fault,
                   "bad cables and blows, as in drop=0.001,flip=1e-4,cut@3s:500ms,supply=9V@5s");
  verb->add_option("--state", request.state,
                   "file that keeps where the joints are; each start is a power-up from there");
  verb->add_option("--seed", request.seed, "of all chance in the simulation");
  verb->add_option("--time-scale", request.time_scale, "the device's time against real time");
  verb->add_option("--log", request.log, "every byte both ways, with its time");
  verb->callback([&call] {
    call.verb = [&call] {
      call.sim.json = call.json;
      return simulate(call.sim);
    };
  });
}

void add_doctor(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "doctor", "what this computer offers, and what answers",
                            "sinew doctor --robot learm --port /dev/ttyUSB0");
  RobotOptions& robot = call.doctor.robot;
  verb->add_option("--robot", robot.name, "id or .toml file");
  verb->add_option("--port", robot.port, kPorts + "; asked questions that move nothing");
  add_variant(*verb, robot);
  add_journal(*verb, robot);
  add_settings(*verb, robot);
  verb->callback([&call] { call.verb = [&call] { return examine(call.doctor); }; });
}

void add_device(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "device", "what only one kind of device can be asked for",
                            "sinew device hexapod status --port /dev/ttyUSB0");
  DeviceRequest& request = call.device;
  verb->add_option("ROBOT", request.robot.name, "id or .toml file: the hexapod's or robot-arm-2's")
      ->required();
  verb->add_option(
          "ACTION", request.action,
          "hexapod: status, wake, kill (until its power is cut), jog (one leg, wherever "
          "it is); robot-arm-2: release (a latched emergency stop, nothing moves), test (each "
          "board of itself; a homed motor turns a full step and back)")
      ->required();
  verb->add_option("--port", request.robot.port, kPorts)->required();
  add_variant(*verb, request.robot);
  add_journal(*verb, request.robot);
  add_settings(*verb, request.robot);
  verb->add_option("--leg", request.leg, "jog: 1 to 6");
  verb->add_option("--steps", request.steps, "jog: microsteps, positive to lengthen the leg");
  add_time_scale(*verb, request.robot);
  verb->callback([&call] { call.verb = [&call] { return run_device_action(call.device); }; });
}

void add_plan(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(
      app, call, "plan", "a motion along a way, checked and timed; nothing moves",
      "sinew plan robot-arm-2 --from-joints 0,-30,-30,0,30,0 --to 400,150,300 --to 400,-150,300 "
      "--speed 80mm/s --plot plan.svg");
  PlanRequest& request = call.plan;
  verb->add_option("ROBOT", request.subject, "id or .toml file; or a program NAME.sinew")
      ->required();
  verb->add_option("--robot", request.robot, "of a program: id or .toml file");
  add_variant(*verb, request);
  verb->add_option("--to", request.to,
                   "x,y,z or x,y,z,rx,ry,rz: a straight line of the tool; joints=a,b,..: a joint "
                   "move; again for each further move")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb->add_option("--from-joints", request.from, "where it starts; home where left out");
  verb->add_option("--speed", request.speed,
                   "of the tool, as in 80mm/s; what it can where left out");
  verb->add_option("--blend", request.blend,
                   "how far from a corner the tool may leave its line, as in 10mm; a stop where "
                   "left out");
  verb->add_option("--plot", request.plot, "SVG file: joints against their limits, the tool's way");
  verb->add_option("--in-cell", request.cell, "CELL.toml: a dry run with its camera's picture");
  verb->callback([&call] { call.verb = [&call] { return plan(call.plan); }; });
}

/// Of verbs that work alone where nobody names a running cell.
void add_cell_options(CLI::App& verb, Call& call) {
  verb.add_flag("--cell", call.in_cell, "on a robot of the running cell, by its name there");
  verb.add_option("--socket", call.cell.socket, "the same, and where the cell answers");
}

bool on_cell(Call& call) {
  call.cell.json = call.json;
  return call.in_cell || call.cell.socket.has_value();
}

/// What a running cell does not hear must not seem to be heard.
std::expected<void, Outcome> check_heard(const CLI::App& verb,
                                         std::initializer_list<std::string_view> heard) {
  for (const CLI::Option* option : verb.get_options()) {
    const std::string name = option->get_name();
    const bool known = name == "--cell" || name == "--socket" || name == "--json" ||
                       std::ranges::find(heard, name) != heard.end();
    if (known || option->count() == 0) continue;
    return std::unexpected(
        bad_input(name + ": not in a running cell, where the cell's file and the robot's say so"));
  }
  return {};
}

void add_jog(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "jog",
                            "what a robot does while a stick is held, simulated; nothing moves",
                            "sinew jog robot-arm-2 --from-joints 160,30,-60,0,30,0 "
                            "--velocity=-50mm/s,-50mm/s,0 --time 10s --plot jog.svg");
  JogRequest& request = call.jog;
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
  add_cell_options(*verb, call);
  verb->callback([&call, verb] {
    call.verb = [&call, verb] {
      if (!on_cell(call)) return jog(call.jog);
      if (const auto fine = check_heard(*verb, {"ROBOT", "--frame", "--velocity", "--time"});
          !fine) {
        return fine.error();
      }
      call.cell.robot = call.jog.robot;
      call.cell.frame = call.jog.frame;
      call.cell.velocity = call.jog.velocity;
      call.cell.time = call.jog.time;
      return cell_jog(call.cell);
    };
  });
}

void add_axis(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "axis",
                            "how each axis answers a jump and follows a move, simulated with load",
                            "sinew axis robot-arm-2 --axis J2 --plot shoulder.svg");
  AxisRequest& request = call.axis;
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--axis", request.axis, "J1.. or its name; all where left out");
  verb->add_option("--step", request.step, "size of the jump, 1.5deg where left out");
  verb->add_option("--track", request.track, "length of the move, 40deg where left out");
  verb->add_option("--joints-deg", request.joints_deg, "where the arm stands; home where left out");
  verb->add_option("--payload-kg", request.payload, "at the tool; none where left out");
  verb->add_option("--plot", request.plot, "SVG file: step responses and tracking errors");
  verb->callback([&call] { call.verb = [&call] { return try_axis(call.axis); }; });
}

void add_run(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "run", "a program on a robot, or on its simulated device",
                            "sinew run robots/bigrobotarm/sequence.txt --robot bigrobotarm");
  RunRequest& request = call.run;
  verb->add_option("FILE", request.file, "the program")->required();
  RobotOptions& robot = request.robot;
  verb->add_option("--robot", robot.name, "id or .toml file")->required();
  verb->add_option("--port", robot.port, kPorts + "; a simulated device where left out");
  add_variant(*verb, robot);
  verb->add_option("--standing-at", request.standing_at,
                   "where a machine without sensors stands: home, lowered (legs), shown (as its "
                   "journal shows it), or a value per joint (deg, mm)");
  verb->add_option("--moved", request.moved,
                   "with --standing-at: who moved it; what was known does not count then");
  add_settings(*verb, robot);
  verb->add_option("--from-line", request.from_line,
                   "goes on from this row, planned from where the arm stands then");
  verb->add_option("--speed", request.speed,
                   "of all rows, 1% to 100%; through the feed where the device streams");
  add_journal(*verb, robot);
  add_seed(*verb, robot);
  verb->add_option("--record", request.record,
                   "NAME.csv: the joints over time; NAME.mcap: everything, for viewers, which is "
                   "else in the state folder (the newest 20 runs); none: nowhere");
  verb->add_option("--plot", request.plot, "SVG file: the same, drawn");
  verb->add_option("--log", request.log, "every byte both ways, with its time");
  add_time_scale(*verb, robot);
  verb->add_flag("--single-step", call.cell.single_step,
                 "in a running cell: a pause behind each order, until sinew step");
  add_cell_options(*verb, call);
  verb->callback([&call, verb] {
    call.verb = [&call, verb] {
      call.run.quiet = call.json;
      if (call.run.record == "none") {
        call.run.record.reset();
        call.run.recorded = false;
      }
      if (!on_cell(call)) {
        if (!call.cell.single_step) return run_program(call.run);
        return bad_input("--single-step: in a running cell (--cell), where sinew step goes on");
      }
      if (call.run.record) {
        return bad_input("--record: a running cell records by itself: sinew serve --record-folder");
      }
      if (const auto fine = check_heard(*verb, {"FILE", "--robot", "--standing-at", "--moved",
                                                "--from-line", "--speed", "--single-step"});
          !fine) {
        return fine.error();
      }
      call.cell.from_line = call.run.from_line;
      call.cell.speed = call.run.speed;
      call.cell.robot = call.run.robot.name;
      call.cell.file = call.run.file;
      call.cell.standing_at = call.run.standing_at;
      call.cell.moved = call.run.moved;
      return cell_run(call.cell);
    };
  });
}

void add_torque(CLI::App& app, Call& call) {
  CLI::App* verb =
      add_verb(app, call, "torque", "what each joint needs against what its motors and gear give",
               "sinew torque robot-arm-2 --payload-kg 1");
  TorqueRequest& request = call.torque;
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--payload-kg", request.payload_kg, "at the tool; none where left out");
  verb->add_option("--program", request.program, "a .sinew file: its peaks and means, from home");
  verb->add_option("--axis", request.axis,
                   "the joint to look at closely, J1.. or its name; the weakest where left out");
  verb->callback([&call] { call.verb = [&call] { return torque(call.torque); }; });
}

void add_record(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "record", "what is in the record of a run",
                            "sinew record run.mcap --csv run.csv");
  verb->add_option("FILE", call.record.file, "NAME.mcap")->required();
  verb->add_option("--csv", call.record.csv, "the same as a table: a row for each sample");
  verb->add_option("--pictures", call.record.pictures,
                   "a folder for what a program looked at, and what it decided by that");
  verb->callback([&call] { call.verb = [&call] { return show_record(call.record); }; });
}

void add_serve(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "serve", "runs a cell of robots, which others then steer",
                            "sinew serve my_cell.toml");
  verb->add_option("CELL", call.serve.file,
                   "a cell's .toml file; all five robots simulated where left out");
  verb->add_option("--socket", call.serve.socket,
                   "where it answers; the user's own place where left out");
  verb->add_option("--record-folder", call.serve.record_folder,
                   "each program that runs leaves a record there (MCAP, for viewers), or none; "
                   "the newest 20 in the state folder where left out");
  verb->add_option("--program-folder", call.serve.program_folder,
                   "where programs and points are kept, in a folder for each robot's id; the state "
                   "folder where left out");
  verb->add_flag("--realtime", call.serve.realtime,
                 "control threads come before everything else on this computer (SCHED_FIFO)");
  verb->add_flag("--demo", call.serve.demonstrate,
                 "simulated robots show what they can do, until somebody moves one");
  verb->add_flag("--demo-once", call.serve.shown_is_over, "the same, and ends when all was shown");
  WebDoorRequest& web = call.serve.web;
  verb->add_option("--listen", web.listen,
                   "where browsers reach it, HOST:PORT, or none; 127.0.0.1:8700 where left out");
  verb->add_option("--host", web.hosts, "HOST:PORT by which it may be called besides")
      ->allow_extra_args(false);
  verb->add_option("--tls-cert", web.tls_certificate, "certificate chain (PEM), for networks");
  verb->add_option("--tls-key", web.tls_key, "its private key (PEM)");
  verb->add_flag("--insecure-network", web.insecure_network,
                 "may listen beyond this machine without TLS: everybody on the way can read the "
                 "token, and then move the robots");
  verb->callback([&call] {
    call.verb = [&call] {
      call.serve.json = call.json;
      return serve(call.serve);
    };
  });
}

void add_commission(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "commission",
                            "a guided checklist for a robot's first day; also homing and recovery",
                            "sinew commission hexapod --port /dev/ttyUSB0");
  CommissionRequest& request = call.commission;
  RobotOptions& robot = request.robot;
  verb->add_option("ROBOT", robot.name, "id or .toml file")->required();
  verb->add_option("--port", robot.port, "as of run; a simulated device where left out");
  verb->add_option("--procedure", request.procedure, "commission, home or recover");
  add_variant(*verb, robot);
  verb->add_option("--answers", request.answers, "a file of STEP = ANSWER, instead of typing");
  verb->add_option("--save", request.save, "where the results go; the state folder where left out");
  verb->add_flag("--anew", request.anew, "asks again what was answered before");
  add_journal(*verb, robot);
  add_settings(*verb, robot);
  add_seed(*verb, robot);
  add_time_scale(*verb, robot);
  add_cell_options(*verb, call);
  verb->callback([&call, verb] {
    call.verb = [&call, verb] {
      call.commission.json = call.json;
      if (!on_cell(call)) return commission(call.commission);
      const auto heard = check_heard(*verb, {"ROBOT", "--answers", "--anew"});
      if (!heard) return heard.error();
      call.cell.robot = call.commission.robot.name;
      call.cell.answers = call.commission.answers;
      call.cell.anew = call.commission.anew;
      return cell_commission(call.cell);
    };
  });
}

void add_points(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "teach",
                            "where a robot of a running cell stands, or its way, for programs",
                            "sinew teach learm above_bin");
  verb->add_option("ROBOT", call.teach.robot, "its name in the cell")->required();
  verb->add_option("POINT", call.teach.point,
                   "what the place shall be called; of a platform also FILE.pos");
  verb->add_option("--way", call.teach.way,
                   "instead: the program NAME.sinew that its way until Ctrl-C becomes");
  verb->add_option("--points", call.teach.file, "its file; points.toml where left out");
  verb->add_flag("--replace", call.teach.replace,
                 "where there is a point, or a program, of that name already");
  verb->add_option("--socket", call.teach.socket,
                   "where the cell answers; the user's own place where left out");
  verb->callback([&call] {
    call.verb = [&call] {
      call.teach.quiet = call.json;
      return teach(call.teach);
    };
  });
  verb = add_verb(app, call, "points", "the taught points of a file", "sinew points points.toml");
  verb->add_option("FILE", call.points.file, "points.toml where left out");
  verb->callback([&call] { call.verb = [&call] { return show_points(call.points); }; });
}

Outcome ride_in_cell(Call& call) {
  const auto time = ride_time(call.ride.time);
  if (!time) return time.error();
  call.cell.robot = call.ride.robot;
  call.cell.seed = call.ride.seed;
  call.cell.ride_s = *time;
  call.cell.ride_amplitude = call.ride.amplitude;
  return cell_ride(call.cell);
}

void add_bullride(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "bullride",
                            "a program of random moves within reach and limits, on stdout",
                            "sinew bullride learm --time 30s --seed 7 > ride.sinew");
  BullrideRequest& request = call.ride;
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
  add_cell_options(*verb, call);
  verb->callback([&call, verb] {
    call.verb = [&call, verb] {
      if (!on_cell(call)) return bullride(call.ride);
      const auto fine = check_heard(*verb, {"ROBOT", "--time", "--seed", "--amplitude"});
      return fine ? ride_in_cell(call) : fine.error();
    };
  });
}

void add_check(CLI::App& app, Call& call) {
  CLI::App* verb =
      add_verb(app, call, "check", "everything but the motion: a verdict for each row of a program",
               "sinew check robots/learm/square.sinew --robot learm");
  CheckRequest& request = call.check;
  verb->add_option("FILE", request.file, "the program NAME.sinew")->required();
  verb->add_option("--robot", request.robot, "id or .toml file")->required();
  verb->add_option("--from-joints", request.from, "where it starts; home where left out");
  add_variant(*verb, request);
  verb->callback([&call] { call.verb = [&call] { return check_program(call.check); }; });
}

void add_format(CLI::App& app, Call& call) {
  CLI::App* verb = add_verb(app, call, "fmt", "lays out programs in their one form, in place",
                            "sinew fmt --check robots/learm/square.sinew");
  FormatRequest& request = call.format;
  verb->add_option("FILE", request.files, "programs NAME.sinew")->required();
  verb->add_flag("--check", request.only_look,
                 "only names those that are not laid out; exit 1 where there is one");
  verb->callback([&call] { call.verb = [&call] { return format_programs(call.format); }; });
}

/// A verb that declares its own options.
template <class Request>
void add_own(CLI::App* verb, Call& call, Request& request, Outcome (*act)(const Request&)) {
  declare_options(*verb, request);
  verb->callback([&call, &request, act] { call.verb = [&request, act] { return act(request); }; });
}

void add_convert(CLI::App& app, Call& call) {
  CLI::App* verb =
      add_verb(app, call, "convert", "programs and poses from and to the forms that others read",
               "sinew convert part.gcode part.sinew --robot maxarm");
  ConvertRequest& request = call.convert;
  verb->add_option("IN", request.in,
                   "NAME.sinew, .txt (BigRobotArm), .pos, .cfg (hexapod), .gcode .nc .ngc, .mcap")
      ->required();
  verb->add_option("OUT", request.out, "NAME.sinew, .txt or .pos; on stdout where left out");
  verb->add_option("--robot", request.robot, "id or .toml file")->required();
  verb->add_option("--from", request.from, "sinew, sequence, pos, config, gcode or record");
  verb->add_option("--to", request.to, "sinew, sequence or pos");
  verb->add_flag("--decimal-comma", request.comma,
                 "of a .pos file, for the old program on a PC whose country writes so");
  verb->add_flag("--replace", request.replace,
                 "a file OUT that is there already; what the journal NAME knows");
  verb->add_option("--journal", request.journal,
                   "of a .cfg: the position journal NAME takes its word over, as uncertain");
  verb->callback([&call] { call.verb = [&call] { return convert(call.convert); }; });
}

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
  Call call;
  app.add_flag("--json", call.json, "one JSON document on stdout, for machines");
  add_robots(app, call);
  add_forward(app, call);
  add_inverse(app, call);
  add_sim(app, call);
  add_run(app, call);
  add_doctor(app, call);
  add_device(app, call);
  add_servos(app, call, call.servos);
  add_plan(app, call);
  add_jog(app, call);
  add_axis(app, call);
  add_torque(app, call);
  add_serve(app, call);
  add_record(app, call);
  add_cell_verbs(app, call, call.cell);
  add_commission(app, call);
  add_points(app, call);
  add_bullride(app, call);
  add_check(app, call);
  add_format(app, call);
  add_convert(app, call);
  add_own(add_verb(app, call, "detect", "the coloured cubes in pictures of a table",
                   "sinew detect table.jpg --debug seen.png"),
          call, call.detect, detect);
  add_own(add_verb(app, call, "camera",
                   "boards to print, tags in images, and where cameras and tables are",
                   "sinew camera board --paper a4 > board.svg"),
          call, call.camera, camera);
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
