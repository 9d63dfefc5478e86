#include "sinew/devices/axis_link/axis_link_device.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "sinew/devices/axis_link/axis_link_test_axis.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace axis_link;
using namespace std::chrono_literals;
using test::LinkTestAxis;

/// A node, its axis, and a host that counts.
struct Bench {
  explicit Bench(std::uint16_t boot = 7)
      : joint(test::link_joint()),
        axis(joint),
        node(axis, axis_link_node_settings(joint, 2, boot)) {
    axis.place(0);
  }

  /// One full-duplex frame; what the axis answered.
  Frame exchange(const Frame& frame) {
    Frame answer{};
    node.select(true);
    for (std::size_t i = 0; i < frame.size(); ++i) answer[i] = node.shift(frame[i]);
    node.select(false);
    return answer;
  }
  Reply exchange(const Request& request) {
    const auto reply = decode_reply(exchange(encode(request)));
    EXPECT_TRUE(reply);
    return reply.value_or(Reply{});
  }
  Request request(Mode mode, double q = 0) {
    return {.axis = 2,
            .mode = mode,
            .sequence = ++sequence,
            .target = to_units(q).value(),
            .session = session};
  }
  /// What the axis says now.
  State look() {
    exchange(request(Mode::kRead));
    return std::get<State>(exchange(request(Mode::kRead)).body);
  }
  void greet(Duration deadline = 100ms) {
    const std::uint32_t hash = model_hash(axis_link_node_settings(joint, 2).model);
    exchange(axis_link::hello(2, ++sequence, hash, deadline));
    session = exchange(axis_link::hello(2, sequence, hash, deadline)).session;
  }
  void run_for(Duration duration) {
    for (const Instant end = now + duration; now < end;) {
      now += 1ms;
      axis.advance(now);
      node.advance(now);
    }
  }

  Joint joint;
  LinkTestAxis axis;
  AxisLinkNode node;
  Instant now{};
  std::uint16_t sequence = 100;
  std::uint8_t session = 0;
};

TEST(AxisLinkNode, moves_nothing_before_a_hello_of_its_model) {
  Bench bench;
  bench.exchange(bench.request(Mode::kTrack, 0.5));
  EXPECT_EQ(bench.look().verdict, Verdict::kNoSession);
  bench.exchange(axis_link::hello(2, ++bench.sequence, 0xDEAD, 100ms));
  EXPECT_EQ(bench.node.session(), 0);
  const Reply reply = bench.exchange(bench.request(Mode::kTrack, 0.5));
  const auto* identity = std::get_if<Identity>(&reply.body);
  ASSERT_NE(identity, nullptr) << "the frame after a hello says who it is";
  EXPECT_EQ(identity->model_hash, model_hash(axis_link_node_settings(bench.joint, 2).model));
  EXPECT_EQ(identity->boot, 7);
  EXPECT_GE(identity->uncertainty / kUncertaintyUnits, 2 * kPi / 4096);
  bench.greet();
  EXPECT_TRUE(bench.axis.targets.empty());
  bench.exchange(bench.request(Mode::kTrack, 0.5));
  EXPECT_EQ(bench.axis.targets.size(), 1U);
}

TEST(AxisLinkNode, deadlines_outside_20_to_500_ms_open_no_session) {
  for (const std::int32_t milliseconds : {0, 19, 501, -1, 100'000}) {
    Bench bench;
    Request hello =
        axis_link::hello(2, 1, model_hash(axis_link_node_settings(bench.joint, 2).model), 20ms);
    hello.velocity = milliseconds;
    bench.exchange(hello);
    EXPECT_EQ(bench.node.session(), 0) << milliseconds;
  }
}

TEST(AxisLinkNode, every_mode_does_what_it_says) {
  Bench bench;
  bench.greet();
  bench.exchange(bench.request(Mode::kTrack, 0.25));
  EXPECT_NEAR(bench.axis.targets.back(), 0.25, 1e-8);
  EXPECT_TRUE(bench.look().moving);
  Request track = bench.request(Mode::kTrack, 0.3);
  track.velocity = *to_velocity_units(-0.5);
  bench.exchange(track);
  EXPECT_EQ(bench.axis.feed_forward, -0.5);
  bench.exchange(bench.request(Mode::kHold));
  EXPECT_EQ(bench.axis.stops, 1);
  bench.run_for(50ms);
  bench.exchange(bench.request(Mode::kHold));
  EXPECT_EQ(bench.axis.stops, 1) << "it stands already";
  bench.exchange(bench.request(Mode::kMove, -0.5));
  EXPECT_NEAR(bench.axis.targets.back(), -0.5, 1e-8);
  bench.exchange(bench.request(Mode::kStop));
  EXPECT_EQ(bench.axis.stops, 2);
  bench.run_for(50ms);
  bench.exchange(bench.request(Mode::kHome));
  EXPECT_TRUE(bench.look().homing);
  bench.exchange(bench.request(Mode::kCancel));
  EXPECT_FALSE(bench.look().homing);
  bench.exchange(bench.request(Mode::kEmergencyStop));
  EXPECT_TRUE(bench.look().emergency_stopped);
  bench.exchange(bench.request(Mode::kHome));
  EXPECT_EQ(std::get<State>(bench.exchange(bench.request(Mode::kRead)).body).verdict,
            Verdict::kEmergencyStopped);
  bench.exchange(bench.request(Mode::kRelease));
  EXPECT_FALSE(bench.look().emergency_stopped);
  bench.axis.told().fault = AxisFault::kStalled;
  EXPECT_EQ(bench.look().fault, 2);
  bench.exchange(bench.request(Mode::kClearFaults));
  EXPECT_EQ(bench.look().fault, 0);
  bench.exchange(bench.request(Mode::kSelfTest));
  EXPECT_EQ(bench.axis.self_tests, 1);
  bench.axis.told().supply_volts = 24.0;
  bench.exchange(bench.request(Mode::kReadHealth));
  const Reply reply = bench.exchange(bench.request(Mode::kRead));
  EXPECT_EQ(std::get<Health>(reply.body), (Health{24000, std::nullopt}));
}

TEST(AxisLinkNode, an_answer_is_the_state_from_before_its_frame) {
  Bench bench;
  bench.greet();
  bench.exchange(bench.request(Mode::kMove, 1));
  bench.run_for(20ms);
  const double q = bench.axis.q();
  const Reply reply = bench.exchange(bench.request(Mode::kStop));
  const auto& state = std::get<State>(reply.body);
  EXPECT_NEAR(from_units(state.position), q, 1e-8);
  EXPECT_NEAR(state.velocity / kStateVelocityUnits, from_deg(100), 1e-3);
  EXPECT_TRUE(state.moving);
  EXPECT_EQ(reply.sequence, bench.sequence - 1) << "it names the frame before";
}

TEST(AxisLinkNode, repeats_and_old_frames_are_answered_and_not_executed) {
  Bench bench;
  bench.greet();
  const Request home = bench.request(Mode::kHome);
  bench.exchange(home);
  bench.exchange(home);
  bench.exchange(home);
  EXPECT_EQ(bench.axis.homings, 1);
  bench.exchange(bench.request(Mode::kCancel));
  bench.exchange(home);
  EXPECT_EQ(bench.axis.homings, 1);
  bench.axis.place(0);
  std::vector<Request> sent;
  for (int i = 0; i < 100; ++i) {
    sent.push_back(bench.request(Mode::kTrack, 0.001 * i));
    bench.exchange(sent.back());
  }
  const auto told = bench.axis.targets;
  for (const Request& old : sent) bench.exchange(old);
  EXPECT_EQ(bench.axis.targets, told);
}

TEST(AxisLinkNode, another_session_another_axis_and_far_numbers_are_ignored) {
  Bench bench;
  bench.greet();
  Request request = bench.request(Mode::kTrack, 0.5);
  request.session = static_cast<std::uint8_t>(bench.session + 1);
  bench.exchange(request);
  request = bench.request(Mode::kTrack, 0.5);
  request.axis = 3;
  const Reply reply = bench.exchange(request);
  EXPECT_EQ(reply.axis, 2) << "a host sees that it selected the wrong board";
  request = bench.request(Mode::kTrack, 0.5);
  request.sequence = static_cast<std::uint16_t>(request.sequence + kSequenceWindow);
  bench.exchange(request);
  EXPECT_TRUE(bench.axis.targets.empty());
}

TEST(AxisLinkNode, a_stop_to_all_needs_no_session_and_leaves_the_numbers_alone) {
  Bench bench;
  bench.greet();
  bench.exchange(bench.request(Mode::kMove, 1));
  bench.run_for(20ms);
  bench.exchange(Request{.axis = 5, .to_all = true, .mode = Mode::kStop});
  EXPECT_EQ(bench.axis.stops, 1);
  const Reply reply = bench.exchange(bench.request(Mode::kRead));
  EXPECT_EQ(reply.sequence, bench.sequence - 1);
  Bench stranger;
  stranger.exchange(Request{.to_all = true, .mode = Mode::kEmergencyStop});
  EXPECT_EQ(stranger.axis.emergency_stops, 1);
}

TEST(AxisLinkNode, silence_stops_what_moves_latched_and_closes_the_session) {
  for (const Duration deadline : {Duration{20ms}, Duration{100ms}, Duration{500ms}}) {
    Bench bench;
    bench.greet(deadline);
    bench.exchange(bench.request(Mode::kMove, 2));
    EXPECT_EQ(bench.node.next_event(), bench.now + deadline);
    bench.run_for(deadline - 1ms);
    EXPECT_EQ(bench.axis.stops, 0);
    bench.run_for(1ms);
    EXPECT_EQ(bench.axis.stops, 1);
    EXPECT_EQ(bench.axis.status().fault, AxisFault::kLinkSilent);
    EXPECT_EQ(bench.node.session(), 0);
    EXPECT_FALSE(bench.node.next_event());
    bench.exchange(bench.request(Mode::kMove, 2));
    bench.greet();
    bench.exchange(bench.request(Mode::kMove, 2));
    EXPECT_EQ(bench.axis.targets.size(), 1U) << "a new session does not clear the fault";
    EXPECT_EQ(std::get<State>(bench.exchange(bench.request(Mode::kRead)).body).verdict,
              Verdict::kFaulted);
  }
}

TEST(AxisLinkNode, silence_at_rest_closes_the_session_without_a_fault) {
  Bench bench;
  bench.greet();
  bench.run_for(100ms);
  EXPECT_EQ(bench.node.session(), 0);
  EXPECT_EQ(bench.axis.status().fault, AxisFault::kNone);
}

TEST(AxisLinkNode, only_new_frames_of_the_session_keep_the_deadline_away) {
  Bench bench;
  bench.greet();
  const Request read = bench.request(Mode::kRead);
  bench.exchange(read);
  Request foreign = bench.request(Mode::kRead);
  foreign.session = 99;
  for (int i = 0; i < 100; ++i) {
    bench.run_for(1ms);
    bench.exchange(read);
    bench.exchange(foreign);
    bench.exchange(Request{.to_all = true, .mode = Mode::kStop});
  }
  EXPECT_EQ(bench.node.session(), 0);
}

TEST(AxisLinkNode, a_new_hello_stops_what_moves_and_the_same_one_does_not) {
  Bench bench;
  bench.greet();
  const std::uint8_t first = bench.session;
  const std::uint16_t greeted = bench.sequence;
  bench.exchange(bench.request(Mode::kMove, 2));
  const std::uint32_t hash = model_hash(axis_link_node_settings(bench.joint, 2).model);
  bench.exchange(axis_link::hello(2, greeted, hash, 100ms));
  EXPECT_EQ(bench.node.session(), first);
  EXPECT_EQ(bench.axis.stops, 0);
  bench.greet();
  EXPECT_NE(bench.session, first);
  EXPECT_EQ(bench.axis.stops, 1);
}

TEST(AxisLinkNode, a_restarted_axis_starts_with_another_session) {
  Bench first(1);
  first.greet();
  Bench second(2);
  second.greet();
  EXPECT_NE(first.session, second.session);
  for (int boot = 0; boot < 600; ++boot) {
    Bench bench(static_cast<std::uint16_t>(boot));
    bench.greet();
    ASSERT_NE(bench.session, 0) << boot;
  }
}

TEST(AxisLinkNode, frames_of_other_lengths_are_not_frames) {
  for (std::size_t length = 1; length < 40; ++length) {
    if (length == kFrameSize) continue;
    Bench bench;
    bench.greet();
    const Frame frame = encode(bench.request(Mode::kTrack, 0.5));
    bench.node.select(true);
    for (std::size_t i = 0; i < length; ++i) bench.node.shift(frame[i % kFrameSize]);
    bench.node.select(false);
    EXPECT_TRUE(bench.axis.targets.empty()) << length;
    EXPECT_EQ(bench.node.bad_frames(), 1U);
    bench.exchange(bench.request(Mode::kTrack, 0.5));
    EXPECT_EQ(bench.axis.targets.size(), 1U) << "the next frame is good again";
  }
}

TEST(AxisLinkNode, every_single_flip_of_a_frame_changes_nothing) {
  Bench bench;
  bench.greet();
  bench.exchange(bench.request(Mode::kTrack, 0.125));
  const Frame good = encode(bench.request(Mode::kTrack, 0.5));
  for (std::size_t bit = 0; bit < 128; ++bit) {
    Frame frame = good;
    frame[bit / 8] = static_cast<std::uint8_t>(frame[bit / 8] ^ 1U << (bit % 8));
    bench.exchange(frame);
  }
  EXPECT_EQ(bench.axis.targets, std::vector<double>{0.125});
  EXPECT_EQ(bench.node.bad_frames(), 128U);
  bench.exchange(good);
  EXPECT_EQ(bench.axis.targets.back(), 0.5);
}

TEST(AxisLinkNode, the_stream_form_answers_its_own_frames_and_no_others) {
  Bench bench;
  const auto send = [&](const Request& request) {
    bench.node.receive(cobs::encode(encode(request)));
    std::array<std::uint8_t, 7> piece{};
    std::vector<Reply> replies;
    cobs::Decoder decoder;
    while (const std::size_t count = bench.node.take_output(piece)) {
      for (std::size_t i = 0; i < count; ++i) {
        const auto frame = decoder.push(piece[i]);
        if (!frame) continue;
        EXPECT_EQ(frame->size(), kFrameSize);
        replies.push_back(decode_reply(frame->first<kFrameSize>()).value());
      }
    }
    return replies;
  };
  const std::uint32_t hash = model_hash(axis_link_node_settings(bench.joint, 2).model);
  EXPECT_EQ(send(axis_link::hello(2, 500, hash, 100ms)).size(), 1U);
  bench.sequence = 500;
  bench.session = bench.node.session();
  const auto identity = send(bench.request(Mode::kTrack, 0.5));
  ASSERT_EQ(identity.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<Identity>(identity[0].body));
  EXPECT_EQ(bench.axis.targets.size(), 1U);
  Request other = bench.request(Mode::kRead);
  other.axis = 1;
  EXPECT_TRUE(send(other).empty()) << "on a shared line only the one that is meant speaks";
  EXPECT_TRUE(send(Request{.to_all = true, .mode = Mode::kStop}).empty());
  EXPECT_EQ(bench.axis.stops, 1);
  // Noise between the frames, and a frame that was cut.
  bench.node.receive(std::array<std::uint8_t, 5>{9, 9, 9, 9, 9});
  EXPECT_EQ(send(bench.request(Mode::kRead)).size(), 1U);
}

TEST(AxisLinkNode, no_bytes_on_the_stream_do_more_than_frames_can) {
  test::for_random_cases(5000, [](test::Random& random) {
    Bench bench;
    bench.greet();
    for (int piece = 0; piece < 8; ++piece) {
      cobs::Stream stream = cobs::encode(encode(bench.request(Mode::kTrack, 0.5)));
      const std::int64_t hits = random.integer(1, 3);
      for (std::int64_t i = 0; i < hits; ++i) {
        auto& byte = stream[static_cast<std::size_t>(random.integer(1, 16))];
        byte = static_cast<std::uint8_t>(byte ^ random.integer(1, 255));
      }
      bench.node.receive(stream);
    }
    for (const double target : bench.axis.targets) ASSERT_EQ(target, 0.5);
    const std::size_t before = bench.axis.targets.size();
    bench.node.receive(cobs::encode(encode(bench.request(Mode::kTrack, 0.25))));
    ASSERT_EQ(bench.axis.targets.size(), before + 1);
  });
}

TEST(AxisLinkNode, a_position_that_does_not_fit_is_not_told_as_another) {
  Bench bench;
  bench.greet();
  bench.axis.place(40);
  EXPECT_FALSE(bench.look().position_ok);
  bench.axis.place(std::nan(""));
  EXPECT_FALSE(bench.look().position_ok);
}

TEST(AxisLinkNode, nothing_allocates) {
  Bench bench;
  bench.axis.keep_record = false;
  const test::AllocationCounter counter;
  bench.greet();
  bench.exchange(bench.request(Mode::kTrack, 0.5));
  bench.node.receive(cobs::encode(encode(bench.request(Mode::kRead))));
  bench.run_for(200ms);
  EXPECT_EQ(counter.count(), 0U);
}

}  // namespace
}  // namespace sinew
