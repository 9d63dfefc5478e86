#pragma once

#include <string>

#include "sinew/planning/paths/tool_space.h"
#include "sinew/runtime/records/look_encoder.h"
#include "sinew/runtime/records/mcap_writer.h"
#include "sinew/runtime/records/run_sample.h"

namespace sinew::runtime {

/// What a record is about.
struct RecordTitle {
  std::string robot;         ///< its name in the cell, or its id: the channels begin with it
  std::string program;       ///< empty: none
  std::string library;       ///< what writes it: "sinew 0.4"
  std::int64_t wall_ns = 0;  ///< since 1970, of `start`
  Instant start{};           ///< times of the run are counted from it
};

/// Samples and events of one robot as the messages of an MCAP file, in JSON with JSON schemas; SI
/// and radians, the unit in each number's name. docs/records.md has the channels. Times of the
/// record are those of the run, begun at a wall clock: a clock that is set meanwhile moves nothing.
class RecordEncoder {
 public:
  /// @param robot  outlives this
  RecordEncoder(const RobotModel& robot, const RecordTitle& title, McapWriter::Sink sink);

  /// In the order of their times.
  void add(const RunSample& sample);
  void add(const RunEvent& event);
  void add(const RunPicture& picture);
  void add(const RunDecision& decision);
  /// So many samples and events have not come through: the record says so.
  void add_lost(std::uint64_t count, Instant at);
  /// What has been added so far leaves for the sink.
  void flush() { writer_.end_chunk(); }
  void finish();

  /// What the file had no more room for, and what add_lost() told.
  std::uint64_t lost() const { return lost_; }
  std::uint64_t messages() const { return writer_.messages(); }

 private:
  void put(std::uint16_t channel, Instant at, std::string_view text);
  void put_joints(const RunSample& sample);
  void put_state(const RunSample& sample);
  void put_wire(const RunSample& sample);
  void put_tool(const RunSample& sample);
  std::uint64_t time(Instant at) const;

  const RobotModel& robot_;
  RecordTitle title_;
  planning::ToolSpace tool_;
  std::optional<double> jaws_;  ///< m, that it is for
  planning::PoseBT X_near_;
  McapWriter writer_;
  LookEncoder looks_;
  std::uint16_t joints_channel_ = 0;
  std::uint16_t state_channel_ = 0;
  std::uint16_t events_channel_ = 0;
  std::uint16_t wire_channel_ = 0;
  std::uint16_t tool_channel_ = 0;
  std::optional<RunSample> wire_before_;
  std::optional<RunSample> state_before_;
  Instant last_{};
  std::uint64_t lost_ = 0;
};

}  // namespace sinew::runtime
