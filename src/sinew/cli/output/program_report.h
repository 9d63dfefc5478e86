#pragma once

#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/program/runs/program_run.h"
#include "sinew/runtime/links/driver_line.h"
#include "sinew/sim/machine.h"

namespace sinew::cli {

/// Where the joints were at one instant of a run, as the driver knew it.
struct JointSample {
  double t = 0;                                    ///< s since the first order
  JointVector q;                                   ///< not a number where a joint is lost
  FixedVector<JointInterval, kMaxJoints> within;   ///< the same
  PositionQuality worst = PositionQuality::kLost;  ///< of all joints
};

/// Collects samples while a program runs, at most one in 10 ms.
class SampleRecorder {
 public:
  void look(const program::Run& run, Instant now);
  /// The last sample, however soon behind the one before.
  void end(const program::Run& run, Instant now);
  const std::vector<JointSample>& samples() const { return samples_; }

 private:
  std::vector<JointSample> samples_;
  Instant start_{};
  Instant next_{};
};

/// All that is to be told about a run that is over.
struct ProgramReport {
  const RobotModel& model;
  const program::Run& run;
  DriverHealth health;
  runtime::ByteCount bytes;
  bool left_at_once = false;
  std::optional<sim::Truth> truth;  ///< of the machine that was simulated for it
  Instant now{};                    ///< when the run was over
};

Json program_json(const ProgramReport& report);
std::string program_text(const ProgramReport& report);
std::string program_csv(const RobotModel& model, const std::vector<JointSample>& samples);
std::string program_svg(const RobotModel& model, const std::vector<JointSample>& samples,
                        const std::string& title);

/// "base 12.30, shoulder -4.00..5.00, elbow lost; deg".
std::string standing_text(std::span<const JointPosition> positions, const RobotModel& model);
/// One entry a joint: quality, and where it is known q and its bounds.
Json positions_json(std::span<const JointPosition> positions, const RobotModel& model);

/// "3.20 s, line 4: shoulder is at ...", s since the run began.
std::string notice_text(const program::Notice& notice, const program::Run& run,
                        const RobotModel& model);

/// "4"; of a called program "place 4".
std::string first_line(const program::Order& order, const program::Run& run);

/// "; the machine goes on ..": where a run ended and its motion did not; else empty.
std::string goes_on_text(const ProgramReport& report);

}  // namespace sinew::cli
