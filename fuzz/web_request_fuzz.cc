// A request to the network door: refused in a sentence, or let in as what the gate promises. The
// same bytes are also what a WebSocket's first message could be.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "sinew/core/assert.h"
#include "sinew/server/web/web_answer.h"
#include "sinew/server/web/web_gate.h"
#include "sinew/server/web/web_session.h"

namespace {

using namespace sinew::server;

constexpr const char* kOperator = "0123456789abcdef0123456789abcdef";
constexpr const char* kViewer = "fedcba9876543210fedcba9876543210";
constexpr std::uint8_t kByte = 0x1f;
constexpr Asset kAsset{"/index.html", "text/html; charset=utf-8", "\"1\"", {&kByte, 1}};

/// Wherever the bytes are cut, what comes of them is the same.
void same_when_cut(std::string_view text) {
  const auto whole = head_size(text);
  for (const std::size_t cut : {text.size() / 3, text.size() / 2}) {
    const auto part = head_size(text.substr(0, cut));
    if (!part) SINEW_ASSERT(!whole);
    if (part && *part != 0) SINEW_ASSERT(whole && *whole == *part);
  }
}

void check_refusal(const HttpRefusal& refusal) {
  SINEW_ASSERT(refusal.status >= 400 && refusal.status <= 505 && !refusal.sentence.empty());
  SINEW_ASSERT(!refusal.sentence.contains('\r') && !refusal.sentence.contains('\n'));
  const std::string text = refusal_text(refusal);
  SINEW_ASSERT(!text.contains("Unknown"));
  // One head and one body, whatever was asked.
  SINEW_ASSERT(text.find("\r\n\r\n") == text.rfind("\r\n\r\n"));
}

void check_request(const WebRequest& request, std::string_view text) {
  SINEW_ASSERT(request.head.count("host") == 1);
  const std::string host = lower_case(*request.head.find("host"));
  SINEW_ASSERT(host == "127.0.0.1:8700" || host == "localhost:8700");
  SINEW_ASSERT(!request.head.target.contains('?'));
  const bool posts = request.kind == WebRequest::Kind::kRpc;
  SINEW_ASSERT(request.body == 0 || posts);
  SINEW_ASSERT(request.body <= kMessageMax);
  SINEW_ASSERT((request.head.method == "POST") == posts);
  const std::string* origin = request.head.find("origin");
  const bool socket = request.kind == WebRequest::Kind::kSocket;
  if (origin != nullptr && (posts || socket)) SINEW_ASSERT(*origin == "http://" + host);
  SINEW_ASSERT(request.role || socket || request.kind == WebRequest::Kind::kAsset);
  if (request.role) {
    const bool is_operator = *request.role == Role::kOperator;
    SINEW_ASSERT(text.contains(is_operator ? kOperator : kViewer));
  }
  SINEW_ASSERT(request.head.count("transfer-encoding") == 0);
}

void check_first_message(std::string_view text) {
  const auto open = read_session_open(text);
  if (open) return;
  const std::string answer = error_text(open.error().id, open.error().error);
  SINEW_ASSERT(!answer.contains('\n') && !Json::parse(answer, nullptr, false).is_discarded());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  same_when_cut(text);
  check_first_message(text);
  WebGate gate({.hosts = {"127.0.0.1:8700", "localhost:8700"},
                .operator_token = kOperator,
                .viewer_token = kViewer,
                .assets = {&kAsset, 1}});
  const auto head = head_size(text);
  if (!head) {
    check_refusal(head.error());
    return 0;
  }
  const std::string_view first = *head != 0 ? text.substr(0, *head) : text;
  const WebCaller caller{"127.0.0.1", "127.0.0.1:8700"};
  const auto request = gate.decide(first, caller, sinew::Instant{});
  if (request) {
    check_request(*request, first);
  } else {
    check_refusal(request.error());
  }
  return 0;
}
