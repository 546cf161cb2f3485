#include "harness/cli/commands.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <new>

#include "harness/cli/interruption.h"
#include "harness/cli/scene_source.h"
#include "harness/cli/script.h"
#include "harness/cli/usage_error.h"
#include "plugin/files/output_file.h"
#include "harness/images/compare.h"
#include "harness/images/exr_file.h"
#include "harness/rays/ray_generator.h"
#include "harness/report/read_records.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/structures/structure_under_test.h"
#include "tests/hard_cases/hard_case.h"

namespace stbvh::harness {
namespace {

int fail(int code, const char* text) {
  fmt::print(stderr, "stbvh-ab: {}\n", text);
  return code;
}

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
  try {
    const std::optional<Options> options = parse_options(argc, argv);
    if (options) run(*options);
    return 0;
  } catch (const UsageError& e) {
    return fail(2, e.what());
  } catch (const SceneFileError& e) {
    return fail(2, e.what());
  } catch (const OutputFileError& e) {
    return fail(2, e.what());
  } catch (const ImageFileError& e) {
    return fail(2, e.what());
  } catch (const ComparisonError& e) {
    return fail(2, e.what());
  } catch (const RecordFileError& e) {
    return fail(2, e.what());
  } catch (const Interrupted& e) {
    return fail(130, e.what());
  } catch (const ScriptFailure& e) {
    return e.exit_code;
  } catch (const std::bad_alloc&) {
    return fail(1, "Not enough memory.");
  } catch (const std::exception& e) {
    return fail(1, e.what());
  }
}

}  // namespace stbvh::harness
