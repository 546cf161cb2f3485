#include "plugin/preload/environment.h"

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace stbvh::preload {
namespace {

using Variable = std::function<const char*(const char*)>;
using Complain = std::function<void(const std::string&)>;

void read_switch(const Variable& variable, const Complain& complain, const char* name, bool& value) {
  const char* const text = variable(name);
  if (text == nullptr || *text == '\0') return;
  const std::string_view view(text);
  if (view == "0" || view == "1") {
    value = view == "1";
    return;
  }
  complain(std::string(name) + " must be 0 or 1, not '" + text + "'; it is taken as " + (value ? "1" : "0"));
}

void read_preset(const Variable& variable, const Complain& complain, bool& fast) {
  const char* const text = variable("STBVH_PRELOAD_PRESET");
  if (text == nullptr || *text == '\0') return;
  const std::string_view view(text);
  if (view == "default") {
    fast = false;
  } else if (view == "fast") {
    fast = true;
  } else {
    complain("STBVH_PRELOAD_PRESET must be default or fast, not '" + std::string(text) +
             "'; it is taken as default");
  }
}

void read_bytes(const Variable& variable, const Complain& complain, const char* name, std::size_t& bytes) {
  const char* const text = variable(name);
  if (text == nullptr || *text == '\0') return;
  const std::string_view view(text);
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), value);
  if (error == std::errc() && end == view.data() + view.size() && value > 0) {
    bytes = value;
    return;
  }
  complain(std::string(name) + " must be a number of bytes, not '" + text + "'; there is no limit");
}

std::optional<std::string> read_statistics(const Variable& variable) {
  const char* const text = variable("STBVH_PRELOAD_STATISTICS");
  if (text == nullptr || *text == '\0') return std::nullopt;
  const std::string_view view(text);
  if (view == "0") return std::nullopt;
  return view == "1" ? std::string() : std::string(view);
}

}  // namespace

Environment read_environment(const Variable& variable, const Complain& complain) {
  Environment result;
  read_switch(variable, complain, "STBVH_PRELOAD", result.enabled);
  read_switch(variable, complain, "STBVH_PRELOAD_ALL", result.all_triangles);
  read_switch(variable, complain, "STBVH_PRELOAD_VERBOSE", result.verbose);
  read_preset(variable, complain, result.fast);
  read_bytes(variable, complain, "STBVH_PRELOAD_MAX_BYTES", result.max_bytes);
  result.statistics = read_statistics(variable);
  return result;
}

const Environment& environment() {
  static const Environment values = read_environment(
      [](const char* name) { return std::getenv(name); },
      [](const std::string& sentence) { std::fprintf(stderr, "libstbvh_preload: %s\n", sentence.c_str()); });
  return values;
}

}  // namespace stbvh::preload
