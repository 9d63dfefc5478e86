#pragma once

#include <expected>
#include <string>
#include <vector>

#include "sinew/runtime/records/mcap_reader.h"

namespace sinew::runtime {

struct RecordedPicture {
  std::string name;  ///< of a file: number, camera, s since the record began
  std::string jpeg;
};

/// What a program looked at, in order.
/// @error  a sentence: a message that no record of Sinew has
std::expected<std::vector<RecordedPicture>, std::string> record_pictures(
    const McapContent& content);

/// A row for each decision that a program made by them, as CSV; its head alone where there is none.
/// @error  as above
std::expected<std::string, std::string> decisions_csv(const McapContent& content);

}  // namespace sinew::runtime
