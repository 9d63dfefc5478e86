#include <CLI/CLI.hpp>
#include <memory>

#include "sinew/cli/cells/cell_verbs.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

CLI::App* add_verb(CLI::App& app, ChosenVerb& call, const std::string& name,
                   const std::string& what, const std::string& example) {
  CLI::App* verb = app.add_subcommand(name, what);
  verb->add_flag("--json", call.json, "one JSON document on stdout, for machines");
  verb->footer("Example:\n  " + example + "\n");
  return verb;
}

namespace {

constexpr const char* kRobot = "its name in the cell";
constexpr const char* kAnswers = "a file of STEP = ANSWER, instead of typing";
constexpr const char* kTakeOver = "from whoever has the lease, which stops the robot first";

/// Verbs that ask something of a running cell.
class CellVerbs {
 public:
  CellVerbs(CLI::App& app, ChosenVerb& call) : app_(app), call_(call) {}

  void add_motion();
  void add_position();

 private:
  CLI::App* add_asking(const char* name, const char* what, const char* example,
                       Outcome (*answer)(const CellRequest&)) {
    CLI::App* verb = add_verb(app_, call_, name, what, example);
    verb->add_option("--socket", request_.socket,
                     "where the cell answers; the user's own place where left out");
    verb->callback([&call = call_, own = own_, answer] {
      call.verb = [&call, own, answer] {
        own->json = call.json;
        return answer(*own);
      };
    });
    return verb;
  }

  CLI::App& app_;
  ChosenVerb& call_;
  std::shared_ptr<CellRequest> own_ = std::make_shared<CellRequest>();
  CellRequest& request_ = *own_;
};

/// What moves, rests, and goes on.
void CellVerbs::add_motion() {
  CLI::App* verb =
      add_asking("status", "how the robots of a running cell are", "sinew status", cell_status);
  verb->add_option("ROBOT", request_.robot, "its name in the cell; all where left out");
  verb = add_asking("move", "one row of a program on a robot of a running cell",
                    "sinew move learm line x=200mm speed=50mm/s", cell_move);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_option("ROW", request_.row, "as in docs/programs.md")->required();
  verb->add_flag("--take-over", request_.take_over, kTakeOver);
  verb = add_asking("home", "a robot of a running cell finds its zeros, or goes home",
                    "sinew home arm", cell_home);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_option("--answers", request_.answers, kAnswers);
  verb->add_flag("--take-over", request_.take_over, kTakeOver);
  verb = add_asking("stop", "brings a robot of a running cell to rest, or all", "sinew stop",
                    cell_stop);
  verb->add_option("ROBOT", request_.robot, "its name in the cell; all where left out");
  verb = add_asking("pause", "a robot of a running cell rests on its path", "sinew pause arm",
                    cell_pause);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_flag("--guard", request_.guarded, "resumed with --take-over only");
  verb = add_asking("resume", "it goes on from there", "sinew resume arm", cell_resume);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_flag("--take-over", request_.take_over,
                 "also where another client guards the hold or has control");
  verb = add_asking("step", "the next order of the program that runs there, then a pause",
                    "sinew step arm --back", cell_step);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_flag("--back", request_.back, "back to where the last order began, and a pause there");
}

/// Where it is, and who has it.
void CellVerbs::add_position() {
  CLI::App* verb = add_asking(
      "recover", "acknowledges a fault, finds the device, and the way back to a position",
      "sinew recover platform --standing-at home", cell_recover);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_option("--standing-at", request_.standing_at,
                   "where it stands, from somebody who has looked: home, lowered (legs), shown, or "
                   "a value a joint");
  verb->add_option("--moved", request_.moved,
                   "why what was known of its place does not count any more: who moved it");
  verb->add_option("--answers", request_.answers, kAnswers);
  verb->add_flag("--take-over", request_.take_over, kTakeOver);
  verb =
      add_asking("stands", "where a robot of a running cell stands, from somebody who has looked",
                 "sinew stands big home --zero-counters", cell_stands);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_option("PLACE", request_.standing_at,
                   "home, lowered (legs), shown (as status shows it), or a value a joint")
      ->required();
  verb->add_option("--moved", request_.moved,
                   "why what was known of its place does not count any more: who moved it");
  verb->add_flag("--zero-counters", request_.zero_counters,
                 "the device's own counters read zero there, where it has such a command");
  verb->add_flag("--take-over", request_.take_over, kTakeOver);
  verb = add_asking("nudge", "one joint a little, slowly, from wherever it is",
                    "sinew nudge platform leg1 -0.2mm", cell_nudge);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_option("JOINT", request_.joint, "its name")->required();
  verb->add_option("WAY", request_.way, "as in 0.2mm or -1deg")->required();
  verb->add_flag("--until-probe", request_.until_probe,
                 "ends where the device's probe input closes, and says where that was");
  verb->add_flag("--take-over", request_.take_over, kTakeOver);
  verb = add_asking("free", "switches a robot's motors off, to guide the arm by hand",
                    "sinew free arm", cell_free);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_flag("--end", request_.ends, "the motors hold each joint where it is");
  verb->add_flag("--take-over", request_.take_over, kTakeOver);
  verb = add_asking("lease", "holds a robot of a running cell until Ctrl-C", "sinew lease arm",
                    cell_lease);
  verb->add_option("ROBOT", request_.robot, kRobot)->required();
  verb->add_flag("--take-over", request_.take_over, kTakeOver);
}

}  // namespace

void add_cell_verbs(CLI::App& app, ChosenVerb& call) {
  CellVerbs verbs(app, call);
  verbs.add_motion();
  verbs.add_position();
}

}  // namespace sinew::cli
