/// Whole numbers on command lines: digits alone, without sign, and none that wraps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace stbvh::harness {

/// Throws UsageError.
std::uint64_t parse_whole_number(std::string_view option, std::string_view text);

CLI::Option* add_whole_number_option(CLI::App& app, const char* name,
                                     const std::function<void(std::size_t)>& take, const char* description);

/// Of several, with commas between.
CLI::Option* add_whole_numbers_option(CLI::App& app, const char* name,
                                      const std::function<void(std::vector<std::size_t>)>& take,
                                      const char* description);

/// --seed.
void add_seed_option(CLI::App& app, std::uint64_t& seed, const char* description);

}  // namespace stbvh::harness
