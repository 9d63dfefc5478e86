#include "sinew/runtime/journal/position_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include "sinew/control/machine_identity.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/io/port_identity.h"
#include "sinew/runtime/journal/port_claims.h"

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
                                                                   const RobotModel& robot,
                                                                   const std::string& port) {
  auto disk = io::DiskFolder::open_folder(folder);
  if (!disk) return std::unexpected(disk.error());
  std::unique_ptr<PositionRecord> record(new PositionRecord(std::move(*disk), name));
  if (const auto locked = record->files_.lock(); !locked) {
    return std::unexpected(cannot_be_used(folder, name, locked.error()));
  }
  if (auto done = record->read(robot); !done) return std::unexpected(done.error());
  record->files_.continue_after(record->recovery_.end);
  if (!port.empty()) {
    if (auto done = record->take_port(robot, port); !done) return std::unexpected(done.error());
  }
  record->writer_ = std::make_unique<JournalWriter>(record->files_);
  return record;
}

io::IoResult<void> PositionRecord::read(const RobotModel& robot) {
  const auto bytes = files_.load();
  if (!bytes) return std::unexpected(cannot_be_used(disk_.path(), name_, bytes.error()));
  recovery_ = recover(bytes->files(), control::recovery_settings(robot));
  return {};
}

io::IoResult<void> PositionRecord::take_port(const RobotModel& robot, const std::string& port) {
  PortClaims claims(disk_, io::port_identities(port), robot.id);
  const std::vector<std::string> owners = claims.owners();
  const bool ours =
      std::ranges::all_of(owners, [&](const std::string& owner) { return owner == name_; });
  io::IoResult<void> done;
  if (!ours && owners.front().empty()) {
    note_ = fmt::format(
        "a run without --journal moved the machine on {} last, or its position journal has "
        "followed "
        "another machine since, so '{}' does not know its position",
        port, name_);
    done = lose(robot);
  } else if (!ours && owners.size() > 1) {
    note_ = fmt::format(
        "more than one position journal followed the machine on {} ('{}'), so '{}' does not know "
        "its position",
        port, fmt::join(owners, "', '"), name_);
    done = lose(robot);
  } else if (!ours) {
    done = take_over(owners.front(), robot, port);
  }
  if (!done) return done;
  // Only now: until what was taken over is safe, the other journal is the one that knows.
  if (const auto claimed = claims.claim(name_); !claimed) {
    return std::unexpected(cannot_be_used(disk_.path(), name_, claimed.error()));
  }
  return {};
}

io::IoResult<void> PositionRecord::follow_port(const RobotModel& robot,
                                               const std::string& port) const {
  auto disk = io::DiskFolder::open_folder(disk_.path());  // its own: the writer's is in its thread
  if (!disk) return std::unexpected(disk.error());
  PortClaims claims(*disk, io::port_identities(port), robot.id);
  for (const std::string& owner : claims.owners()) {
    if (owner == name_) continue;
    const std::string who =
        owner.empty()
            ? "a run without --journal moved the machine that is there now, or its "
              "position journal has followed another one since"
            : "the position journal '" + owner + "' followed the machine that is there now";
    return std::unexpected(
        io::IoError{fmt::format("{}: {}, and '{}' does not know where it stands; end this program "
                                "and start it again",
                                port, who, name_)});
  }
  if (const auto claimed = claims.claim(name_); !claimed) {
    return std::unexpected(cannot_be_used(disk->path(), name_, claimed.error()));
  }
  return {};
}

io::IoResult<void> PositionRecord::take_over(const std::string& other, const RobotModel& robot,
                                             const std::string& port) {
  auto disk = io::DiskFolder::open_folder(disk_.path());
  if (!disk) return std::unexpected(disk.error());
  JournalFiles files(*disk, other);
  const auto locked = files.lock();
  const auto bytes =
      locked ? files.load() : DiskResult<JournalBytes>(std::unexpected(locked.error()));
  if (!bytes) {
    return std::unexpected(io::IoError{fmt::format(
        "the position journal '{}' followed the machine on {} last, and '{}' cannot "
        "continue from it: {}",
        other, port, name_, cannot_be_used(disk_.path(), other, bytes.error()).sentence)});
  }
  const JournalRecovery theirs = recover(bytes->files(), control::recovery_settings(robot));
  note_ = fmt::format("the position journal '{}' followed the machine on {} last; '{}' ", other,
                      port, name_);
  if (theirs.last) {
    auto done = add(*theirs.last, robot);
    recovery_.last_time = theirs.last_time;  // the machine was left then, not now
    note_ += fmt::format("continues from it; {}", sentence(recovery_.finding));
    return done;
  }
  note_ += fmt::format("cannot continue from it: {}", sentence(theirs.finding));
  return lose(robot);
}

io::IoResult<void> PositionRecord::lose(const RobotModel& robot) {
  JournalRecord lost;
  lost.kind = JournalKind::kLost;
  lost.cause = JournalCause::kRecovery;
  lost.positions.resize(robot.joints.size());
  return add(lost, robot);
}

io::IoResult<void> PositionRecord::add(JournalRecord record, const RobotModel& robot) {
  record.sequence = recovery_.end.sequence + 1;
  record.generation = recovery_.end.generation + 1;
  record.owner = control::journal_owner(robot);
  record.time.wall_ns = io::wall_time_ns();
  auto written = files_.write(record);
  if (written) written = files_.sync();
  if (!written) return std::unexpected(cannot_be_used(disk_.path(), name_, written.error()));
  return read(robot);
}

std::string PositionRecord::found() const {
  return note_.empty() ? std::string(sentence(recovery_.finding)) : note_;
}

io::IoResult<void> forget_port(const std::string& folder, const std::string& port,
                               const RobotModel& robot) {
  if (!io::exists(folder)) return {};
  auto disk = io::DiskFolder::open_folder(folder);
  if (!disk) return std::unexpected(disk.error());
  PortClaims claims(*disk, io::port_identities(port), robot.id);
  if (const auto done = claims.release(); !done) {
    return std::unexpected(io::IoError{folder + ": " + sentence(done.error())});
  }
  return {};
}

control::ControllerStart PositionRecord::start() const {
  DriverMemory memory = recovery_.memory;
  const Duration since{io::wall_time_ns() - recovery_.last_time.wall_ns};
  memory.since = std::max(since, Duration::zero());
  return {recovery_.positions, recovery_.end, memory};
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

io::IoResult<std::string> firmware_folder() {
  return state_folder("firmware");
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
