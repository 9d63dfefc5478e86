#include "sinew/server/web/web_answer.h"

#include <algorithm>
#include <array>

namespace sinew::server {
namespace {

struct Reason {
  int status;
  std::string_view text;
};

constexpr std::array kReasons = std::to_array<Reason>({
    {200, "OK"},
    {204, "No Content"},
    {304, "Not Modified"},
    {400, "Bad Request"},
    {401, "Unauthorized"},
    {403, "Forbidden"},
    {404, "Not Found"},
    {405, "Method Not Allowed"},
    {406, "Not Acceptable"},
    {408, "Request Timeout"},
    {411, "Length Required"},
    {413, "Content Too Large"},
    {414, "URI Too Long"},
    {415, "Unsupported Media Type"},
    {417, "Expectation Failed"},
    {421, "Misdirected Request"},
    {426, "Upgrade Required"},
    {429, "Too Many Requests"},
    {431, "Request Header Fields Too Large"},
    {501, "Not Implemented"},
    {503, "Service Unavailable"},
    {504, "Gateway Timeout"},
    {505, "HTTP Version Not Supported"},
});

/// Scripts and styles from here only, nothing inline, in no frame; no other page may read, embed or
/// open what is here.
std::string protection(std::string_view origin) {
  // Not all browsers count a WebSocket of the same host among 'self'.
  std::string sockets;
  if (!origin.empty()) sockets = " ws" + std::string(origin.substr(4));
  return "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; "
         "img-src 'self' data: blob:; font-src 'self'; worker-src 'self' blob:; "
         "manifest-src 'self'; connect-src 'self'" +
         sockets +
         "; frame-ancestors 'none'; base-uri 'none'; form-action 'none'\r\n"
         "X-Content-Type-Options: nosniff\r\n"
         "X-Frame-Options: DENY\r\n"
         "Referrer-Policy: no-referrer\r\n"
         "Cross-Origin-Opener-Policy: same-origin\r\n"
         "Cross-Origin-Resource-Policy: same-origin\r\n"
         "Permissions-Policy: camera=(), microphone=(), geolocation=(), payment=(), usb=()\r\n";
}

}  // namespace

std::string answer_head(const WebAnswer& answer, std::string_view origin) {
  const auto reason = std::ranges::find(kReasons, answer.status, &Reason::status);
  std::string text = "HTTP/1.1 " + std::to_string(answer.status) + " ";
  text += reason != kReasons.end() ? reason->text : "Unknown";
  text += "\r\n";
  if (!answer.type.empty()) text += "Content-Type: " + std::string(answer.type) + "\r\n";
  const bool has_length = answer.status != 204 && answer.status != 304;
  if (has_length) text += "Content-Length: " + std::to_string(answer.length) + "\r\n";
  if (!answer.fields.contains("Cache-Control:")) text += "Cache-Control: no-store\r\n";
  text += answer.fields;
  text += protection(origin);
  if (answer.close) text += "Connection: close\r\n";
  return text + "\r\n";
}

std::string refusal_text(const HttpRefusal& refusal, bool head_only) {
  const std::string body = refusal.sentence + "\n";
  const std::string head = answer_head({.status = refusal.status,
                                        .type = "text/plain; charset=utf-8",
                                        .length = body.size(),
                                        .fields = refusal.extra,
                                        .close = true},
                                       {});
  return head_only ? head : head + body;
}

std::string_view no_panel_page() {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Sinew</title>"
         "</head>\n<body><h1>Sinew</h1>\n<p>This cell is running, and this build has no panel. "
         "Programs reach the cell here: POST /rpc and the WebSocket /ws, described in docs/web.md "
         "and at /openrpc.json.</p>\n</body></html>\n";
}

}  // namespace sinew::server
