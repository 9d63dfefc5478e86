#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iostream>
#include <map>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/program/language/conditions.h"
#include "sinew/program/plans/program_check.h"
#include "support/property.h"
#include "support/robots.h"

/// `call`, `if` and waits for something: what is read of them, and what a plan knows.
namespace sinew::program {
namespace {

using Folder = std::map<std::string, std::string, std::less<>>;

std::expected<Program, std::vector<Complaint>> read(std::string_view text,
                                                    const Folder& folder = {},
                                                    std::string_view robot = "puma560") {
  Surroundings around;
  around.load = [&](std::string_view name) -> std::expected<CalledFile, std::string> {
    const auto found = folder.find(name);
    if (found == folder.end()) return std::unexpected(std::string(name) + ".sinew: no such file");
    return CalledFile{found->first + ".sinew", found->second};
  };
  return parse(text, "main.sinew", test::robot(robot), around);
}

std::vector<std::string> complaints(std::string_view text, const Folder& folder = {}) {
  const auto program = read(text, folder);
  std::vector<std::string> lines;
  if (program) return lines;
  for (const Complaint& one : program.error()) lines.push_back(to_text(one));
  return lines;
}

constexpr double kHome[] = {0, 20, -70, 0, 60, 0};  // deg, away from singularities

JointVector home() {
  JointVector q;
  for (const double value : kHome) q.push_back(from_deg(value));
  return q;
}

std::expected<Plan, Refusal> planned(std::string_view text, const Folder& folder = {}) {
  const auto program = read(text, folder);
  if (!program) {
    ADD_FAILURE() << to_text(program.error().front());
    return Plan{};
  }
  return make_plan(*program, test::robot("puma560"), home());
}

TEST(Calls, rows_of_a_called_program_stand_where_it_is_called) {
  const Folder folder{{"grip", "wait 1s\nloop 2\n  wait 2s\nend\n"},
                      {"both", "call grip\ncall grip"}};
  const auto program = read("wait 5s\ncall both\nloop 3\n call grip\nend", folder);
  ASSERT_TRUE(program) << to_text(program.error().front());
  EXPECT_EQ(program->files, (std::vector<std::string>{"main.sinew", "both.sinew", "grip.sinew"}));
  ASSERT_EQ(program->steps.size(), 1 + 2 * 4 + 1 + 4 + 1U);
  EXPECT_EQ(program->steps[1].file, 2);
  EXPECT_EQ(program->steps[1].line, 1);
  for (std::size_t i = 0; i < program->steps.size(); ++i) {
    if (const auto* loop = std::get_if<LoopStep>(&program->steps[i].what)) {
      EXPECT_EQ(std::get<EndStep>(program->steps[loop->end].what).loop, i);
    }
  }
  const auto plan = make_plan(*program, test::robot("puma560"), home());
  ASSERT_TRUE(plan);
  EXPECT_NEAR(plan->duration, 5 + 2 * 5 + 3 * 5, 1e-9);
}

TEST(Calls, refusals_name_the_file_and_recursion_its_chain) {
  const Folder folder{{"a", "call b"},
                      {"b", "wait 1s\ncall c\njoint wiast=3deg"},
                      {"c", "call a"},
                      {"far", "wait 1s\njoint waist=3000deg"}};
  EXPECT_EQ(complaints("call a", folder),
            (std::vector<std::string>{
                "c.sinew:1:6: a program cannot call itself: a calls b calls c calls a",
                "b.sinew:3:7: 'wiast' is no joint of this robot; did you mean waist?"}));
  EXPECT_EQ(
      complaints("call main", folder),
      std::vector<std::string>{"main.sinew:1:6: a program cannot call itself: main calls main"});
  EXPECT_EQ(complaints("call lost", folder),
            std::vector<std::string>{"main.sinew:1:6: lost.sinew: no such file"});
  EXPECT_EQ(complaints("call ../a", folder),
            std::vector<std::string>{
                "main.sinew:1:6: '../a': a program is called by its name alone, letters, digits, - "
                "and _; it lies in the same folder"});
  EXPECT_EQ(complaints("call", folder),
            std::vector<std::string>{"main.sinew:1:1: something is missing; write call NAME"});
  const auto plan = planned("wait 1s\ncall far", folder);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().line, 2);
  EXPECT_EQ(plan.error().file, 1);
}

TEST(Calls, depth_and_size_are_bounded) {
  Folder deep, wide;
  for (int i = 0; i < 9; ++i) {
    deep["d" + std::to_string(i)] = "call d" + std::to_string(i + 1);
    std::string body;
    for (int k = 0; k < 20; ++k) body += "call w" + std::to_string(i + 1) + "\n";
    wide["w" + std::to_string(i)] = body;
  }
  deep["d9"] = wide["w8"] = "wait 1s\n";
  EXPECT_TRUE(read("call d2", deep)) << "eight deep";
  const auto too_deep = complaints("call d1", deep);
  EXPECT_EQ(too_deep, std::vector<std::string>{"d8.sinew:1:6: calls are nested at most 8 deep"});
  const auto too_wide = complaints("call w1", wide);
  ASSERT_FALSE(too_wide.empty());
  EXPECT_NE(too_wide.front().find("more than 100000 rows"), std::string::npos) << too_wide.front();
  Folder many;
  std::string text;
  for (int i = 0; i < 70; ++i) {
    many["m" + std::to_string(i)] = "wait 0s\n";
    text += "call m" + std::to_string(i) + "\n";
  }
  ASSERT_EQ(complaints(text, many).size(), 7U);
}

TEST(Conditions, are_read_with_or_without_blanks) {
  const auto program = read(
      "if waist > 20 deg\nend\nif z<=100mm\nend\nif J3<-1rad\nend\nif supply>=11.5V\nend\n"
      "wait until x > 1m for 5s\nwait settled\nwait settled for 2s");
  ASSERT_TRUE(program) << to_text(program.error().front());
  const auto condition = [&](std::size_t place) {
    return std::get<IfStep>(program->steps[place].what).condition;
  };
  using Subject = Condition::Subject;
  using Wanted = Condition::Test;
  EXPECT_EQ(condition(0), (Condition{Subject::kJoint, Wanted::kAbove, 0, from_deg(20)}));
  EXPECT_EQ(condition(2), (Condition{Subject::kToolZ, Wanted::kBelow, 0, 0.1}));
  EXPECT_EQ(condition(4), (Condition{Subject::kJoint, Wanted::kBelow, 2, -1}));
  EXPECT_EQ(condition(6), (Condition{Subject::kSupply, Wanted::kAbove, 0, 11.5}));
  const auto& wait = std::get<WaitStep>(program->steps[8].what);
  EXPECT_EQ(wait.what, WaitStep::For::kCondition);
  EXPECT_EQ(wait.duration, std::chrono::seconds(5));
  EXPECT_EQ(wait.until, (Condition{Subject::kToolX, Wanted::kAbove, 0, 1}));
  EXPECT_EQ(std::get<WaitStep>(program->steps[9].what).duration, std::chrono::seconds(5));
  EXPECT_EQ(std::get<WaitStep>(program->steps[10].what).duration, std::chrono::seconds(2));
}

TEST(Conditions, jaws_are_known_where_there_are_some) {
  const auto with = parse("if jaws>5mm\nend\n", "p", test::robot("learm"));
  ASSERT_TRUE(with) << to_text(with.error().front());
  const Condition condition = std::get<IfStep>(with->steps[0].what).condition;
  EXPECT_EQ(condition, (Condition{Condition::Subject::kJaws, Condition::Test::kAbove, 0, 0.005}));
  EXPECT_EQ(condition_text(condition, test::robot("learm")), "jaws > 5 mm");
  const auto without = parse("if jaws>5mm\nend\n", "p", test::robot("maxarm"));
  ASSERT_FALSE(without);
  EXPECT_NE(to_text(without.error().front()).find("nothing that is measured"), std::string::npos);
}

TEST(Conditions, every_fault_is_told_at_its_place) {
  const struct {
    const char* text;
    const char* complaint;
  } kCases[] = {
      {"if waist\nend",
       "main.sinew:1:4: 'waist': a condition is one number that is measured, above or below one "
       "that the row says, as in waist>20deg or z<100mm"},
      {"if\nend",
       "main.sinew:1:1: '': a condition is one number that is measured, above or below one that "
       "the row says, as in waist>20deg or z<100mm"},
      {"if waist==20deg\nend",
       "main.sinew:1:4: 'waist==20deg': a condition is one number that is measured, above or below "
       "one that the row says, as in waist>20deg or z<100mm"},
      {"if wist>20deg\nend",
       "main.sinew:1:4: 'wist' is nothing that is measured; did you mean waist?"},
      {"if waist>20mm\nend", "main.sinew:1:4: '20mm' ends in 'mm', which is none of deg, rad"},
      {"if waist>20deg and z<3mm\nend",
       "main.sinew:1:4: '20degandz<3mm' ends in 'degandz<3mm', which is none of deg, rad"},
      {"if z<1e9m\nend", "main.sinew:1:4: '1e9m' is beyond what any machine measures"},
      {"if z<1mm", "main.sinew:1:1: if without end: write end behind its last step"},
      {"else", "main.sinew:1:1: else without if"},
      {"loop 2\nelse\nend", "main.sinew:2:1: else without if"},
      {"if z<1mm\nelse\nelse\nend", "main.sinew:3:1: this if has an else already"},
      {"end", "main.sinew:1:1: end without loop or if"},
      {"wait until z<1mm",
       "main.sinew:1:6: say what for and how long at most, as in wait until z<100mm for 5s"},
      {"wait settled 5s", "main.sinew:1:14: write wait settled, or wait settled for 5s"},
      {"wait settled for 5h", "main.sinew:1:18: '5h' ends in 'h', which is none of s, ms, min"},
  };
  for (const auto& c : kCases) {
    EXPECT_EQ(complaints(c.text), std::vector<std::string>{c.complaint}) << c.text;
  }
}

TEST(BranchPlan, both_branches_stand_in_it_and_jumps_lead_behind_them) {
  const auto plan = planned("if waist>1deg\n wait 1s\nelse\n wait 3s\n wait 4s\nend\nwait 10s\n");
  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->orders.size(), 6U);
  EXPECT_EQ(std::get<BranchOrder>(plan->orders[0].what).otherwise, 3U);
  EXPECT_EQ(std::get<JumpOrder>(plan->orders[2].what).to, 5U);
  EXPECT_NEAR(plan->duration, 17, 1e-9);
  EXPECT_NEAR(plan->duration_min, 11, 1e-9);
  const auto alone = planned("if waist>1deg\n wait 1s\nend\nwait 10s\n");
  ASSERT_TRUE(alone);
  EXPECT_EQ(std::get<BranchOrder>(alone->orders[0].what).otherwise, 2U);
  EXPECT_NEAR(alone->duration, 11, 1e-9);
  EXPECT_NEAR(alone->duration_min, 10, 1e-9);
}

TEST(BranchPlan, rows_behind_are_planned_from_wherever_a_branch_may_end) {
  const auto near = planned(
      "if waist>1deg\n joint waist=80deg\nelse\n joint waist=-20deg\nend\njoint d.waist=60deg\n");
  ASSERT_TRUE(near);
  const auto& move = std::get<MoveOrder>(near->orders.back().what);
  EXPECT_EQ(move.starts, 2U);
  EXPECT_LT(near->duration_min, near->duration);
  const auto far = planned(
      "if waist>1deg\n joint waist=80deg\nelse\n joint waist=-20deg\nend\njoint d.waist=90deg\n");
  ASSERT_FALSE(far) << "from one of both it is out of its limits";
  EXPECT_EQ(far.error().line, 6);
  EXPECT_EQ(far.error().error.code, ErrorCode::kJointLimit);
}

TEST(BranchPlan, branch_that_is_never_taken_is_checked_all_the_same) {
  const auto plan = planned("if waist>170deg\n joint waist=300deg\nend\n");
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().line, 2);
}

TEST(BranchPlan, places_meet_again_where_a_row_names_all_joints) {
  std::string text = "loop 100\n";
  text += "if waist>1deg\n joint waist=10deg\nelse\n joint elbow=-65deg\nend\n";
  text +=
      "joint waist=0deg shoulder=20deg elbow=-70deg forearm_roll=0deg wrist_bend=60deg "
      "flange_roll=0deg\nend\n";
  const auto plan = planned(text);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->orders.size(), 100 * 5U);
}

TEST(BranchPlan, more_places_than_can_be_checked_are_refused) {
  const auto plan = planned("loop 100\nif waist>1deg\n joint d.waist=0.1deg\nend\nend\n");
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().error.code, ErrorCode::kTooManyPlaces);
  EXPECT_EQ(plan.error().line, 4);
}

TEST(BranchPlan, condition_on_an_unknown_position_is_refused_one_on_the_supply_is_not) {
  const auto plan = [&](const char* text) {
    return make_plan(*read(text, {}, "learm"), test::robot("learm"), std::nullopt);
  };
  ASSERT_FALSE(plan("if base>1deg\nend"));
  EXPECT_EQ(plan("if base>1deg\nend").error().error.code, ErrorCode::kPositionUnknown);
  EXPECT_EQ(plan("wait until z<1mm for 1s").error().error.code, ErrorCode::kPositionUnknown);
  EXPECT_TRUE(plan("if supply>7V\nend"));
}

/// s that one of all ways through a program waits, every `if` decided by the next bit.
double waits_of(const Program& program, std::uint64_t bits) {
  double seconds = 0;
  for (std::size_t place = 0; place < program.steps.size(); ++place) {
    const auto& what = program.steps[place].what;
    if (const auto* wait = std::get_if<WaitStep>(&what)) seconds += to_seconds(wait->duration);
    if (const auto* branch = std::get_if<IfStep>(&what)) {
      if ((bits & 1) == 0) place = branch->otherwise;
      bits >>= 1;
    } else if (const auto* other = std::get_if<ElseStep>(&what)) {
      place = std::get<IfStep>(program.steps[other->begin].what).end;
    }
  }
  return seconds;
}

TEST(BranchPlan, every_way_through_takes_a_time_inside_the_range_and_both_ends_are_taken) {
  test::for_random_cases(300, [](test::Random& random) {
    std::string text;
    int ifs = 0;
    const std::function<void(int)> block = [&](int depth) {
      for (auto rows = random.integer(1, 3); rows > 0; --rows) {
        const bool deeper = depth < 3 && ifs < 6 && random.chance(0.5);
        if (deeper) {
          ++ifs;
          text += "if waist>" + std::to_string(random.integer(-90, 90)) + "deg\n";
          block(depth + 1);
          if (random.chance(0.6)) {
            text += "else\n";
            block(depth + 1);
          }
          text += "end\n";
        } else {
          text += "wait " + std::to_string(random.integer(1, 1000)) + "ms\n";
        }
      }
    };
    block(0);
    const auto program = read(text);
    ASSERT_TRUE(program) << text;
    const auto plan = make_plan(*program, test::robot("puma560"), home());
    ASSERT_TRUE(plan) << text;
    double least = 1e9, most = 0;
    for (std::uint64_t bits = 0; bits < 64; ++bits) {
      const double seconds = waits_of(*program, bits);
      least = std::min(least, seconds);
      most = std::max(most, seconds);
    }
    ASSERT_NEAR(plan->duration_min, least, 1e-9) << text;
    ASSERT_NEAR(plan->duration, most, 1e-9) << text;
    for (const Order& order : plan->orders) {
      const auto at = static_cast<std::size_t>(&order - plan->orders.data());
      if (const auto* branch = std::get_if<BranchOrder>(&order.what)) {
        ASSERT_GT(branch->otherwise, at);
        ASSERT_LE(branch->otherwise, plan->orders.size());
      }
      if (const auto* jump = std::get_if<JumpOrder>(&order.what)) {
        ASSERT_GT(jump->to, at);
        ASSERT_LE(jump->to, plan->orders.size());
      }
    }
  });
}

TEST(Check, refused_row_is_told_and_those_behind_it_are_checked_from_where_it_would_have_ended) {
  const auto program = read(
      "joint waist=10deg\n"
      "joint waist=3000deg\n"
      "joint waist=20deg\n"
      "line dz=10mm\n"
      "joint waist=0deg shoulder=20deg elbow=-70deg forearm_roll=0deg wrist_bend=60deg "
      "flange_roll=0deg\n"
      "line dz=10mm speed=50mm/s\n"
      "jaws 20mm\n"
      "line z=9m\n"
      "wait 1s\n");
  ASSERT_TRUE(program);
  const auto checked = check(*program, test::robot("puma560"), home());
  using Kind = RowVerdict::Kind;
  const Kind kWanted[] = {Kind::kFine,      Kind::kRefused,   Kind::kUnchecked,
                          Kind::kUnchecked, Kind::kUnchecked, Kind::kFine,
                          Kind::kRefused,   Kind::kRefused,   Kind::kFine};
  for (std::size_t i = 0; i < std::size(kWanted); ++i) {
    EXPECT_EQ(checked.rows[i].kind, kWanted[i]) << "line " << i + 1;
  }
  EXPECT_EQ(checked.rows[2].because, 1U);
  EXPECT_EQ(checked.rows[4].because, 1U) << "its way, not its end";
  EXPECT_GT(checked.rows[5].time_max, 0.2);
  EXPECT_EQ(checked.rows[1].refusal->error.code, ErrorCode::kJointLimit);
  EXPECT_EQ(checked.rows[6].refusal->error.code, ErrorCode::kToolNotFitted);
  EXPECT_FALSE(checked.fine());
}

TEST(Check, what_a_plan_takes_is_fine_and_what_it_refuses_is_refused_at_the_same_row) {
  const char* const kRows[] = {"joint waist=%deg",
                               "joint d.waist=%deg",
                               "joint shoulder=%deg",
                               "line dz=%mm",
                               "move dx=%mm",
                               "line dy=%mm blend=2mm",
                               "wait 10ms",
                               "if waist>%deg",
                               "else",
                               "end",
                               "loop 2",
                               "jaws 10mm"};
  int fine = 0, refused = 0;
  test::for_random_cases(400, [&](test::Random& random) {
    std::string text;
    for (auto rows = random.integer(1, 8); rows > 0; --rows) {
      std::string row = kRows[random.integer(0, std::ssize(kRows) - 1)];
      const std::size_t mark = row.find('%');
      if (mark != std::string::npos) row.replace(mark, 1, std::to_string(random.integer(-60, 60)));
      text += row + "\n";
    }
    const auto program = read(text);
    if (!program) return random.discard();
    const RobotModel& robot = test::robot("puma560");
    const auto plan = make_plan(*program, robot, home());
    const auto checked = check(*program, robot, home());
    ASSERT_EQ(plan.has_value(), checked.fine()) << text;
    ++(plan ? fine : refused);
    if (plan) {
      ASSERT_NEAR(plan->duration, checked.duration_max, 1e-9) << text;
      return;
    }
    bool found = false;
    for (std::size_t i = 0; i < checked.rows.size(); ++i) {
      found = found || (checked.rows[i].kind == RowVerdict::Kind::kRefused &&
                        program->steps[i].line == plan.error().line);
    }
    ASSERT_TRUE(found || checked.broken_off) << text << "line " << plan.error().line;
  });
  std::cout << "  " << fine << " fine, " << refused << " refused\n";
  EXPECT_GT(fine, 50);
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace sinew::program
