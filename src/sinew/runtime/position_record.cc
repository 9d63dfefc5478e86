#include "sinew/runtime/position_record.h"

#include <fmt/format.h>

#include <cstdlib>
#include <cstring>
#include <utility>

#include "sinew/control/machine_identity.h"

namespace sinew::runtime {

std::string sentence(const DiskError& error) {
  switch (error.code) {
    case DiskErrorCode::kFull:
      return "the disk is full";
    case DiskErrorCode::kDenied:
      return "it may not be written: no permission, or a disk that can only be read";
    case DiskErrorCode::kMissing:
      return "it is not there";
    case DiskErrorCode::kLocked:
      return error.number > 0 ? fmt::format("process {} is writing it", error.number)
                              : std::string("another process is writing it");
    case DiskErrorCode::kTooLarge:
      return "it is larger than any journal of this program";
    case DiskErrorCode::kFailed:
      break;
  }
  return fmt::format("the disk failed: {}", std::strerror(error.number));
}

namespace {

io::IoError cannot_be_used(const std::string& folder, const std::string& name,
                           const DiskError& error) {
  return {
      fmt::format("{}/{}: the position journal cannot be used: {}", folder, name, sentence(error))};
}

}  // namespace

PositionRecord::PositionRecord(io::DiskFolder disk, std::string name)
    : disk_(std::move(disk)), name_(std::move(name)), files_(disk_, name_) {}

io::IoResult<std::unique_ptr<PositionRecord>> PositionRecord::open(const std::string& folder,
                                                                   const std::string& name,
                                                                   const RobotModel& robot) {
  auto disk = io::DiskFolder::open_folder(folder);
  if (!disk) return std::unexpected(disk.error());
  std::unique_ptr<PositionRecord> record(new PositionRecord(std::move(*disk), name));
  const auto cannot = [&](const DiskError& error) {
    return std::unexpected(cannot_be_used(folder, name, error));
  };
  if (const auto locked = record->files_.lock(); !locked) return cannot(locked.error());
  const auto bytes = record->files_.load();
  if (!bytes) return cannot(bytes.error());
  record->recovery_ = recover(bytes->files(), control::recovery_settings(robot));
  record->files_.continue_after(record->recovery_.end);
  record->writer_ = std::make_unique<JournalWriter>(record->files_);
  return record;
}

control::ControllerStart PositionRecord::start() const {
  return {recovery_.positions, recovery_.end, recovery_.memory};
}

io::IoResult<void> PositionRecord::give_up(const RobotModel& robot, const JournalTime& time) {
  JournalPositions none;
  // A device that counts goes on counting.
  for (const JointPosition& joint : recovery_.positions) {
    none.push_back({.count_zero = joint.count_zero});
  }
  return only_say(robot, {none.data(), none.size()}, JournalCause::kUser, time);
}

io::IoResult<void> PositionRecord::import(const RobotModel& robot,
                                          std::span<const JointPosition> positions,
                                          const JournalTime& time) {
  return only_say(robot, positions, JournalCause::kImported, time);
}

io::IoResult<void> PositionRecord::only_say(const RobotModel& robot,
                                            std::span<const JointPosition> positions,
                                            JournalCause cause, const JournalTime& time) {
  writer_.reset();
  PositionJournal journal(control::journal_settings(robot), recovery_.end);
  const auto opened = journal.open(
      std::span<const JointPosition>(recovery_.positions.data(), recovery_.positions.size()), time);
  const auto lost = journal.lost(positions, cause, time);
  auto written = files_.write(opened);
  if (written) written = files_.write(*lost);
  if (written) written = files_.sync();
  if (written) return {};
  return std::unexpected(cannot_be_used(disk_.path(), name_, written.error()));
}

namespace {

io::IoResult<std::string> state_folder(const char* part) {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value == '/' ? std::string(value) : std::string();
  };
  if (const std::string state = set("XDG_STATE_HOME"); !state.empty()) {
    return state + "/sinew/" + part;
  }
  if (const std::string home = set("HOME"); !home.empty()) {
    return home + "/.local/state/sinew/" + part;
  }
  return std::unexpected(io::IoError{
      fmt::format("neither XDG_STATE_HOME nor HOME names a folder, so {} cannot be kept", part)});
}

}  // namespace

io::IoResult<std::string> positions_folder() {
  return state_folder("positions");
}

io::IoResult<std::string> records_folder() {
  return state_folder("records");
}

io::IoResult<std::string> programs_folder() {
  return state_folder("programs");
}

io::IoResult<std::string> settings_folder() {
  return state_folder("settings");
}

io::IoResult<std::string> events_folder() {
  return state_folder("events");
}

io::IoResult<std::string> web_folder() {
  return state_folder("web");
}

}  // namespace sinew::runtime
