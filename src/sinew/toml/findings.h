#pragma once

#include <string>
#include <vector>

#include "sinew/core/complaint.h"

namespace sinew {

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

  /// Where numbers come from of which their own table says nothing; empty: it has to.
  void set_usual_source(std::string source) { usual_source_ = std::move(source); }
  const std::string& usual_source() const { return usual_source_; }

  bool clean() const { return complaints_.empty(); }
  /// In the order of the file, those at one place by key.
  std::vector<Complaint> take_complaints();
  std::vector<Provenance> take_sources() { return std::move(sources_); }

 private:
  std::string file_;
  std::string usual_source_;
  std::vector<Complaint> complaints_;
  std::vector<Provenance> sources_;
};

}  // namespace sinew
