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

}  // namespace sinew::control
