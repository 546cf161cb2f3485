/// The options of `report`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "harness/program/options.h"
#include "harness/program/scene_options.h"

namespace stbvh::harness {

struct ReportOptions : SceneOptions {
  std::vector<std::string> structures;        ///< empty: each command's own
  std::filesystem::path output;               ///< folder
  std::optional<std::filesystem::path> from;  ///< what need not be measured
  bool quick = false;
  unsigned threads = 1;
};

void add_options(CLI::App& app, ReportOptions& options);
void run_report(const ReportOptions& options);

}  // namespace stbvh::harness
