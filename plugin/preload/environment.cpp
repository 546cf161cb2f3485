#include "plugin/preload/environment.h"

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

void read_preset(const Variable& variable, const Complain& complain, Preset& preset) {
  const char* const text = variable("STBVH_PRELOAD_PRESET");
  if (text == nullptr || *text == '\0') return;
  const std::string_view view(text);
  if (view == "default") {
    preset = Preset::kDefault;
  } else if (view == "compact") {
    preset = Preset::kCompact;
  } else if (view == "fast") {
    preset = Preset::kFast;
  } else {
    complain("STBVH_PRELOAD_PRESET must be default, compact or fast, not '" + std::string(text) +
             "'; it is taken as default");
  }
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
  read_preset(variable, complain, result.preset);
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
