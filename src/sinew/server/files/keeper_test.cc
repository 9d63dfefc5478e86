#include "sinew/server/files/keeper.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "sinew/runtime/records/mcap_reader.h"
#include "sinew/server/api/api_test_cell.h"
#include "support/scratch_folder.h"

/// Records, programs and points, asked for as clients do.
namespace sinew::server {
namespace {

using sinew::test::ScratchFolder;
using test::ApiCell;
using test::ApiClient;

class KeeperTest : public testing::Test {
 protected:
  KeeperTest()
      : cell_({test::place("left", "learm", "bus"), test::place("six", "hexapod")}, 20, folders()) {
  }

  runtime::CellFolders folders() {
    runtime::CellFolders folders;
    folders.flight = folder_.at("records");
    folders.programs = folder_.at("programs");
    return folders;
  }
  static std::string code(const Json& answer) {
    return answer.contains("error") ? answer["error"]["data"].value("code", "") : "none";
  }
  Json save(ApiClient& client, const std::string& name, const std::string& text,
            std::uint64_t revision) {
    return client.call("programs.save",
                       {{"robot", "left"}, {"name", name}, {"text", text}, {"revision", revision}});
  }
  std::string whole(ApiClient& client, const char* method, const std::string& record) {
    std::string text;
    for (std::uint64_t offset = 0;;) {
      const Json part = client.call(method, {{"record", record}, {"offset", offset}})["result"];
      EXPECT_EQ(part["offset"], offset);
      const std::string bytes = decoded(part["data"]);
      text += bytes;
      offset += bytes.size();
      if (part["end"] == true) return text;
      if (bytes.empty()) ADD_FAILURE() << "no end at " << offset;
      if (bytes.empty()) return text;
    }
  }
  static std::string decoded(const std::string& base64) {
    constexpr std::string_view kLetters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : base64) {
      if (c == '=') break;
      bits = (bits << 6) | static_cast<std::uint32_t>(kLetters.find(c));
      count += 6;
      if (count < 8) continue;
      count -= 8;
      bytes += static_cast<char>((bits >> count) & 255);
    }
    return bytes;
  }

  ScratchFolder folder_;
  ApiCell cell_;
};

const std::string kHostile[] = {"",
                                "..",
                                "../a",
                                "a/b",
                                "/etc/passwd",
                                ".hidden",
                                "a.b",
                                "1a",
                                "a b",
                                "a\n",
                                "\xC3\xA4",
                                "a\\b",
                                "points/",
                                std::string(41, 'a'),
                                std::string("a\0b", 3)};

TEST_F(KeeperTest, hostile_names_are_refused_and_no_file_appears) {
  ApiClient client(cell_);
  for (const std::string& name : kHostile) {
    EXPECT_EQ(save(client, name, "wait 1s\n", 0)["error"]["code"], -32602) << name;
    for (const char* method : {"programs.load", "programs.remove", "points.remove"}) {
      Json params{{"robot", "left"}, {"name", name}};
      if (std::string_view(method) != "programs.load") params["revision"] = 1;
      EXPECT_EQ(client.call(method, params)["error"]["code"], -32602) << method << " " << name;
    }
    for (const char* method : {"records.read", "records.csv", "records.remove"}) {
      EXPECT_EQ(client.call(method, {{"record", name}})["error"]["code"], -32602) << name;
      EXPECT_EQ(client.call(method, {{"record", "../" + name + ".mcap"}})["error"]["code"], -32602);
    }
  }
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.at())) {
    files += entry.is_regular_file() ? 1 : 0;
  }
  EXPECT_EQ(files, 0u);
}

TEST_F(KeeperTest, what_one_client_saves_another_one_loads_and_a_conflict_changes_nothing) {
  ApiClient one(cell_);
  ApiClient other(cell_);
  const std::uint64_t before = one.status("left")["kept"];
  const Json saved = save(one, "wave", "wait 1s\n", 0);
  ASSERT_TRUE(saved.contains("result")) << saved.dump();
  const Json list = other.call("programs.list", {{"robot", "left"}})["result"];
  ASSERT_EQ(list["programs"].size(), 1u);
  EXPECT_EQ(list["programs"][0]["name"], "wave");
  EXPECT_GT(other.status("left")["kept"].get<std::uint64_t>(), before);
  const Json loaded = other.call("programs.load", {{"robot", "left"}, {"name", "wave"}})["result"];
  EXPECT_EQ(loaded["text"], "wait 1s\n");
  EXPECT_EQ(loaded["revision"], saved["result"]["revision"]);
  EXPECT_EQ(sinew::test::text_of(folder_.at("programs/learm/wave.sinew")), "wait 1s\n");

  // Both have opened it; the second to save learns of the first.
  const std::uint64_t known = loaded["revision"];
  const Json first = save(other, "wave", "wait 2s\n", known);
  ASSERT_TRUE(first.contains("result"));
  const Json late = save(one, "wave", "wait 3s\n", known);
  EXPECT_EQ(code(late), "conflict");
  EXPECT_EQ(late["error"]["data"]["revision"], first["result"]["revision"]);
  EXPECT_EQ(sinew::test::text_of(folder_.at("programs/learm/wave.sinew")), "wait 2s\n");
  EXPECT_EQ(code(save(one, "wave", "wait 3s\n", 0)), "conflict");
  EXPECT_EQ(
      code(one.call("programs.remove", {{"robot", "left"}, {"name", "wave"}, {"revision", known}})),
      "conflict");
  const std::uint64_t now = first["result"]["revision"];
  EXPECT_EQ(
      code(one.call("programs.remove", {{"robot", "left"}, {"name", "wave"}, {"revision", now}})),
      "none");
  EXPECT_EQ(code(one.call("programs.load", {{"robot", "left"}, {"name", "wave"}})), "missing");
}

TEST_F(KeeperTest, viewers_look_and_change_nothing) {
  ApiClient client(cell_);
  ASSERT_TRUE(save(client, "wave", "wait 1s\n", 0).contains("result"));
  ApiClient viewer(cell_, Role::kViewer);
  EXPECT_EQ(viewer.call("programs.load", {{"robot", "left"}, {"name", "wave"}})["result"]["text"],
            "wait 1s\n");
  EXPECT_TRUE(viewer.call("points.list", {{"robot", "left"}}).contains("result"));
  EXPECT_TRUE(viewer.call("records.list").contains("result"));
  const std::pair<const char*, Json> changes[] = {
      {"programs.save", {{"robot", "left"}, {"name", "a"}, {"text", ""}, {"revision", 0}}},
      {"programs.remove", {{"robot", "left"}, {"name", "wave"}, {"revision", 1}}},
      {"points.save", {{"robot", "left"}, {"points", ""}, {"revision", 0}}},
      {"points.remove", {{"robot", "left"}, {"name", "a"}, {"revision", 0}}},
      {"points.rename", {{"robot", "left"}, {"name", "a"}, {"to", "b"}, {"revision", 0}}},
      {"record.start", {{"robot", "left"}}},
      {"record.stop", {{"robot", "left"}}},
      {"records.remove", {{"record", "a.mcap"}}}};
  for (const auto& [method, params] : changes) {
    EXPECT_EQ(viewer.sentence(method, params), "viewers watch and may stop; this is for operators")
        << method;
  }
}

constexpr const char* kPoint =
    "[points.above]\nrobot = \"learm\"\njoints_deg = [0, 20, 40, 40, 0]\nsource = \"by hand\"\n";

TEST_F(KeeperTest, points_lie_where_programs_find_them_and_remarks_stay) {
  ApiClient client(cell_);
  const Json saved =
      client.call("points.save", {{"robot", "left"}, {"points", kPoint}, {"revision", 0}});
  ASSERT_TRUE(saved.contains("result")) << saved.dump();
  std::uint64_t revision = saved["result"]["revision"];
  const std::string file = saved["result"]["file"];
  EXPECT_EQ(file, folder_.at("programs/learm/points.toml"));
  EXPECT_NEAR(saved["result"]["points"][0]["position_rad"][1].get<double>(), 20 * kPi / 180, 1e-9);
  // An editor was here.
  std::ofstream(file, std::ios::app) << "\n# mine\n[points.low]\nrobot = \"learm\"\nx_mm = 150\n"
                                     << "y_mm = 0\nz_mm = 90\n";
  EXPECT_EQ(code(client.call("points.remove",
                             {{"robot", "left"}, {"name", "above"}, {"revision", revision}})),
            "conflict");
  Json list = client.call("points.list", {{"robot", "left"}})["result"];
  ASSERT_EQ(list["points"].size(), 2u);
  EXPECT_NEAR(list["points"][1]["tool"]["x_m"].get<double>(), 0.15, 1e-12);
  revision = list["revision"];
  const Json taken =
      client.call("points.rename",
                  {{"robot", "left"}, {"name", "above"}, {"to", "low"}, {"revision", revision}});
  EXPECT_NE(taken["error"]["message"].get<std::string>().find("already"), std::string::npos);
  list = client.call(
      "points.rename",
      {{"robot", "left"}, {"name", "above"}, {"to", "high"}, {"revision", revision}})["result"];
  EXPECT_EQ(list["points"][0]["name"], "high");
  list =
      client.call("points.remove",
                  {{"robot", "left"}, {"name", "high"}, {"revision", list["revision"]}})["result"];
  EXPECT_EQ(sinew::test::text_of(file),
            "# mine\n[points.low]\nrobot = \"learm\"\nx_mm = 150\ny_mm = 0\nz_mm = 90\n");
  // What another kind of robot cannot use is not taken.
  EXPECT_EQ(client.call("points.save",
                        {{"robot", "six"}, {"points", kPoint}, {"revision", 0}})["error"]["code"],
            -32602);
}

TEST_F(KeeperTest, a_check_has_a_verdict_for_each_row_and_looks_at_what_is_kept) {
  ApiClient client(cell_);
  client.run("left", test::kStand);
  client.call("points.save", {{"robot", "left"}, {"points", kPoint}, {"revision", 0}});
  ASSERT_TRUE(save(client, "part", "wait 1s\n", 0).contains("result"));
  const auto check = [&](const std::string& text) {
    const Json answer = client.call("program.check", {{"robot", "left"}, {"text", text}});
    EXPECT_TRUE(answer.contains("result")) << answer.dump();
    return answer["result"];
  };
  const Json fine = check("joint to=above\n  wait 2s\ncall part\n");
  EXPECT_EQ(fine["fine"], true) << fine.dump();
  ASSERT_EQ(fine["rows"].size(), 3u);
  EXPECT_EQ(fine["rows"][1]["line"], 2);
  EXPECT_EQ(fine["rows"][1]["column"], 3);
  EXPECT_NEAR(fine["rows"][1]["time_max_s"].get<double>(), 2, 1e-9);
  EXPECT_EQ(fine["rows"][2]["file"], "part");

  const Json refused = check("joint base=20deg\njoint elbow=900deg\njoint base=10deg\n");
  EXPECT_EQ(refused["fine"], false);
  EXPECT_EQ(refused["rows"][0]["verdict"], "fine");
  EXPECT_EQ(refused["rows"][1]["verdict"], "refused");
  EXPECT_NE(refused["rows"][1]["sentence"].get<std::string>().find("elbow"), std::string::npos);

  const Json unreadable = check("wait 1s\n   joint bose=20deg\nwat\n");
  EXPECT_EQ(unreadable["fine"], false);
  ASSERT_EQ(unreadable["rows"].size(), 2u);
  EXPECT_EQ(unreadable["rows"][0]["line"], 2);
  EXPECT_EQ(unreadable["rows"][1]["line"], 3);
  EXPECT_EQ(check("call nobody\n")["fine"], false);

  const Json points =
      client.call("program.check", {{"robot", "left"},
                                    {"text", "joint to=above\n"},
                                    {"points", "[points.above]\njoints_deg = 7\n"}});
  // Refused where a row uses it, with its place in the file.
  EXPECT_EQ(points["result"]["fine"], false) << points.dump();
  EXPECT_NE(points["result"]["rows"][0].dump().find("points.above"), std::string::npos)
      << points.dump();

  EXPECT_EQ(client.call("program.format", {{"text", "loop 2\nwait   1s\nend"}})["result"]["text"],
            "loop 2\n  wait 1s\nend\n");
  EXPECT_EQ(
      client.call("program.format", {{"text", "wat"}})["error"]["data"]["complaints"][0]["line"],
      1);
}

TEST_F(KeeperTest, files_of_other_programs_become_rows_and_rows_their_files) {
  ApiClient client(cell_);
  const auto made = [&](const char* method, const Json& params) {
    const Json answer = client.call(method, params);
    EXPECT_TRUE(answer.contains("result")) << answer.dump();
    return answer.value("result", Json::object()).value("text", std::string());
  };
  const std::string row = "move x=1.5mm y=-2mm z=251mm rx=0.5deg ry=1deg rz=2deg\n";
  Json wish{{"robot", "six"}, {"text", row}, {"form", "pos"}, {"decimal_comma", true}};
  const std::string pos = made("program.export", wish);
  EXPECT_NE(pos.find(','), std::string::npos);
  EXPECT_TRUE(
      made("program.import", {{"robot", "six"}, {"text", pos}, {"form", "pos"}}).ends_with(row));
  EXPECT_EQ(made("program.import",
                 {{"robot", "left"}, {"text", "G21 G90\nG1 Z110 F2400\n"}, {"form", "gcode"}}),
            "line z=110mm speed=40mm/s\n");

  // What has no other form says why, and where.
  const auto refused = [&](const char* method, const Json& params) {
    return client.sentence(method, params);
  };
  wish["text"] = row + "wait 1s\n";
  EXPECT_NE(refused("program.export", wish).find("one row that moves"), std::string::npos);
  wish["text"] = "move x=3m\n";
  EXPECT_NE(refused("program.export", wish), "");
  wish["text"] = "call nobody\n";
  EXPECT_NE(refused("program.export", wish), "");
  wish["form"] = "gcode";
  EXPECT_NE(refused("program.export", wish).find("form is"), std::string::npos);
  EXPECT_NE(refused("program.export", {{"robot", "six"}, {"text", row}, {"form", "sequence"}})
                .find("BigRobotArm"),
            std::string::npos);
  EXPECT_NE(refused("program.import", {{"robot", "left"}, {"text", pos}, {"form", "pos"}})
                .find("platform's file"),
            std::string::npos);
  const Json arc =
      client.call("program.import", {{"robot", "left"}, {"text", "G2 X1\n"}, {"form", "gcode"}});
  EXPECT_EQ(arc["error"]["data"]["complaints"][0]["line"], 1);
}

TEST_F(KeeperTest, a_record_has_what_moved_and_comes_back_byte_for_byte) {
  ApiClient client(cell_);
  const Json begun = client.call("record.start", {{"robot", "left"}, {"title", "a/../move"}});
  ASSERT_TRUE(begun.contains("result")) << begun.dump();
  const std::string record = begun["result"]["record"];
  EXPECT_TRUE(record.starts_with("left_a----move_")) << record;
  EXPECT_EQ(client.status("left")["recording"]["record"], record);
  EXPECT_FALSE(client.status("six").contains("recording"));
  EXPECT_EQ(code(client.call("record.start", {{"robot", "left"}})), "under_way");
  EXPECT_EQ(code(client.call("records.remove", {{"record", record}})), "under_way");
  EXPECT_EQ(client.run("left", test::kStand)["phase"], "done");
  const Json ended = client.call("record.stop", {{"robot", "left"}});
  ASSERT_TRUE(ended.contains("result")) << ended.dump();
  EXPECT_EQ(ended["result"]["lost"], 0);
  EXPECT_EQ(code(client.call("record.stop", {{"robot", "left"}})), "none");

  const Json list = client.call("records.list")["result"]["records"];
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0]["record"], record);
  EXPECT_EQ(list[0]["robot"], "left");
  EXPECT_GT(list[0]["length_s"].get<double>(), 0.5);
  const std::string bytes = whole(client, "records.read", record);
  EXPECT_EQ(bytes, sinew::test::text_of(folder_.at("records/" + record)));
  EXPECT_EQ(bytes.size(), list[0]["size_bytes"]);
  const auto content =
      runtime::read_mcap({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  EXPECT_FALSE(content.trouble);
  const std::string csv = whole(client, "records.csv", record);
  EXPECT_TRUE(csv.starts_with("t_s,base_position_rad")) << csv.substr(0, 80);
  EXPECT_GT(std::ranges::count(csv, '\n'), 50);

  EXPECT_EQ(code(client.call("records.remove", {{"record", record}})), "none");
  EXPECT_EQ(code(client.call("records.read", {{"record", record}})), "missing");
  EXPECT_EQ(code(client.call("records.csv", {{"record", record}})), "missing");
}

TEST_F(KeeperTest, a_cell_without_folders_says_so) {
  ApiCell bare({test::place("left", "learm", "bus")});
  ApiClient client(bare);
  EXPECT_EQ(code(client.call("programs.list", {{"robot", "left"}})), "none");
  EXPECT_EQ(code(client.call("record.start", {{"robot", "left"}})), "none");
  EXPECT_EQ(client.call("records.list")["result"]["records"].size(), 0u);
}

TEST(KeeperSettings, are_checked_kept_beside_the_cell_and_say_that_they_wait_for_a_start) {
  const ScratchFolder folder;
  CellRobot place = test::place("left", "learm", "bus");
  const auto settings_of = [&] {
    return runtime::CellSettings(folder.at("settings.json"), "cell.toml", 20,
                                 {{sinew::test::robot("learm"), place, {}}});
  };
  auto settings = settings_of();
  ApiCell cell({place}, 20, {}, {}, &settings);
  ApiClient client(cell);
  const Json before = client.call("settings.get", {{"robot", "left"}})["result"];
  EXPECT_EQ(before["is_set"], false);
  EXPECT_EQ(before["revision"], 0);
  EXPECT_EQ(before["now"]["profile"], "bus");
  EXPECT_EQ(before["restart"], false);
  const Json bad{{"profile", "bus"}, {"joint.base.trim_rad", "3"}};
  const Json checked =
      client.call("settings.check", {{"robot", "left"}, {"settings", bad}})["result"];
  EXPECT_EQ(checked["fine"], false);
  EXPECT_EQ(checked["complaints"][0]["name"], "joint.base.trim_rad");
  const auto set = [&](ApiClient& who, const Json& values, std::uint64_t revision) {
    return who.call("settings.set",
                    {{"robot", "left"}, {"settings", values}, {"revision", revision}});
  };
  EXPECT_EQ(set(client, bad, 0)["error"]["data"]["code"], "unfit");
  EXPECT_FALSE(std::filesystem::exists(folder.at("settings.json")));

  ApiClient viewer(cell, Role::kViewer);
  const Json good{{"profile", "bus"}, {"joint.base.trim_rad", "0.1"}};
  EXPECT_EQ(set(viewer, good, 0)["error"]["message"],
            "viewers watch and may stop; this is for operators");
  const Json saved = set(client, good, 0)["result"];
  EXPECT_EQ(saved["is_set"], true) << saved.dump();
  EXPECT_EQ(saved["restart"], true);
  EXPECT_EQ(saved["own"], before["own"]);
  EXPECT_EQ(set(client, good, 0)["error"]["data"]["code"], "conflict");
  auto next = settings_of();
  ASSERT_TRUE(next.load());
  EXPECT_EQ(next.now(0).at("joint.base.trim_rad"), "0.1");
  const Json back = set(client, Json::object(), saved["revision"])["result"];
  EXPECT_EQ(back["is_set"], false);
  EXPECT_EQ(back["restart"], false);
  // A cell that nobody gave a place for them.
  ApiCell bare({place});
  ApiClient other(bare);
  EXPECT_EQ(other.call("settings.get", {{"robot", "left"}})["error"]["data"]["code"], "none");
}

}  // namespace
}  // namespace sinew::server
