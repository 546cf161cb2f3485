#include "harness/cli/commands.h"

#include <fmt/format.h>

#include "harness/cli/program.h"
#include "harness/hard_cases/hard_case.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

void run(const Options& options) {
  switch (options.command) {
    case Command::kList:
      return run_list();
    case Command::kBench:
      return run_bench(options);
    case Command::kError:
      return run_error(options);
    case Command::kHard:
      return run_hard(options);
    case Command::kPareto:
      return run_pareto(options);
    case Command::kScaling:
      return run_scaling(options);
    case Command::kCharts:
      return run_charts(options);
    case Command::kResults:
      return run_results(options);
    case Command::kRender:
      return run_render(options);
    case Command::kCompare:
      return run_compare(options);
    case Command::kTruth:
      return run_truth(options);
    case Command::kReport:
      return run_report(options);
    case Command::kConvert:
      return run_convert(options);
  }
}

}  // namespace

void run_list() {
  fmt::print("scenes (or a .glb, .gltf, .xml or .ecs file, or .obj files)\n");
  for (const ProceduralScene& scene : procedural_scenes()) {
    fmt::print("  {:<17} {} (default scale {})\n", scene.name, scene.description, scene.default_scale);
  }
  fmt::print("structures\n");
  for (std::string_view name : structure_names()) {
    fmt::print("  {:<21} {}\n", name, structure_description(name));
  }
  fmt::print("rays\n");
  for (RayKind kind : ray_kinds()) fmt::print("  {}\n", ray_kind_name(kind));
  fmt::print("families of hard cases\n");
  for (const HardFamily& family : hard_families())
    fmt::print("  {:<25} {}\n", family.name, family.description);
}

int run_program(int argc, const char* const* argv) {
  return run_as_program([&] {
    const std::optional<Options> options = parse_options(argc, argv);
    if (options) run(*options);
  });
}

}  // namespace stbvh::harness
