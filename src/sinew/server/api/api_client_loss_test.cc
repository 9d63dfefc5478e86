// Programs belong to the controller: clients come, go and take over.
#include <memory>

#include "sinew/server/api/api_test_cell.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;
using test::place;
using test::truth_deg;

constexpr const char* kSlow = "joint base=90deg speed=5%\njoint base=80deg";

CellRobot arm(ClientLoss loss = ClientLoss::kPause) {
  CellRobot robot = place("left", "learm", "bus");
  robot.on_client_loss = loss;
  return robot;
}

/// Runs the slow program on `left`, until it moves.
void begin(ApiCell& cell, ApiClient& client) {
  client.run("left", test::kStand);
  client.call("program.run", {{"robot", "left"}, {"text", kSlow}, {"name", "slow"}});
  ASSERT_TRUE(cell.until([&] { return client.status("left")["state"] == "moving"; }));
}

Json job_of(ApiClient& client) {
  return client.call("job.status", {{"robot", "left"}})["result"];
}

/// It is held on its path, and says why.
void expect_left(ApiCell& cell, ApiClient& watcher) {
  ASSERT_TRUE(cell.until([&] { return watcher.status("left")["state"] == "held"; }))
      << watcher.status("left").dump();
  const Json job = job_of(watcher);
  EXPECT_EQ(job["phase"], "paused") << job.dump();
  EXPECT_EQ(job["client_lost"], true);
  EXPECT_FALSE(job["over"].get<bool>());
  EXPECT_LT(truth_deg(watcher, "left", 0), 85);
}

void expect_resumed_by(ApiClient& next) {
  EXPECT_EQ(next.sentence("robot.resume", {{"robot", "left"}}), "");
  const Json job = next.finish("left");
  EXPECT_EQ(job["phase"], "done") << job.dump();
  EXPECT_EQ(job["client"], next.id());
  EXPECT_FALSE(job.contains("client_lost"));
  EXPECT_NEAR(truth_deg(next, "left", 0), 80, 1);
}

TEST(ApiClientLoss, who_falls_silent_leaves_a_program_that_the_next_one_resumes) {
  ApiCell cell({arm()}, 5);
  ApiClient silent(cell);
  ApiClient next(cell);
  begin(cell, silent);
  expect_left(cell, next);
  EXPECT_FALSE(next.status("left").contains("lease"));
  EXPECT_NE(next.sentence("robot.resume", {{"robot", "left"}}).find("take control"),
            std::string::npos);
  EXPECT_NE(next.sentence("program.step", {{"robot", "left"}}).find("take control"),
            std::string::npos);
  EXPECT_EQ(next.sentence("lease.take", {{"robot", "left"}}), "");
  // What else it would begin has to wait.
  EXPECT_NE(next.sentence("program.run", {{"robot", "left"}, {"text", "joint base=0deg"}})
                .find("'slow' is paused on this robot: resume or stop it first"),
            std::string::npos);
  EXPECT_NE(next.sentence("procedure.start", {{"robot", "left"}, {"kind", "recover"}})
                .find("resume or stop it first"),
            std::string::npos);
  expect_resumed_by(next);
}

TEST(ApiClientLoss, who_goes_away_leaves_a_program_that_anyone_may_stop) {
  ApiCell cell({arm()}, 5);
  ApiClient viewer(cell, Role::kViewer);
  auto gone = std::make_unique<ApiClient>(cell);
  begin(cell, *gone);
  gone.reset();
  expect_left(cell, viewer);
  EXPECT_EQ(viewer.sentence("robot.stop", {{"robot", "left"}}), "");
  EXPECT_EQ(viewer.finish("left")["phase"], "stopped");
  EXPECT_TRUE(cell.until([&] { return viewer.status("left")["state"] == "ready"; }));
}

TEST(ApiClientLoss, who_takes_over_finds_the_program_paused_and_resumes_it) {
  ApiCell cell({arm()}, 5);
  ApiClient first(cell);
  ApiClient second(cell);
  begin(cell, first);
  EXPECT_EQ(second.sentence("lease.take", {{"robot", "left"}, {"take_over", true}}), "");
  expect_left(cell, second);
  EXPECT_NE(first.sentence("robot.resume", {{"robot", "left"}}), "") << "it has lost control";
  expect_resumed_by(second);
}

TEST(ApiClientLoss, by_choice_the_program_goes_on_and_can_be_taken_over) {
  ApiCell cell({arm(ClientLoss::kContinue)}, 5);
  ApiClient next(cell);
  auto gone = std::make_unique<ApiClient>(cell);
  begin(cell, *gone);
  gone.reset();
  const Json job = next.finish("left");
  EXPECT_EQ(job["phase"], "done") << job.dump();
  EXPECT_TRUE(cell.until([&] { return !next.status("left").contains("lease"); }))
      << "what has ended keeps no lease";

  gone = std::make_unique<ApiClient>(cell);
  begin(cell, *gone);
  gone.reset();
  EXPECT_NE(next.sentence("lease.take", {{"robot", "left"}}), "") << "the program has it";
  EXPECT_EQ(next.sentence("lease.take", {{"robot", "left"}, {"take_over", true}}), "");
  expect_left(cell, next);
  expect_resumed_by(next);
}

TEST(ApiClientLoss, a_guarded_hold_is_released_by_whoever_set_it_or_by_an_explicit_take_over) {
  ApiCell cell({arm()}, 5);
  ApiClient owner(cell);
  ApiClient guard(cell);
  begin(cell, owner);
  const Json hold{{"robot", "left"}, {"guarded", true}};
  const Json resume{{"robot", "left"}};
  const Json over{{"robot", "left"}, {"take_over", true}};
  for (const bool takes_over : {false, true}) {
    EXPECT_EQ(guard.sentence("robot.hold", hold), "");
    ASSERT_TRUE(cell.until([&] { return owner.status("left")["state"] == "held"; }));
    EXPECT_EQ(job_of(owner)["held_by"], guard.id());
    // A hold of somebody else takes no guard away.
    EXPECT_EQ(owner.sentence("robot.hold", resume), "");
    EXPECT_NE(owner.sentence("robot.resume", resume).find("only that client resumes it"),
              std::string::npos);
    EXPECT_NE(owner.sentence("program.step", resume), "");
    EXPECT_EQ(owner.status("left")["state"], "held");
    EXPECT_EQ(
        takes_over ? owner.sentence("robot.resume", over) : guard.sentence("robot.resume", resume),
        "");
    ASSERT_TRUE(cell.until([&] { return owner.status("left")["state"] == "moving"; }));
    EXPECT_FALSE(job_of(owner).contains("held_by"));
  }
  EXPECT_EQ(owner.finish("left")["phase"], "done");
}

TEST(ApiClientLoss, a_guard_is_not_replaced_by_another_clients_guarded_hold) {
  ApiCell cell({arm()}, 5);
  ApiClient owner(cell);
  ApiClient guard(cell);
  ApiClient other(cell);
  begin(cell, owner);
  const Json hold{{"robot", "left"}, {"guarded", true}};
  EXPECT_EQ(guard.sentence("robot.hold", hold), "");
  EXPECT_NE(other.sentence("robot.hold", hold).find("it stays held, without a guard of yours"),
            std::string::npos);
  EXPECT_EQ(job_of(owner)["held_by"], guard.id());
  EXPECT_NE(other.sentence("robot.resume", {{"robot", "left"}}).find("only that client resumes it"),
            std::string::npos);
  ASSERT_TRUE(cell.until([&] { return owner.status("left")["state"] == "held"; }));
  EXPECT_EQ(guard.sentence("robot.resume", {{"robot", "left"}}), "");
  EXPECT_EQ(owner.finish("left")["phase"], "done");
}

TEST(ApiClientLoss, without_a_program_no_hold_is_guarded_and_nothing_is_resumed) {
  ApiCell cell({arm()}, 5);
  ApiClient client(cell);
  EXPECT_NE(client.sentence("robot.hold", {{"robot", "left"}, {"guarded", true}})
                .find("only the hold of a program can be guarded"),
            std::string::npos);
  EXPECT_EQ(client.sentence("robot.resume", {{"robot", "left"}}),
            "nothing is paused on this robot");
}

TEST(ApiClientLoss, a_procedure_without_the_lease_is_refused_before_it_occupies_the_robot) {
  ApiCell cell({arm()}, 5);
  ApiClient owner(cell);
  ApiClient other(cell);
  ASSERT_EQ(owner.sentence("lease.take", {{"robot", "left"}}), "");
  EXPECT_NE(other.sentence("procedure.start", {{"robot", "left"}, {"kind", "commission"}})
                .find("moves this machine; take over, or wait"),
            std::string::npos);
  EXPECT_EQ(owner.run("left", "wait 0.1s")["phase"], "done");
}

TEST(ApiClientLoss, a_program_without_the_lease_is_refused_before_it_occupies_the_robot) {
  ApiCell cell({arm()}, 5);
  ApiClient owner(cell);
  ApiClient other(cell);
  ASSERT_EQ(owner.sentence("lease.take", {{"robot", "left"}}), "");
  const Json before = job_of(other);
  EXPECT_NE(other.sentence("program.run", {{"robot", "left"}, {"text", "wait 1s"}})
                .find("moves this machine; take over, or wait"),
            std::string::npos);
  EXPECT_NE(other.sentence("robot.bullride", {{"robot", "left"}, {"duration_s", 2}}), "");
  EXPECT_EQ(job_of(other)["job"], before["job"]);
  EXPECT_EQ(owner.run("left", "wait 0.1s")["phase"], "done");
}

}  // namespace
}  // namespace sinew::server
