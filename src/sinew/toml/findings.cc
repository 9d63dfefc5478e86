#include "sinew/toml/findings.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace sinew {

void Findings::complain(Place place, std::string key, std::string message) {
  if (complaints_.size() == kMaxComplaints) return;
  if (complaints_.size() == kMaxComplaints - 1) {
    key.clear();
    message = "too many complaints; mend these first";
  }
  complaints_.push_back({file_, place.line, place.column, std::move(key), std::move(message)});
}

std::vector<Complaint> Findings::take_complaints() {
  std::ranges::sort(complaints_, {}, [](const Complaint& complaint) {
    return std::tie(complaint.line, complaint.column, complaint.key, complaint.message);
  });
  return std::move(complaints_);
}

}  // namespace sinew
