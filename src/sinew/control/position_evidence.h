#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sinew/driver/driver.h"

namespace sinew::control {

/// One thing that is known of where a joint stands, beside what somebody says.
struct Evidence {
  enum class Source : std::uint8_t {
    kSensor,    ///< the device measures it
    kCounters,  ///< the device counts it, and what ties its count to the joint is known
    kRecord,    ///< the journal, or what this process has seen the device do
  } source = Source::kRecord;
  JointInterval where;
  double slack = 0;  ///< rad or m by which it may be off on either side
};

/// Where the joint stands by all of them: each narrows what the others leave open.
/// @param said  what somebody says; not lost
/// @error kCountedElsewhere, or for the other sources kDeclaredElsewhere (index; what was said, the
///        nearest that the evidence allows; rad or m). @rt
Expected<JointInterval> agree(std::size_t joint, std::span<const Evidence> known,
                              const JointPosition& said);

/// The middle of what is known of each joint, whose interval stays: a place that is confirmed as it
/// is shown. A person sees no more than so much, so a wider interval is not confirmed.
/// @param said  of joints that are lost: what the last record says; may be empty
/// @error kPositionUnknown (index): lost, or known to 3 deg (1 mm of a leg) only or worse
Expected<FixedVector<JointPosition, kMaxJoints>> as_shown(const RobotModel& robot,
                                                          std::span<const JointPosition> known,
                                                          std::span<const JointPosition> said = {});

/// How far beyond a limit a joint may be said to stand: sagged, or pushed by hand to its end.
/// rad, or m of a leg.
double reach_beyond_limits(const Joint& joint);

}  // namespace sinew::control
