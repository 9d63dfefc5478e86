#pragma once

#include <string>

#include "motion/motion_bench.h"
#include "motion/sample_judge.h"

namespace sinew::planning {

/// One random sequence of plan, follow, override, pause, resume, stop and jog on a bench. It stands
/// somewhere at first, every sample is judged, and at the end it has come to rest.
class RandomSequence {
 public:
  RandomSequence(MotionBench& bench, std::uint64_t seed, MotionSums& sums);

  /// What is wrong, and after which commands; empty where nothing is.
  std::string run();
  /// Of all samples: the same run, the same number.
  std::uint64_t digest() const { return digest_; }

 private:
  enum class Mode : std::uint8_t {
    kStands,  ///< nobody moves it
    kLaw,     ///< along a law that is followed as it is
    kPath,    ///< PathFollower has it
    kJog,
  };
  /// What a refusal must not change.
  struct Snapshot {
    JointMotion motion;
    PathState state;
    double feed = 0;
    double time_left = 0;
    bool paused = false;
    bool stopped = false;
    JogStatus jog;
    bool operator==(const Snapshot& other) const;
  };

  bool begin();
  bool command();
  bool fail(const std::string& what);
  void note(const char* what) { history_ += std::string(" ") + what; }
  Snapshot snapshot() const;
  bool unchanged(const Snapshot& before);
  bool refused(const Error& error, bool asked_nonsense);
  double random_step();

  // Planned motions.
  bool plan();
  bool plan_from_nowhere();
  bool plan_ahead();
  bool start(const PlannedMotion& motion);
  bool follow();
  bool follow_one(double dt);
  bool follow_law(double dt);
  bool arrive();
  bool override_feed();
  bool pause_or_resume();
  bool stop_path();
  bool rest_on_path(double predicted);
  double straight_stop() const;

  // Jogs.
  bool jog();
  bool start_jog();
  bool jog_command();
  bool hostile_jog_command();
  bool hold_jog();
  bool jog_one(double dt);
  bool stop_jog();
  bool step_outside();

  bool judge(const JointMotion& now, double dt);
  bool judge_way_in(const JointMotion& now);
  double asked_ahead(double s) const;
  bool judge_tool();
  bool judge_tool_acceleration(double acceleration, const PathSection& section,
                               const PathState& state);
  bool judge_contact();
  bool settle();
  /// Where it stands now, of which a plan may begin.
  bool take_place();

  MotionBench& bench_;
  test::Random random_;
  MotionSums& sums_;
  SampleJudge judge_;
  Mode mode_ = Mode::kStands;
  RobotPlace place_;  ///< where it stands, and while it moves the last pose that was looked at
  const PlannedMotion* under_way_ = nullptr;
  std::size_t fresh_ = 0;  ///< the bench's plan that is free
  double law_time_ = 0;
  double feed_bound_ = 1;    ///< what the tool may still have of its asked-for speed
  double clearance_ = 0;     ///< m that samples must keep
  bool outside_ = false;     ///< began outside of its limits
  bool overlaps_ = false;    ///< a jog did, when it was looked at last
  bool taken_over_ = false;  ///< a jog out of a planned motion, which nobody held against contact
  std::uint64_t look_ = 0;
  std::uint64_t digest_ = 0;
  std::string history_;
  std::string complaint_;
};

}  // namespace sinew::planning
