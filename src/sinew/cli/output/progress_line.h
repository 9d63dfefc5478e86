#pragma once

#include <cstddef>
#include <string>

#include "sinew/program/runs/program_run.h"

namespace sinew::cli {

/// How a run gets on, on stderr: one line that is written over on a terminal, a line per order into
/// a log.
class ProgressLine {
 public:
  /// @param waits_for  shown until the device has answered
  explicit ProgressLine(bool quiet, std::string waits_for = "the device");
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const program::Run& run, const RobotModel& model, Instant now);
  /// The terminal's line is free again.
  void end();

 private:
  struct View {
    bool opening = false;
    bool stopping = false;
    double share = 0;  ///< that is behind the run, 0..1
    std::string amount;
    std::string under_way;
    std::size_t orders_done = 0;
  };
  void show_live(const View& view, Instant now);
  void tell_wait(const program::Run& run, Instant now);
  void tell_notices(const program::Run& run, const RobotModel& model);
  bool due(Instant now) const { return live_ && now >= next_; }

  bool quiet_;
  std::string waits_for_;
  bool live_;
  bool dirty_ = false;
  std::size_t told_ = 0;
  std::size_t notices_told_ = 0;
  bool wait_told_ = false;
  Instant next_{};
};

/// "40 s", "2 min": how long something has taken.
std::string elapsed_text(double seconds);
/// "at most 90 s", "at most 8 min": rounded up.
std::string at_most_text(double seconds);
/// "homing elbow (2 min of at most 8 min)"; the bound is left out where nobody knows one.
/// @param joint  empty between two joints
std::string homing_text(const std::string& joint, double elapsed_s, double at_most_s);

}  // namespace sinew::cli
