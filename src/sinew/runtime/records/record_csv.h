#pragma once

#include <expected>
#include <string>

#include "sinew/runtime/records/mcap_reader.h"

namespace sinew::runtime {

/// A row for each sample of a record: joints, state, bytes a second.
/// @error  a sentence: a message that no record of Sinew has, or no sample at all
std::expected<std::string, std::string> record_csv(const McapContent& content);

}  // namespace sinew::runtime
