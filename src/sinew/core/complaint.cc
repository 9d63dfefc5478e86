#include "sinew/core/complaint.h"

namespace sinew {

std::string to_text(const Complaint& complaint) {
  std::string text = complaint.file + ":" + std::to_string(complaint.line) + ":" +
                     std::to_string(complaint.column) + ": ";
  if (!complaint.key.empty()) text += complaint.key + ": ";
  return text + complaint.message;
}

}  // namespace sinew
