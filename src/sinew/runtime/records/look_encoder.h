#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "sinew/model/robot_model.h"
#include "sinew/runtime/records/mcap_writer.h"
#include "sinew/runtime/records/run_look.h"

namespace sinew::runtime {

/// Pictures that a program looked at, what was seen in them, and what it decided, as messages of
/// its record. Their channels are in a file that has such messages.
class LookEncoder {
 public:
  /// @param robot  outlives this. @param name  channels of decisions begin with it
  LookEncoder(const RobotModel& robot, std::string name) : robot_(robot), name_(std::move(name)) {}

  /// @param time  ns since 1970
  /// @return how many messages the file had no room for
  std::uint64_t put(McapWriter& writer, std::uint64_t time, const RunPicture& picture);
  std::uint64_t put(McapWriter& writer, std::uint64_t time, const RunDecision& decision);

 private:
  struct Channels {
    std::uint16_t image = 0;
    std::uint16_t annotations = 0;
  };
  Channels channels_of(McapWriter& writer, const std::string& camera);

  const RobotModel& robot_;
  std::string name_;
  std::optional<Channels> schemas_;
  std::map<std::string, Channels> cameras_;
  std::optional<std::uint16_t> decisions_;
};

}  // namespace sinew::runtime
