// Texts of other forms over the API, and what a job says of a row that is refused.

#include <gtest/gtest.h>

#include "sinew/server/api/api_test_cell.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;
using test::place;

constexpr const char* kSequence = "# two rounds\nBEGIN I2\nG0 B100 S200\nG0 B0 S0\nEND\n";
/// Through its table.
constexpr const char* kDown = "# down\nG0 B0 S-2500 E-10000 WR0 W0\n";

Json run(ApiClient& client, Json params) {
  const Json begun = client.call("program.run", params);
  EXPECT_TRUE(begun.contains("result")) << begun.dump();
  return client.finish(params["robot"]);
}

TEST(ApiForms, a_sequence_is_checked_previewed_and_run_as_it_is_with_its_own_lines) {
  ApiCell cell({place("big", "bigrobotarm")}, 20);
  ApiClient client(cell);
  for (const bool told : {false, true}) {
    Json params{{"robot", "big"}, {"text", kSequence}};
    if (told) params["form"] = "sequence";
    const Json check = client.call("program.check", params)["result"];
    EXPECT_TRUE(check["fine"].get<bool>()) << check.dump();
    std::vector<int> lines;
    for (const Json& row : check["rows"]) lines.push_back(row["line"]);
    EXPECT_EQ(lines, (std::vector{3, 4})) << check.dump();
    EXPECT_FALSE(check["notes"].empty()) << "its joints arrive apart in the firmware";
    const Json preview = client.call("robot.preview", params);
    EXPECT_TRUE(preview.contains("result")) << preview.dump();
    const Json job = run(client, params);
    EXPECT_EQ(job["phase"], "done") << job.dump();
    EXPECT_EQ(job["orders"], 4);
    EXPECT_EQ(job["notes"], check["notes"]);
  }
  for (const char* method : {"program.check", "program.run", "robot.preview"}) {
    EXPECT_NE(client.sentence(method, {{"robot", "big"}, {"text", kSequence}, {"form", "dance"}})
                  .find("form is sequence, pos or gcode"),
              std::string::npos);
    // What is wrong with it has the line of the text.
    const Json wrong =
        client.call(method, {{"robot", "big"}, {"text", "BEGIN I2\nG0 B1 Q2\nEND\n"}});
    const std::string said = wrong.dump();
    EXPECT_TRUE(said.contains("\"line\":2") || said.contains(":2:7: ")) << said;
  }
}

TEST(ApiForms, a_refused_row_has_its_place_its_depth_and_rows_that_work) {
  ApiCell cell({place("big", "bigrobotarm")}, 20);
  ApiClient client(cell);
  const Json params{{"robot", "big"}, {"text", kDown}};
  const Json job = run(client, params);
  ASSERT_EQ(job["phase"], "failed") << job.dump();
  const Json& error = job["error"];
  EXPECT_EQ(error["code"], "collision");
  EXPECT_EQ(error["line"], 2);
  EXPECT_GT(error["share"].get<double>(), 0);
  EXPECT_LT(error["nearest_behind_m"].get<double>(), 0);
  ASSERT_FALSE(error["remedies"].empty()) << error.dump();
  const Json refused = client.call("robot.preview", params);
  EXPECT_EQ(refused["error"]["data"]["remedies"], error["remedies"]) << refused.dump();
  const std::string remedy = error["remedies"][0];
  const std::string row = remedy.substr(remedy.find(": ") + 2);
  EXPECT_EQ(run(client, {{"robot", "big"}, {"text", row}})["phase"], "done") << row;
}

}  // namespace
}  // namespace sinew::server
