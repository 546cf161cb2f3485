/// How the command lines of all programs say which scene, and how it is made.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "harness/cli/check_options.h"

namespace stbvh::harness {

/// --scale.
void add_scale_option(CLI::App& app, Arguments& arguments);

/// How a scene is made that is named elsewhere: --scale, --seed and those of glTF files.
void add_making_options(CLI::App& app, Arguments& arguments);

/// `word` as a shell takes it for one.
std::string shell_word(const std::string& word);

}  // namespace stbvh::harness
