#pragma once

#include "sinew/control/journal_recovery.h"
#include "sinew/control/position_journal.h"
#include "sinew/model/robot_model.h"

namespace sinew::control {

/// Which machine a journal is about. Its model part changes with what the recorded positions mean:
/// the joints, what turns a device's units into them, and the geometry. Not with limits, speeds,
/// masses or words.
JournalOwner journal_owner(const RobotModel& robot);

/// How far ahead of this robot's motion steps are reserved; docs/journal.md has the reasons.
JournalSettings journal_settings(const RobotModel& robot);

/// How its journal is read. A device that shows when its power was away (hexapod, BigRobotArm) is
/// believed; of any other one nothing is left that it does not measure itself.
RecoverySettings recovery_settings(const RobotModel& robot);

}  // namespace sinew::control
