#include "harness/program/whole_numbers.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <string>
#include <system_error>

#include "harness/program/usage_error.h"

namespace stbvh::harness {

std::uint64_t parse_whole_number(std::string_view option, std::string_view text) {
  std::uint64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error == std::errc() && stop == end) return number;
  throw UsageError(fmt::format("{} takes whole numbers from 0 and below 2^64, not \"{}\".", option, text));
}

CLI::Option* add_whole_number_option(CLI::App& app, const char* name,
                                     const std::function<void(std::size_t)>& take, const char* description) {
  const auto parse = [=](const std::string& text) { take(parse_whole_number(name, text)); };
  return app.add_option_function<std::string>(name, parse, description)->type_name("UINT");
}

CLI::Option* add_whole_numbers_option(CLI::App& app, const char* name,
                                      const std::function<void(std::vector<std::size_t>)>& take,
                                      const char* description) {
  // Not CLI11's delimiter, which leaves out what is empty.
  const auto parse = [=](const std::vector<std::string>& lists) {
    std::vector<std::size_t> numbers;
    for (std::string_view rest : lists) {
      for (bool is_last = false; !is_last;) {
        const std::size_t comma = std::min(rest.find(','), rest.size());
        is_last = comma == rest.size();
        numbers.push_back(parse_whole_number(name, rest.substr(0, comma)));
        rest.remove_prefix(is_last ? comma : comma + 1);
      }
    }
    take(numbers);
  };
  return app.add_option_function<std::vector<std::string>>(name, parse, description)->type_name("UINT");
}

void add_seed_option(CLI::App& app, std::uint64_t& seed, const char* description) {
  const auto take = [&seed](std::size_t number) { seed = number; };
  add_whole_number_option(app, "--seed", take, description)->default_str(std::to_string(seed));
}

}  // namespace stbvh::harness
