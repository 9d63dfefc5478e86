#pragma once

#include <memory>
#include <string>

#include "sinew/control/controller.h"
#include "sinew/control/journal_recovery.h"
#include "sinew/io/disk_folder.h"
#include "sinew/runtime/journal/journal_writer.h"

namespace sinew::runtime {

/// One robot's position journal on a real disk: locked, read, and going on to be written in a
/// thread of its own. docs/journal.md.
class PositionRecord {
 public:
  /// @param folder  made where it is not there. @param name  of the two files; letters, digits, -_.
  /// @param port  where the machine is; this journal follows it from now on (PortClaims). Where
  /// another one did so last, its last record is taken over, or all positions are lost. Empty: not
  /// about a machine that is connected.
  /// @error  a sentence: the folder cannot be had, another process writes this journal, ...
  static io::IoResult<std::unique_ptr<PositionRecord>> open(const std::string& folder,
                                                            const std::string& name,
                                                            const RobotModel& robot,
                                                            const std::string& port = {});

  /// The machine was plugged in, or again, while this journal is written: under the names that its
  /// port has now it follows the machine too. From any thread.
  /// @error  a sentence: another journal, or none, followed that machine last, so this one knows
  /// nothing of it before it is read again; the disk's
  io::IoResult<void> follow_port(const RobotModel& robot, const std::string& port) const;

  /// What another program once wrote down of where this machine stands: intervals that hold the
  /// truth, which count from the next run on, on disk when this returns. Nothing can be recorded
  /// behind it.
  /// @param positions  one a joint, none of them exact. @error  a sentence: the disk's
  io::IoResult<void> import(const RobotModel& robot, std::span<const JointPosition> positions,
                            const JournalTime& time);

  /// What the run before left.
  const JournalRecovery& recovery() const { return recovery_; }
  /// That another journal, or none, followed the machine last, and what that means; else empty.
  const std::string& note() const { return note_; }
  /// For people: what the journal looks like.
  std::string found() const;
  control::ControllerStart start() const;
  JournalPump& pump() { return writer_->pump(); }
  const std::string& folder() const { return disk_.path(); }

 private:
  PositionRecord(io::DiskFolder disk, std::string name);
  io::IoResult<void> read(const RobotModel& robot);
  io::IoResult<void> take_port(const RobotModel& robot, const std::string& port);
  io::IoResult<void> take_over(const std::string& other, const RobotModel& robot,
                               const std::string& port);
  io::IoResult<void> lose(const RobotModel& robot);
  /// As the last one of this journal, on disk when this returns.
  io::IoResult<void> add(JournalRecord record, const RobotModel& robot);
  /// A run of one word: what was known, and then that of `positions`, because of `cause`.
  io::IoResult<void> only_say(const RobotModel& robot, std::span<const JointPosition> positions,
                              JournalCause cause, const JournalTime& time);

  io::DiskFolder disk_;
  std::string name_;
  JournalFiles files_;
  JournalRecovery recovery_;
  std::string note_;
  std::unique_ptr<JournalWriter> writer_;
};

/// A run without a journal begins to move the machine on that port: what a journal says of it does
/// not count any more. @error  a sentence: the disk's
io::IoResult<void> forget_port(const std::string& folder, const std::string& port,
                               const RobotModel& robot);

/// $XDG_STATE_HOME/sinew/positions, or where the home has it.
/// @error  neither variable is set
io::IoResult<std::string> positions_folder();
/// The same with "records": what machines did before they failed, and what somebody recorded.
io::IoResult<std::string> records_folder();
/// The same with "web": the tokens of the network door.
io::IoResult<std::string> web_folder();

/// The same with "firmware": what was on boards before they were written.
io::IoResult<std::string> firmware_folder();

/// The same with "programs": those of each kind of robot and its points, in a folder of its id.
io::IoResult<std::string> programs_folder();
/// The same with "events": what happened in each cell.
io::IoResult<std::string> events_folder();
/// The same with "settings": what was set of the robots of each cell, beside its file.
io::IoResult<std::string> settings_folder();

/// For people: what happened to a disk.
std::string sentence(const DiskError& error);

}  // namespace sinew::runtime
