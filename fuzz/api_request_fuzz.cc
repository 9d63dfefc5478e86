// A message of a client: read and checked, or refused in a sentence that fits into an answer.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "sinew/server/json/methods.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew::server;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto request = read_request(text);
  std::string answer;
  if (!request) {
    answer = error_text(request.error().id, request.error().error);
  } else if (const auto method = check(*request); !method) {
    answer = error_text(request->id, method.error());
  } else {
    answer = result_text(request->id, request->params);
  }
  const bool one_line = answer.find('\n') == std::string::npos;
  if (!one_line || Json::parse(answer, nullptr, false).is_discarded()) std::abort();
  return 0;
}
