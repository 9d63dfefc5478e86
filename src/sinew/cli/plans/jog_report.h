#pragma once

#include <string>
#include <vector>

#include "sinew/cli/output/plan_report.h"
#include "sinew/planning/jog/jog.h"

namespace sinew::cli {

/// A while with one reason for a jog's speed.
struct JogStretch {
  double begin = 0;  ///< s
  double end = 0;    ///< s
  planning::JogReason reason = planning::JogReason::kNone;
  std::array<double, kMaxJoints> blamed{};  ///< s, of each joint
  double least = 1;                         ///< share of the speed asked for
  double most = 0;
  double nearest = 0;  ///< m, of an overlap

  /// The one that was blamed longest; -1 where none was.
  int joint() const;
};

/// What a simulated jog did.
struct JogRecord {
  MotionPlan plan;
  std::string frame;
  std::vector<JogStretch> stretches;
  std::vector<std::string> notes;
  double let_go = 0;      ///< s
  double way_before = 0;  ///< m of the tool until then

  /// The next `dt` s, which end at t.
  void note(double t, double dt, const planning::JogStatus& status);
  /// Whatever hardly lasts, and goes on with another joint for the same reason, becomes one: no
  /// more stretches than anybody reads, and none of the time is lost.
  void join_stretches();
};

Json jog_json(const JogRecord& record);
std::string jog_text(const JogRecord& record);

}  // namespace sinew::cli
