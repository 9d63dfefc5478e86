#pragma once

#include "sinew/devices/facts_view.h"

namespace sinew {

/// What both kinds of axis boards say in flags, as warnings.
/// @param axis  as its view has it
void judge_axis(const FactsView& view, FactsJson& json, const FactsJson& axis, bool answers,
                std::size_t i);

}  // namespace sinew
