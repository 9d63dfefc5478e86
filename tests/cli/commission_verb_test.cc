#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "cli/process.h"
#include "support/scratch_folder.h"

/// `sinew commission`: the guided checklists on simulated devices, with scripted answers.
namespace sinew::test {
namespace {

constexpr const char* kBigRobotArm =
    "# a first day\n* = yes\nplace = home\ndirection.base = left\ndirection.shoulder = forward\n"
    "direction.elbow = forward\ndirection.wrist_rotate = left\ndirection.wrist = backward\n"
    "gripper_seen = closed\n";
constexpr const char* kMaxArm =
    "* = yes\nfirmware = arduino\ndirection.base = left\ndirection.shoulder = forward\n"
    "direction.forearm = up\nsuction_seen = held\n";
constexpr const char* kLeArm =
    "* = yes\ndirection.base = left\ndirection.shoulder = backward\ndirection.elbow = forward\n"
    "direction.wrist = other\ndirection.roll = left\nid.wrist = 9\nall_move = skip\n"
    "jaws_seen = shut\n"
    "trim.base = 2deg\ntrim.shoulder = skip\ntrim.elbow = skip\ntrim.wrist = skip\n"
    "trim.roll = skip\n";

class CommissionVerb : public ::testing::Test {
 protected:
  Arguments words(const std::string& robot, const std::string& script,
                  const Arguments& more = {}) const {
    Arguments arguments{
        "commission", robot,   "--json",       "--answers", folder.file("a.txt", script),
        "--save",     saved(), "--time-scale", "10"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  std::string saved() const { return folder.at("kept/found.json"); }
  ScratchFolder folder;
};

TEST_F(CommissionVerb, finds_the_joint_that_turns_against_the_model_and_keeps_it) {
  const Json answer = test::answer(words("bigrobotarm", kBigRobotArm));
  EXPECT_EQ(answer["phase"], "done");
  EXPECT_EQ(answer["settings"], Json({{"joint.wrist.turn", "other"}}));
  const Json file = Json::parse(text_of(saved()));
  EXPECT_EQ(file["robot"], "bigrobotarm");
  EXPECT_EQ(file["finished"], true);
  EXPECT_EQ(file["settings"]["joint.wrist.turn"], "other");
  // A later run uses it, and says so.
  const std::string program = folder.file("p.sinew", "joint base=2deg\n");
  const Json run = test::answer({"run", program, "--robot", "bigrobotarm", "--settings", saved(),
                                 "--time-scale", "10", "--json"});
  EXPECT_EQ(run["settings"], saved());
}

TEST_F(CommissionVerb, the_maxarm_is_as_its_file_says) {
  const Json answer = test::answer(words("maxarm", kMaxArm));
  EXPECT_EQ(answer["phase"], "done");
  EXPECT_TRUE(answer["settings"].empty());
}

TEST_F(CommissionVerb, a_servo_with_another_number_a_trim_and_a_wrong_sense_are_found) {
  const Json answer = test::answer(words("learm", kLeArm));
  EXPECT_EQ(answer["settings"]["joint.shoulder.turn"], "other");
  EXPECT_EQ(answer["settings"]["joint.wrist.servo_id"], "9");
  EXPECT_EQ(answer["settings"]["joint.base.trim_rad"], "0.034906585");
  EXPECT_EQ(answer["settings"]["jaws_turn"], "other") << "the kit whose jaws are shut there";
  EXPECT_EQ(answer["settings"].size(), 4U);
}

TEST_F(CommissionVerb, a_rehearsal_on_a_simulated_port_leaves_the_real_robots_settings) {
  setenv("XDG_STATE_HOME", folder.at("state").c_str(), 1);
  const std::string real = folder.at("state/sinew/commissioning/bigrobotarm.json");
  Process sim({"sim", "bigrobotarm", "--json"});
  const std::string port = Json::parse(sim.line_after(0)).at("port").get<std::string>();
  const Json answer = test::answer({"commission", "bigrobotarm", "--json", "--port", port,
                                    "--answers", folder.file("a.txt", kBigRobotArm)});
  unsetenv("XDG_STATE_HOME");
  EXPECT_EQ(answer["phase"], "done");
  EXPECT_EQ(answer["rehearsal"], true);
  EXPECT_TRUE(answer["file"].get<std::string>().ends_with("/bigrobotarm.simulated.json"));
  EXPECT_FALSE(std::filesystem::exists(real));
}

TEST_F(CommissionVerb, what_was_answered_is_kept_and_gone_on_with) {
  std::string half(kBigRobotArm);
  half.resize(half.find("direction.elbow"));
  const Ended first = sinew(words("bigrobotarm", half));
  EXPECT_EQ(first.exit, 1);
  EXPECT_NE(first.err.find("no answer for the step 'direction.elbow'"), std::string::npos)
      << first.err;
  const Json kept = Json::parse(text_of(saved()));
  EXPECT_EQ(kept["finished"], false);
  EXPECT_TRUE(kept["settings"].empty());
  EXPECT_EQ(kept["answers"]["direction.base"]["state"], "done");
  // The machine is asked where it stands again; the directions are known.
  const Json second = test::answer(
      words("bigrobotarm",
            "* = yes\nplace = home\ndirection.elbow = forward\ndirection.wrist_rotate = left\n"
            "direction.wrist = forward\ngripper_seen = closed\n"));
  EXPECT_EQ(second["phase"], "done");
  EXPECT_TRUE(second["settings"].empty());
}

TEST_F(CommissionVerb, wrong_answers_files_and_robots_are_told_in_a_sentence) {
  const auto fails = [&](const Arguments& arguments, int exit, const char* what) {
    const Ended ended = sinew(arguments);
    EXPECT_EQ(ended.exit, exit) << what;
    EXPECT_NE(ended.err.find(what), std::string::npos) << ended.err;
  };
  fails(words("bigrobotarm", "* = yes\nplace = there\n"), 1, "place: ");
  fails(words("bigrobotarm", "plaec = home\n"), 2, "did you mean 'place'?");
  fails(words("bigrobotarm", "home\n"), 2, "a.txt:1: 'home' is no answer");
  fails(words("puma560", "* = yes\n"), 1, "puma560");
  fails(words("bigrobotarm", "* = yes\n", {"--procedure", "dance"}), 2, "none of commission");
  fails(words("learm", "* = yes\n", {"--procedure", "home"}), 1, "sinew recover");
  fails({"commission", "maxarm", "--answers", folder.at("nothing.txt")}, 2, "nothing.txt");
  const std::string other = folder.file("other.json", R"({"version":1,"robot":"learm"})");
  fails({"commission", "maxarm", "--save", other}, 1, "another robot's");
  const std::string program = folder.file("p.sinew", "joint base=10deg\n");
  fails({"run", program, "--robot", "maxarm", "--settings", other}, 1, "another robot's");
  const std::string wrong = folder.file(
      "wrong.json",
      R"({"version":1,"robot":"maxarm","finished":true,"settings":{"joint.base.turn":"7"}})");
  fails({"run", program, "--robot", "maxarm", "--settings", wrong}, 1, "no setting of maxarm");
}

TEST_F(CommissionVerb, a_list_that_is_begun_again_and_broken_off_leaves_the_finished_one_counting) {
  test::answer(words("bigrobotarm", kBigRobotArm));
  const std::string program = folder.file("p.sinew", "joint base=2deg\n");
  std::string half(kBigRobotArm);
  half.resize(half.find("direction.elbow"));
  EXPECT_EQ(sinew(words("bigrobotarm", half)).exit, 1);
  const Json file = Json::parse(text_of(saved()));
  EXPECT_EQ(file["finished"], true);
  EXPECT_EQ(file["settings"], Json({{"joint.wrist.turn", "other"}}));
  EXPECT_EQ(file["under_way"]["direction.base"]["state"], "done");
  EXPECT_FALSE(file["under_way"].contains("direction.wrist"));
  const Json run = test::answer({"run", program, "--robot", "bigrobotarm", "--settings", saved(),
                                 "--time-scale", "10", "--json"});
  EXPECT_EQ(run["settings"], saved());
  EXPECT_NE(std::string(run["settings_note"]).find("begun and not finished"), std::string::npos);
  // The rest of it: what the other half had found counts no more.
  const Json whole = test::answer(
      words("bigrobotarm",
            "* = yes\nplace = home\ndirection.elbow = forward\ndirection.wrist_rotate = left\n"
            "direction.wrist = forward\ngripper_seen = closed\n"));
  EXPECT_TRUE(whole["settings"].empty());
  EXPECT_FALSE(Json::parse(text_of(saved())).contains("under_way"));
}

TEST_F(CommissionVerb, settings_of_a_list_that_was_never_finished_do_not_count) {
  const std::string program = folder.file("p.sinew", "joint base=2deg\n");
  const std::string half = folder.file(
      "half.json",
      R"({"version":1,"robot":"maxarm","finished":false,"settings":{"joint.base.turn":"other"}})");
  const Ended ended = sinew({"run", program, "--robot", "maxarm", "--settings", half});
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("was not finished"), std::string::npos) << ended.err;
}

TEST_F(CommissionVerb, only_its_own_settings_file_is_replaced_and_the_place_is_looked_at_first) {
  const auto fails = [&](const std::string& save, int exit, const char* what) {
    const Ended ended = sinew({"commission", "maxarm", "--answers", folder.file("a", kMaxArm),
                               "--save", save, "--anew", "--time-scale", "10"});
    EXPECT_EQ(ended.exit, exit) << ended.err;
    EXPECT_NE(ended.err.find(what), std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("Commissioning of"), std::string::npos) << "nothing has begun";
  };
  const std::string notes = folder.file("notes.txt", "my notes\n");
  fails(notes, 1, "only a settings file of this robot is replaced");
  EXPECT_EQ(text_of(notes), "my notes\n");
  const std::string other = folder.file("other.json", R"({"version":1,"robot":"learm"})");
  fails(other, 1, "another robot's");
  fails(".", 2, "is a folder; name a file in it, as in ./maxarm.json");
  fails(notes + "/found.json", 1, "--save: ");
}

TEST_F(CommissionVerb, a_servo_number_that_another_joint_has_is_refused) {
  const Ended ended =
      sinew(words("learm",
                  "* = yes\ndirection.base = left\ndirection.shoulder = backward\n"
                  "direction.elbow = forward\ndirection.wrist = other\ndirection.roll = left\n"
                  "id.wrist = 5\n"));
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("id.wrist: '5': is "), std::string::npos) << ended.err;
}

TEST_F(CommissionVerb, a_sequence_runs_with_the_settings_as_any_program_does) {
  test::answer(words("bigrobotarm", kBigRobotArm));
  const Json json = test::answer(
      {"run", folder.file("s.txt", "G0 B100\n"), "--robot", "bigrobotarm", "--settings", saved()});
  EXPECT_EQ(json["settings"], saved());
}

TEST_F(CommissionVerb, ctrl_c_stops_the_machine_and_keeps_what_was_said) {
  const Typed answers;
  Process process({"commission", "maxarm", "--save", saved()}, {.in = answers.in()});
  process.wait_for_err("supply");
  process.let_run(std::chrono::milliseconds(500));
  process.signal(SIGINT);
  const Ended ended = process.end();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("cancelled"), std::string::npos) << ended.err;
  EXPECT_EQ(Json::parse(text_of(saved()))["finished"], false);
}

TEST_F(CommissionVerb, answers_that_end_before_the_last_question_end_it_and_are_kept) {
  Typed answers;
  Process process({"commission", "maxarm", "--save", saved()}, {.in = answers.in()});
  answers.say("yes");
  answers.end();
  const Ended ended = process.end();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("the standard input ended before the last answer"), std::string::npos)
      << ended.err;
  const Json kept = Json::parse(text_of(saved()));
  EXPECT_EQ(kept["finished"], false);
  EXPECT_EQ(kept["answers"]["supply"]["state"], "done") << kept.dump();
}

TEST_F(CommissionVerb, recovery_of_a_lost_platform_is_by_hand_and_declared) {
  std::string script = "adjust.leg1 = 0.02mm\nadjust.leg1 = done\n";
  for (int leg = 2; leg <= 6; ++leg) script += "adjust.leg" + std::to_string(leg) + " = done\n";
  const Json answer =
      test::answer(words("hexapod", script + "place = lowered\n", {"--procedure", "recover"}));
  EXPECT_EQ(answer["phase"], "done");
  EXPECT_EQ(answer["steps"][0]["words"], "went +0.02 mm in all");
  EXPECT_EQ(answer["steps"][6]["words"], "declared");
  EXPECT_FALSE(answer.contains("file"));
}

}  // namespace
}  // namespace sinew::test
