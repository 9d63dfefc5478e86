#pragma once

#include <compare>
#include <string>

namespace sinew {

/// Where something stands in a text, counted from 1; columns count characters, not bytes.
struct Place {
  int line = 1;
  int column = 1;

  friend auto operator<=>(const Place&, const Place&) = default;
};

/// One thing that is wrong with a file, told so that it can be mended without the manual.
struct Complaint {
  std::string file;
  int line = 1;
  int column = 1;
  std::string key;  ///< dotted, "joint.elbow.upper_deg"; empty where none is to blame
  std::string message;

  friend bool operator==(const Complaint&, const Complaint&) = default;
};

/// "robots/learm.toml:12:3: joint.elbow.upper_deg: must be ...", as editors parse it.
std::string to_text(const Complaint& complaint);

}  // namespace sinew
