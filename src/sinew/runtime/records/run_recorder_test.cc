#include "sinew/runtime/records/run_recorder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "sinew/core/error_code.h"
#include "sinew/runtime/records/mcap_reader.h"
#include "sinew/runtime/records/record_pictures.h"
#include "sinew/vision/picture_file.h"
#include "support/allocation_guard.h"
#include "support/property.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

/// Files of the recorder on a real disk, read with the strict reader.
namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;
using control::ControlEvent;
using control::StopCause;
using test::ScratchFolder;
using Json = nlohmann::json;

constexpr std::int64_t kWall = 1'795'305'600'123'000'000;  // 2026-11-22T00:00:00.123Z

/// A record, sorted by the last part of its topics.
struct Record {
  std::string bytes;
  McapContent content;
  std::map<std::string, std::vector<std::pair<std::uint64_t, Json>>> messages;

  explicit Record(const std::string& path) : bytes(test::text_of(path)) {
    content = read_mcap({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    EXPECT_FALSE(content.trouble) << path << ": " << content.trouble->sentence;
    for (const McapMessage& message : content.messages) {
      const std::string& topic = content.channels.at(message.channel).topic;
      messages[topic.substr(topic.rfind('/') + 1)].emplace_back(message.time,
                                                                Json::parse(message.data));
    }
  }
};

RunSample sample_at(const RobotModel& robot, Instant at, double q) {
  RunSample sample;
  sample.at = at;
  sample.state = control::MachineState::kMoving;
  sample.connected = true;
  JointVector commanded;
  for (const Joint& joint : robot.joints) {
    const double place = joint.home + q;
    sample.positions.push_back({PositionQuality::kMeasured, place, place - 0.01, place + 0.01});
    commanded.push_back(place + 0.001);
  }
  sample.commanded = commanded;
  return sample;
}

ControlEvent fault_event(StopCause cause = StopCause::kDevice) {
  return {.kind = ControlEvent::Kind::kLatched,
          .command = 0,
          .state = control::MachineState::kFault,
          .cause = cause,
          .error = {ErrorCode::kDeviceSilent, -1, 0.2, 0.1},
          .lease = {}};
}

Instant at(Duration since) {
  return Instant{} + since;
}

class Recorder : public testing::Test {
 protected:
  RunRecorder make(const std::string& flight = "") {
    return RunRecorder(robot_, {"arm", "test", flight}, Instant{}, kWall);
  }
  /// 100 Hz from `from` to before `to`; the ring never fills.
  void offer(RunRecorder& recorder, Duration from, Duration to) {
    int waiting = 0;
    for (Duration t = from; t < to; t += RunRecorder::kPeriod) {
      recorder.offer(sample_at(robot_, at(t), 0.001 * to_seconds(t)));
      if (++waiting % 500 == 0) recorder.settle();
    }
    recorder.settle();
  }

  RobotModel robot_ = test::robot("learm");
  ScratchFolder folder_;
};

TEST_F(Recorder, writes_what_was_commanded_measured_and_sent) {
  RunRecorder recorder = make();
  ASSERT_TRUE(recorder.begin({folder_.at(), "run.mcap", "a.sinew"}));
  for (int k = 0; k < 300; ++k) {
    RunSample sample = sample_at(robot_, at(k * 10ms), 0.001 * k);
    sample.bytes = {static_cast<std::size_t>(7 * k), static_cast<std::size_t>(3 * k)};
    if (k >= 200) sample.positions[0].quality = PositionQuality::kLost;
    recorder.offer(sample);
  }
  recorder.offer(fault_event(), at(2990ms));
  const auto told = recorder.end();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->trouble, "");
  EXPECT_EQ(told->lost, 0U);
  const Record record(told->path);
  const auto& joints = record.messages.at("joint_states");
  ASSERT_EQ(joints.size(), 300U);
  const std::string name = robot_.joints[0].name;
  const Json& first = joints[50].second["joints"][name];
  EXPECT_DOUBLE_EQ(first["position_rad"], robot_.joints[0].home + 0.05);
  EXPECT_DOUBLE_EQ(first["commanded_rad"], robot_.joints[0].home + 0.051);
  EXPECT_EQ(first["quality"], "measured");
  EXPECT_EQ(joints[50].first, static_cast<std::uint64_t>(kWall) + 500'000'000U);
  const Json& lost = joints[250].second["joints"][name];
  EXPECT_EQ(lost["quality"], "lost");
  EXPECT_FALSE(lost.contains("position_rad"));
  // The tool is told where it is known, and nowhere else.
  EXPECT_EQ(record.messages.at("tool").size(), 200U);
  EXPECT_EQ(record.messages.at("wire").size(), 30U);
  EXPECT_NEAR(record.messages.at("wire")[5].second["to_device_bytes_s"], 700, 1e-6);
  EXPECT_NEAR(record.messages.at("wire")[5].second["to_host_bytes_s"], 300, 1e-6);
  ASSERT_EQ(record.messages.at("events").size(), 1U);
  EXPECT_EQ(record.messages.at("events")[0].second["kind"], "fault");
  EXPECT_EQ(record.messages.at("events")[0].second["error"]["code"], "device_silent");
  EXPECT_EQ(record.content.metadata.at("sinew.run").at("program"), "a.sinew");
}

TEST_F(Recorder, tells_where_the_tool_was) {
  RunRecorder recorder = make();
  ASSERT_TRUE(recorder.begin({folder_.at(), "run.mcap", ""}));
  const RunSample sample = sample_at(robot_, at(0ms), 0.1);
  recorder.offer(sample);
  const Record record(recorder.end()->path);
  JointVector q;
  for (const JointPosition& position : sample.positions) q.push_back(position.q);
  const planning::ToolSpace space(robot_);
  const auto X_BT = space.forward({q.data(), q.size()}, space.home());
  ASSERT_TRUE(X_BT);
  const Json& pose = record.messages.at("tool").at(0).second["pose"];
  EXPECT_DOUBLE_EQ(pose["position"]["x"], X_BT->p.x);
  EXPECT_DOUBLE_EQ(pose["position"]["z"], X_BT->p.z);
  EXPECT_DOUBLE_EQ(pose["orientation"]["w"], quaternion_wxyz(X_BT->R)[0]);
}

TEST_F(Recorder, legs_are_in_metres) {
  robot_ = test::robot("hexapod");
  RunRecorder recorder = make();
  ASSERT_TRUE(recorder.begin({folder_.at(), "run.mcap", ""}));
  recorder.offer(sample_at(robot_, at(0ms), 0));
  const Record record(recorder.end()->path);
  const Json& leg =
      record.messages.at("joint_states").at(0).second["joints"][robot_.joints[0].name];
  EXPECT_DOUBLE_EQ(leg["position_m"], robot_.joints[0].home);
}

TEST_F(Recorder, keeps_ten_seconds_before_a_fault_and_one_behind_it) {
  RunRecorder recorder = make(folder_.at());
  offer(recorder, 0s, 25s);
  recorder.offer(fault_event(), at(25s));
  offer(recorder, 25s, 25500ms);
  // More causes of the same fault do not make more files.
  recorder.offer(fault_event(StopCause::kDevice), at(25500ms));
  recorder.settle();
  EXPECT_FALSE(recorder.take_told());
  offer(recorder, 25500ms, 30s);
  const auto told = recorder.take_told();
  ASSERT_TRUE(told);
  EXPECT_FALSE(recorder.take_told());
  EXPECT_EQ(told->trouble, "");
  EXPECT_EQ(told->fault, StopCause::kDevice);
  EXPECT_EQ(told->path, folder_.at("arm_fault-device_20261122T000025.123Z.mcap"));
  const Record record(told->path);
  const auto& joints = record.messages.at("joint_states");
  EXPECT_EQ(joints.front().first, static_cast<std::uint64_t>(kWall) + 15'000'000'000U);
  EXPECT_EQ(joints.back().first, static_cast<std::uint64_t>(kWall) + 26'000'000'000U);
  EXPECT_EQ(joints.size(), 1101U);
  EXPECT_EQ(record.messages.at("events").size(), 2U);
}

TEST_F(Recorder, fault_at_the_very_end_is_kept_too) {
  {
    RunRecorder recorder = make(folder_.at());
    offer(recorder, 0s, 3s);
    recorder.offer(fault_event(), at(3s));
  }
  ASSERT_EQ(folder_.names().size(), 1U);
  EXPECT_EQ(Record(folder_.at(folder_.names()[0])).messages.at("joint_states").size(), 300U);
}

TEST_F(Recorder, keeps_the_twenty_newest_runs_and_touches_nothing_else) {
  folder_.file("arm_fault-device_20261122T000000.123Z.mcap", "a fault");
  folder_.file("my_run.mcap", "mine");
  {
    RunRecorder recorder = make();
    for (int k = 0; k < 23; ++k) {
      const RecordPlace place =
          run_place(folder_.at(), "arm", "programs/wave.sinew", kWall + k * 1'000'000'000LL);
      EXPECT_EQ(place.size_max, RunRecorder::kRunSizeMax);
      ASSERT_TRUE(recorder.begin(place));
      offer(recorder, k * 1s, k * 1s + 50ms);
      recorder.end();
    }
  }
  EXPECT_EQ(folder_.names().size(), 22U);
  EXPECT_TRUE(std::filesystem::exists(folder_.at("my_run.mcap")));
  EXPECT_TRUE(std::filesystem::exists(folder_.at("arm_fault-device_20261122T000000.123Z.mcap")));
  EXPECT_FALSE(std::filesystem::exists(folder_.at("arm_run-wave_20261122T000002.123Z.mcap")));
  EXPECT_TRUE(std::filesystem::exists(folder_.at("arm_run-wave_20261122T000003.123Z.mcap")));
  const Record newest(folder_.at("arm_run-wave_20261122T000022.123Z.mcap"));
  EXPECT_FALSE(newest.messages.at("joint_states").empty());
}

TEST_F(Recorder, keeps_fifty_faults_and_touches_nothing_else) {
  folder_.file("notes_fault-mine.txt", "mine");
  folder_.file("run.mcap", "mine");
  {
    RunRecorder recorder = make(folder_.at());
    for (int k = 0; k < 55; ++k) {
      recorder.offer(fault_event(), at(k * 2s));
      offer(recorder, k * 2s + 10ms, k * 2s + 30ms);
    }
  }
  const auto names = folder_.names();
  EXPECT_EQ(names.size(), 52U);
  EXPECT_TRUE(std::filesystem::exists(folder_.at("notes_fault-mine.txt")));
  EXPECT_TRUE(std::filesystem::exists(folder_.at("run.mcap")));
  EXPECT_TRUE(std::filesystem::exists(folder_.at("arm_fault-device_20261122T000148.123Z.mcap")));
}

/// As fast as it goes: what the ring has no room for is counted, and told in the file.
TEST_F(Recorder, nothing_is_lost_silently) {
  test::for_random_cases(3, [&](test::Random& random) {
    RunRecorder recorder = make();
    ASSERT_TRUE(recorder.begin({folder_.at(), "run.mcap", ""}));
    const auto count = static_cast<std::size_t>(random.integer(6000, 9000));
    for (std::size_t k = 0; k < count; ++k) {
      recorder.offer(sample_at(robot_, at(static_cast<std::int64_t>(k) * 10ms), 0));
    }
    const auto told = recorder.end();
    ASSERT_TRUE(told);
    const Record record(told->path);
    EXPECT_EQ(record.messages.at("joint_states").size() + told->lost, count);
    EXPECT_EQ(told->lost, recorder.lost());
    // Text takes a hundred times as long to make as a sample to offer.
    EXPECT_GT(told->lost, 0U);
    std::size_t in_events = 0;
    const auto events = record.messages.find("events");
    if (events != record.messages.end()) {
      for (const auto& [time, event] : events->second)
        in_events += event["lost"].get<std::size_t>();
    }
    EXPECT_EQ(in_events, told->lost);
  });
}

TEST_F(Recorder, control_side_takes_no_memory) {
  RunRecorder recorder = make(folder_.at());
  const RunSample sample = sample_at(robot_, at(0ms), 0);
  const ControlEvent event = fault_event();
  const test::AllocationCounter counter;
  for (int k = 0; k < 100; ++k) recorder.offer(sample);
  recorder.offer(event, at(0ms));
  EXPECT_EQ(counter.count(), 0U);
}

TEST_F(Recorder, full_disk_is_told) {
  RunRecorder recorder = make();
  ASSERT_TRUE(recorder.begin({"/dev", "full", ""}));
  offer(recorder, 0s, 5s);
  const auto told = recorder.end();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->trouble, "the disk is full");
  EXPECT_GT(told->lost, 0U);
}

TEST_F(Recorder, a_wanted_file_and_that_of_a_job_do_not_know_each_other) {
  RunRecorder recorder = make();
  EXPECT_FALSE(recorder.under_way());
  ASSERT_TRUE(recorder.begin({folder_.at(), "wanted.mcap", ""}, RecordSlot::kWanted));
  offer(recorder, 0s, 1s);
  ASSERT_TRUE(recorder.begin({folder_.at(), "job.mcap", ""}));
  offer(recorder, 1s, 2s);
  ASSERT_TRUE(recorder.end());
  offer(recorder, 2s, 3s);
  recorder.settle();
  ASSERT_TRUE(recorder.under_way());
  EXPECT_EQ(recorder.under_way()->name, "wanted.mcap");
  EXPECT_NEAR(recorder.under_way()->length, 3, 0.05);
  ASSERT_TRUE(recorder.end(RecordSlot::kWanted));
  EXPECT_FALSE(recorder.under_way());
  const auto samples = [&](const char* name) {
    return Record(folder_.at(name)).messages.at("joint_states").size();
  };
  EXPECT_NEAR(static_cast<double>(samples("wanted.mcap")), 300, 5);
  EXPECT_NEAR(static_cast<double>(samples("job.mcap")), 100, 5);
}

TEST_F(Recorder, a_wanted_file_that_is_full_ends_whole_by_itself) {
  constexpr std::uint64_t kMost = 100'000;
  RunRecorder recorder = make();
  ASSERT_TRUE(recorder.begin({folder_.at(), "run.mcap", "", kMost}, RecordSlot::kWanted));
  offer(recorder, 0s, 20s);
  recorder.settle();
  EXPECT_FALSE(recorder.under_way());
  EXPECT_FALSE(recorder.end(RecordSlot::kWanted));
  const auto told = recorder.take_told();
  ASSERT_TRUE(told);
  EXPECT_TRUE(told->full);
  EXPECT_EQ(told->trouble, "");
  const Record record(told->path);
  EXPECT_GT(record.bytes.size(), kMost);
  EXPECT_LT(record.bytes.size(), kMost + 600'000);
}

TEST_F(Recorder, a_wanted_file_ends_with_the_disk_and_says_so) {
  RunRecorder recorder = make();
  ASSERT_TRUE(recorder.begin({"/dev", "full", ""}, RecordSlot::kWanted));
  offer(recorder, 0s, 5s);
  recorder.settle();
  EXPECT_FALSE(recorder.under_way());
  const auto told = recorder.take_told();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->trouble, "the disk is full");
}

TEST_F(Recorder, folder_that_cannot_be_had_is_told) {
  const std::string file = folder_.file("file", "");
  RunRecorder recorder = make(file + "/flight");
  EXPECT_FALSE(recorder.begin({file + "/runs", "run.mcap", ""}));
  recorder.offer(fault_event(), at(0s));
  offer(recorder, 0s, 2s);
  const auto told = recorder.take_told();
  ASSERT_TRUE(told);
  EXPECT_NE(told->trouble, "");
}

/// What a program looked at.
RunLook look_at(Duration since, int seed) {
  Camera::Shot shot;
  shot.picture = vision::black_picture(64, 48);
  for (std::size_t i = 0; i < shot.picture.rgb.size(); ++i) {
    shot.picture.rgb[i] = static_cast<std::uint8_t>(100 + seed + i % 50);
  }
  vision::SeenCube cube;
  cube.color = vision::ColorName::kGreen;
  cube.top = {{{10, 10}, {20, 10}, {20, 20}, {10, 20}}};
  cube.confidence = 0.75;
  shot.seen.cubes.push_back(cube);
  shot.seen.refused.push_back({cube.top, "it is white or grey", vision::Height::kLikely, {}});
  return RunPicture{at(since), "top", std::make_shared<const Camera::Shot>(std::move(shot))};
}

RunLook decision_at(Duration since) {
  program::Decision decision;
  decision.kind = program::Decision::Kind::kPick;
  decision.line = 3;
  decision.grasp = 2;
  decision.cube = grasping::Cube{{0.15, -0.02, 0.0125}, 0.3, 0.025, 0};
  return RunDecision{at(since), decision};
}

TEST_F(Recorder, pictures_and_decisions_are_in_the_file_and_can_be_taken_out) {
  RunRecorder recorder = make();
  ASSERT_TRUE(recorder.begin({folder_.at(""), "run.mcap", "sort"}));
  offer(recorder, 0s, 1s);
  recorder.add(look_at(1s, 1));
  recorder.add(decision_at(1010ms));
  offer(recorder, 1020ms, 2s);
  recorder.add(look_at(2s, 2));
  ASSERT_TRUE(recorder.end());
  const Record record(folder_.at("run.mcap"));
  ASSERT_EQ(record.messages.at("top").size(), 2U);
  EXPECT_EQ(record.messages.at("top")[0].first, static_cast<std::uint64_t>(kWall) + 1'000'000'000);
  const Json& annotations = record.messages.at("annotations").at(0).second;
  ASSERT_EQ(annotations.at("points").size(), 2U);
  EXPECT_EQ(annotations.at("points")[0].at("points")[2].at("x"), 20);
  EXPECT_EQ(annotations.at("texts")[0].at("text"), "green 0.75");
  EXPECT_EQ(annotations.at("texts")[1].at("text"), "it is white or grey");
  const Json& decision = record.messages.at("decisions").at(0).second;
  EXPECT_EQ(decision.at("kind"), "pick");
  EXPECT_EQ(decision.at("cube").at("color"), "red");
  EXPECT_EQ(decision.at("grasp"), 2);
  const auto pictures = record_pictures(record.content);
  ASSERT_TRUE(pictures) << pictures.error();
  ASSERT_EQ(pictures->size(), 2U);
  EXPECT_EQ((*pictures)[1].name, "0002_top_2.00s.jpg");
  const std::string& jpeg = (*pictures)[1].jpeg;
  const auto picture =
      vision::decode_picture({reinterpret_cast<const std::uint8_t*>(jpeg.data()), jpeg.size()});
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->width, 64);
  EXPECT_NEAR(picture->rgb[0], 102, 12);
  const auto csv = decisions_csv(record.content);
  ASSERT_TRUE(csv);
  EXPECT_TRUE(csv->contains("1.010,3,\"pick\",2,\"red\",150,-20,12.5,17.1887,\"\"\n")) << *csv;
}

TEST_F(Recorder, a_fault_has_what_was_seen_before_it) {
  RunRecorder recorder = make(folder_.at(""));
  recorder.add(look_at(0s, 0));
  for (int i = 1; i <= 9; ++i) {
    offer(recorder, std::chrono::seconds(2 * i), std::chrono::seconds(2 * i + 1));
    recorder.add(look_at(std::chrono::milliseconds(2000 * i + 1000), i));
  }
  recorder.offer(fault_event(), at(20s));
  offer(recorder, 20s, 22s);
  recorder.settle();
  const auto told = recorder.take_told();
  ASSERT_TRUE(told);
  const Record record(told->path);
  EXPECT_EQ(record.messages.at("top").size(), RunRecorder::kLooksMax);
  std::uint64_t before = 0;
  for (const McapMessage& message : record.content.messages) {
    EXPECT_GE(message.time, before);
    before = message.time;
  }
}

TEST(RecordName, holds_no_letter_that_a_folder_would_misread) {
  EXPECT_EQ(record_name("left", "../pick & place.sinew", kWall),
            "left_---pick---place-sinew_20261122T000000.123Z.mcap");
  // .. and room for "-2" where there is one of that name.
  EXPECT_LE(record_name(std::string(500, 'a'), std::string(500, 'b'), kWall).size() + 4,
            Disk::kNameMax);
}

}  // namespace
}  // namespace sinew::runtime
