#include "harness/path_tracer/render.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <set>

#include "harness/cli/commands.h"
#include "harness/cli/render_options.h"
#include "harness/cli/report_pictures.h"
#include "harness/images/exr_file.h"
#include "harness/images/png_file.h"
#include "harness/images/tone_map.h"
#include "harness/path_tracer/lights.h"
#include "harness/program/interruption.h"
#include "harness/program/make_folder.h"
#include "harness/program/picture_metadata.h"
#include "harness/program/progress.h"
#include "harness/program/scene_source.h"
#include "harness/program/session.h"
#include "harness/program/usage_error.h"
#include "harness/report/machine.h"
#include "harness/scenes/scene_hash.h"
#include "harness/structures/memory_estimate.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

fs::path png_beside(fs::path file) {
  return file.replace_extension(".png");
}

/// The file of each scene and structure, which can be written as things stand.
class Outputs {
 public:
  Outputs(const RenderOptions& options, const std::vector<SceneSource>& sources) : output_(options.output) {
    std::error_code error;
    is_folder_ = sources.size() * options.structures.size() > 1 || fs::is_directory(output_, error);
    if (is_folder_) make_folder(output_);
    std::set<fs::path> all;
    for (const SceneSource& source : sources) {
      for (const std::string& structure : options.structures) {
        const fs::path path = file(source.name, structure);
        if (!all.insert(path).second) {
          throw UsageError(fmt::format("Two pictures would be written to \"{}\".", path.string()));
        }
        if (options.png && png_beside(path) == path) {
          throw UsageError(fmt::format("\"{}\" is the OpenEXR file: it cannot end in .png.", path.string()));
        }
        check_writable(path);
        if (options.png) check_writable(png_beside(path));
      }
    }
  }

  fs::path file(const std::string& scene, const std::string& structure) const {
    return is_folder_ ? output_ / fmt::format("{}-{}.exr", scene, structure) : output_;
  }

 private:
  fs::path output_;
  bool is_folder_;
};

/// Refuses pictures that are not all directions by latitude and longitude.
void check_environment(const LayeredImage& image, const fs::path& path) {
  if (image.is_cube_map) {
    throw UsageError(
        fmt::format("The picture \"{}\" is a cube, not one of latitude and longitude.", path.string()));
  }
  if (image.window() != image.display_window()) {
    throw UsageError(
        fmt::format("The picture \"{}\" is not a whole sphere: its data window is not its display window.",
                    path.string()));
  }
  if (image.chromaticities != kRec709) {
    print_warning(fmt::format(
        "\"{}\" has other chromaticities than Rec. 709: its colors are taken as if they were these.",
        path.string()));
  }
}

Environment read_environment(const fs::path& path) {
  const LayeredImage image = read_exr(path);
  check_environment(image, path);
  Environment environment{.radiance = {1, 1, 1}, .width = image.width, .height = image.height, .pixels = {}};
  const auto *r = image.find("R"), *g = image.find("G"), *b = image.find("B");
  if (r == nullptr || g == nullptr || b == nullptr) {
    throw UsageError(fmt::format("The picture \"{}\" has no channels R, G and B.", path.string()));
  }
  for (std::size_t i = 0; i < r->size(); ++i) environment.pixels.push_back({(*r)[i], (*g)[i], (*b)[i]});
  try {
    const EnvironmentLight light(environment);
  } catch (const std::invalid_argument&) {
    throw UsageError(
        fmt::format("The picture \"{}\" has light that is negative or not finite.", path.string()));
  }
  return environment;
}

/// Whether that picture has been made before, whole, and of the same.
bool is_finished(const fs::path& file, const Metadata& making, const Strip& strip) {
  std::error_code error;
  if (!fs::exists(file, error)) return false;
  Metadata wanted = making;
  wanted.emplace_back("strip", strip_text(strip));
  wanted.emplace_back("complete", "yes");
  try {
    const LayeredImage image = read_exr(file);
    const std::string differs = first_difference(wanted, image.metadata);
    if (differs.empty()) return true;
    fmt::print("{}: made again, as its {} was another\n", file.string(), differs);
  } catch (const ImageFileError&) {
    fmt::print("{}: made again, as it cannot be read\n", file.string());
  }
  return false;
}

/// Renders one picture and writes it.
void make_picture(const RenderOptions& options, const Scene& scene, const std::string& hash,
                  const std::string& structure_name, const fs::path& file, Progress& progress) {
  const std::string label = fmt::format("{}, {}", scene.name, structure_name);
  RenderSettings settings = options.settings;
  settings.seed = options.seed;
  settings.camera = chosen_camera(options.camera, scene.camera);
  Metadata making = making_metadata(settings, scene, hash, structure_name, options.environment);
  if (options.resume) {
    progress.clear();
    if (is_finished(file, making, settings.strip)) {
      fmt::print("{}: finished before\n", file.string());
      return;
    }
  }
  progress.stage(label + ": building");
  std::unique_ptr<StructureUnderTest> structure;
  try {
    structure = build_structure(structure_name, scene, options.settings.threads);
  } catch (const OverLimit& limit) {
    throw UsageError(fmt::format("--max-bytes: {} over {}: {}.", structure_name, scene.name, limit.what()));
  }
  const auto start = std::chrono::steady_clock::now();
  double done = 0;
  const auto show = [&](double fraction) {
    const double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    done = fraction;
    progress.stage(fmt::format("{}: rendering, {:.0f} %, {:.0f} s left", label, 100 * fraction,
                               passed * (1 - fraction) / fraction));
  };
  const Interruption interruption;
  Rendering rendering = render(scene, *structure, settings, show, &interruption.flag());
  progress.clear();
  rendering.image.metadata = std::move(making);
  add_outcome(settings, rendering);
  write_exr(rendering.image, file);
  if (options.png) write_png(tone_mapped(rendering.image), png_beside(file));
  if (!rendering.is_complete) {
    throw Interrupted(
        fmt::format("Interrupted: \"{}\" holds {:.0f} % of the picture.", file.string(), 100 * done));
  }
  fmt::print("{} ({:.1f} s, {:.2f} million rays a second)\n", file.string(), rendering.seconds,
             static_cast<double>(rendering.rays) / 1e6 / rendering.seconds);
  std::fflush(stdout);
  if (rendering.not_finite > 0) {
    throw std::runtime_error(fmt::format("{} samples of \"{}\" were NaN or infinite and are left out.",
                                         rendering.not_finite, file.string()));
  }
}

void run_render(const RenderOptions& options) {
  check_shutter_times(options.settings.shutter);
  if (options.settings.strip.count > options.settings.height) {
    throw UsageError(fmt::format("--tile: a picture of {} rows has no {} tiles.", options.settings.height,
                                 options.settings.strip.count));
  }
  if (rendering_bytes(options.settings) > available_memory_bytes()) {
    throw UsageError(
        fmt::format("--size: a picture of {} x {} pixels takes {:.1f} GB, and {:.1f} GB are free.",
                    options.settings.width, options.settings.height,
                    static_cast<double>(rendering_bytes(options.settings)) / 1e9,
                    static_cast<double>(available_memory_bytes()) / 1e9));
  }
  const std::vector<SceneSource> sources = find_scenes(options);
  std::optional<Environment> environment;
  if (!options.environment.empty()) environment = read_environment(options.environment);
  const Outputs outputs(options, sources);
  check_outputs(options);
  Report report;
  Progress progress;
  for (const SceneSource& source : sources) {
    progress.stage(fmt::format("{}: making the scene", source.name));
    Scene scene = source.load();
    if (environment) scene.environment = environment;
    const std::string hash = scene_hash(scene);
    std::vector<RenderFile> files;
    for (const std::string& structure : structures_that_fit(options.structures, scene, "")) {
      files.push_back({source.name, structure, outputs.file(source.name, structure)});
      make_picture(options, scene, hash, structure, files.back().path, progress);
    }
    if (!options.json || files.empty()) continue;
    const std::vector<RenderResult> shown = show_renderings(files, files.front().path.parent_path());
    report.renders.insert(report.renders.end(), shown.begin(), shown.end());
  }
  write_records(options, report);
}

}  // namespace

Work render_command(CLI::App& app) {
  return make_work(app, run_render);
}

}  // namespace stbvh::harness
