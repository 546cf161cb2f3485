#include "harness/program/session.h"

#include <fmt/format.h>

#include "harness/rays/ray_generator.h"
#include "harness/report/json.h"
#include "harness/report/machine.h"
#include "harness/report/table.h"
#include "harness/structures/memory_estimate.h"
#include "harness/structures/structure_under_test.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {

std::vector<RaySet> make_ray_sets(const Scene& scene, const RayOptions& options, std::uint64_t seed,
                                  unsigned threads, Progress& progress) {
  progress.stage(fmt::format("{}: making rays", scene.name));
  const bool is_embrees = obstacle(kReferenceStructure, scene).empty();
  const auto reference =
      build_structure(is_embrees ? kReferenceStructure : kOwnReferenceStructure, scene, threads);
  std::vector<RaySet> sets;
  for (RayKind kind : options.rays) {
    sets.push_back(make_rays(kind, scene, *reference, options.count, seed));
    if (sets.back().rays.size() < options.count) {
      fmt::print("Only {} {} rays: the scene is hit too seldom.\n", sets.back().rays.size(),
                 ray_kind_name(kind));
    }
  }
  return sets;
}

std::vector<std::string> structures_that_fit(const std::vector<std::string>& names, const Scene& scene,
                                             std::string_view beside) {
  const std::size_t available = available_memory_bytes();
  std::vector<std::string> fitting;
  for (const std::string& name : names) {
    if (const std::string why = obstacle(name, scene); !why.empty()) {
      fmt::print("{} left out: {}.\n", name, why);
      continue;
    }
    const bool is_alone = beside.empty() || name == beside || !obstacle(beside, scene).empty();
    const std::size_t needed =
        estimate_peak_bytes(name, scene) + (is_alone ? 0 : estimate_peak_bytes(beside, scene));
    if (needed <= available) {
      fitting.push_back(name);
    } else {
      fmt::print("{} left out: it would need about {:.1f} GB, and {:.1f} GB are free.\n", name,
                 static_cast<double>(needed) / 1e9, static_cast<double>(available) / 1e9);
    }
  }
  return fitting;
}

std::unique_ptr<StructureUnderTest> build_within_limit(const std::string& name, const Scene& scene,
                                                       unsigned threads) {
  try {
    return build_structure(name, scene, threads);
  } catch (const OverLimit& limit) {
    fmt::print("{} left out of {}: {}.\n", name, scene.name, limit.what());
    return nullptr;
  }
}

void for_each_scene(const SessionOptions& options, Progress& progress,
                    const std::function<void(const Scene&)>& work) {
  const std::vector<SceneSource> sources = find_scenes(options);
  check_outputs(options);
  fmt::print("{}", machine_line(this_machine(), built_commit()));
  for (const SceneSource& source : sources) {
    progress.stage(fmt::format("{}: making the scene", source.name));
    const Scene scene = source.load();
    work(scene);
  }
}

void check_outputs(const RecordOptions& options) {
  for (const auto& file : {options.json, options.tables}) {
    if (file) check_writable(*file);
  }
}

void write_results(const RecordOptions& options, const Report& report, std::size_t parts,
                   const std::string& screen, const std::string& tables) {
  fmt::print("{}", parts == 1 ? tables : screen);
  if (options.tables) write_file(*options.tables, machine_line(this_machine(), built_commit()) + tables);
  write_records(options, report);
}

void write_records(const RecordOptions& options, const Report& report) {
  if (options.json)
    write_file(*options.json, to_json(report, this_machine(), built_commit(), options.command_line));
}

}  // namespace stbvh::harness
