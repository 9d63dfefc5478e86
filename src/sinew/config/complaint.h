#pragma once

#include <compare>
#include <string>
#include <vector>

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

/// Where a constant of a robot's file comes from.
struct Provenance {
  std::string key;  ///< dotted
  int line = 1;
  std::string source;
};

/// What one reading of a file gathers. Stops taking complaints at `kMaxComplaints`, so that a file
/// of garbage costs bounded memory.
class Findings {
 public:
  static constexpr std::size_t kMaxComplaints = 200;

  explicit Findings(std::string file) : file_(std::move(file)) {}

  void complain(Place place, std::string key, std::string message);
  void note_source(Provenance provenance) { sources_.push_back(std::move(provenance)); }

  bool clean() const { return complaints_.empty(); }
  /// In the order of the file, those at one place by key.
  std::vector<Complaint> take_complaints();
  std::vector<Provenance> take_sources() { return std::move(sources_); }

 private:
  std::string file_;
  std::vector<Complaint> complaints_;
  std::vector<Provenance> sources_;
};

}  // namespace sinew
