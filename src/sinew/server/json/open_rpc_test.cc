#include "sinew/server/json/open_rpc.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <set>

#include "sinew/server/json/methods.h"

namespace sinew::server {
namespace {

/// Each key of an object is one that the specification has for it.
void expect_only(const Json& object, const std::set<std::string>& keys, const std::string& where) {
  ASSERT_TRUE(object.is_object()) << where;
  for (const auto& [key, value] : object.items()) {
    EXPECT_TRUE(keys.contains(key) || key.starts_with("x-")) << where << ": " << key;
  }
}

/// https://spec.open-rpc.org, version 1.2.6: what is required, and what may stand where.
TEST(OpenRpc, has_the_shape_of_the_specification) {
  const Json document = open_rpc("1.2.3");
  expect_only(document, {"openrpc", "info", "servers", "methods", "components", "externalDocs"},
              "document");
  EXPECT_EQ(document["openrpc"], "1.2.6");
  expect_only(document["info"],
              {"title", "description", "termsOfService", "contact", "license", "version"}, "info");
  EXPECT_EQ(document["info"]["version"], "1.2.3");
  EXPECT_TRUE(document["info"]["title"].is_string());
  std::set<std::string> names;
  for (const Json& method : document["methods"]) {
    const std::string name = method["name"];
    EXPECT_TRUE(names.insert(name).second) << name;
    expect_only(method,
                {"name", "tags", "summary", "description", "externalDocs", "params", "result",
                 "deprecated", "servers", "errors", "links", "paramStructure", "examples"},
                name);
    EXPECT_EQ(method["paramStructure"], "by-name");
    bool optional = false;
    std::set<std::string> params;
    for (const Json& param : method["params"]) {
      expect_only(param, {"name", "summary", "description", "required", "schema", "deprecated"},
                  name);
      EXPECT_TRUE(params.insert(param["name"]).second) << name;
      EXPECT_TRUE(param["schema"].is_object()) << name;
      EXPECT_TRUE(param["required"].is_boolean()) << name;
      // Required ones stand before the others.
      EXPECT_FALSE(optional && param["required"].get<bool>()) << name << ": " << param["name"];
      optional = optional || !param["required"].get<bool>();
    }
    expect_only(method["result"],
                {"name", "summary", "description", "required", "schema", "deprecated"}, name);
    EXPECT_TRUE(method["result"].contains("name") && method["result"].contains("schema")) << name;
  }
}

TEST(OpenRpc, has_each_method_of_the_table_with_its_params) {
  const Json document = open_rpc("test");
  ASSERT_EQ(document["methods"].size(), methods().size());
  for (std::size_t k = 0; k < methods().size(); ++k) {
    const Method& method = methods()[k];
    const Json& told = document["methods"][k];
    EXPECT_EQ(told["name"], method.name);
    EXPECT_EQ(told["x-role"], method.moves ? "operator" : "viewer");
    ASSERT_EQ(told["params"].size(), method.params.size()) << method.name;
    for (std::size_t p = 0; p < method.params.size(); ++p) {
      EXPECT_EQ(told["params"][p]["name"], method.params[p].name);
      EXPECT_EQ(told["params"][p]["required"], method.params[p].required);
    }
  }
}

/// Every name behind "$ref", wherever it stands.
void collect_refs(const Json& json, std::set<std::string>& refs) {
  if (json.is_object() && json.contains("$ref")) refs.insert(json["$ref"].get<std::string>());
  if (!json.is_structured()) return;
  for (const Json& one : json) collect_refs(one, refs);
}

TEST(OpenRpc, each_reference_leads_somewhere_and_nothing_lies_about) {
  const Json document = open_rpc("test");
  std::set<std::string> refs;
  collect_refs(document, refs);
  std::set<std::string> there;
  for (const auto& [kind, parts] : document["components"].items()) {
    for (const auto& [name, part] : parts.items())
      there.insert("#/components/" + kind + "/" + name);
  }
  there.erase("#/components/schemas/Refusal");  // of which errors tell in words
  EXPECT_EQ(refs, there);
}

/// A value that a param's schema describes is one that the check lets through.
Json example_of(const Json& schema) {
  const std::string type = schema["type"];
  if (type == "string") return "text";
  if (type == "number") return 0.5;
  if (type == "integer") return schema["minimum"].get<std::uint64_t>();  // as a parser has it
  if (type == "boolean") return true;
  if (type == "array") return Json::array({example_of(schema["items"])});
  return {{"key", example_of(schema["additionalProperties"])}};
}

TEST(OpenRpc, describes_what_the_check_lets_through) {
  const Json document = open_rpc("test");
  for (const Json& method : document["methods"]) {
    RpcRequest request{.id = 1, .answered = true, .method = method["name"], .params = {}};
    request.params = Json::object();
    for (const Json& param : method["params"]) {
      request.params[param["name"].get<std::string>()] = example_of(param["schema"]);
    }
    const auto fits = check(request);
    EXPECT_TRUE(fits) << method["name"] << ": " << fits.error().message;
    for (const Json& param : method["params"]) {
      RpcRequest wrong = request;
      wrong.params[param["name"].get<std::string>()] = nullptr;
      EXPECT_FALSE(check(wrong)) << method["name"] << ": " << param["name"];
    }
  }
}

}  // namespace
}  // namespace sinew::server
