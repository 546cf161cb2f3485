#include "harness/path_tracer/render.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "harness/cli/commands.h"
#include "harness/cli/picture_files.h"
#include "harness/cli/render_options.h"
#include "harness/cli/report_pictures.h"
#include "harness/cli/shot_film.h"
#include "harness/cli/shot_frames.h"
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
#include "harness/program/unnamed_file.h"
#include "harness/program/usage_error.h"
#include "harness/report/machine.h"
#include "harness/scenes/scene_hash.h"
#include "harness/structures/memory_estimate.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

/// Whether frames are shown as a film: whole ones.
bool has_film(const RenderOptions& options) {
  return options.png && !options.frames.numbers.empty() && options.settings.strip.count == 1;
}

/// The file of each picture, which can be written as things stand.
class Outputs {
 public:
  Outputs(const RenderOptions& options, const std::vector<SceneSource>& sources)
      : output_(options.output), strip_(options.settings.strip) {
    std::vector<std::optional<int>> frames(options.frames.numbers.begin(), options.frames.numbers.end());
    std::error_code error;
    is_folder_ =
        sources.size() * options.structures.size() > 1 || !frames.empty() || fs::is_directory(output_, error);
    if (is_folder_) make_folder(output_);
    if (frames.empty()) frames.push_back(std::nullopt);
    std::set<fs::path> all;
    if (has_film(options)) const UnnamedFile of_film;  // it can be made
    const auto check = [&](const fs::path& path) {
      if (!all.insert(path).second)
        throw UsageError(fmt::format("Two pictures would be written to \"{}\".", path.string()));
      check_picture_file(path, options.png);
    };
    for (const SceneSource& source : sources) {
      for (const std::string& structure : options.structures) {
        for (const auto& frame : frames) check(file(source.name, structure, frame));
        if (has_film(options)) check_writable(film(source.name, structure));
      }
    }
  }

  fs::path file(const std::string& scene, const std::string& structure, std::optional<int> frame) const {
    if (!is_folder_) return output_;
    return output_ / named(scene, structure, frame ? fmt::format(".{:04}", *frame) : "");
  }
  /// Of the files of all frames.
  fs::path pattern(const std::string& scene, const std::string& structure) const {
    return output_ / named(scene, structure, ".*");
  }
  fs::path film(const std::string& scene, const std::string& structure) const {
    return output_ / fmt::format("{}-{}.mp4", scene, structure);
  }

 private:
  std::string named(const std::string& scene, const std::string& structure, const std::string& frame) const {
    const std::string tile = strip_.count > 1 ? fmt::format(".{}of{}", strip_.index + 1, strip_.count) : "";
    return fmt::format("{}-{}{}{}.exr", scene, structure, frame, tile);
  }

  fs::path output_;
  Strip strip_;
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

/// Prints what scenes are shown without: all of the first take; of later ones, kinds that none before had,
/// which are sentences but for their numbers.
class TakeWarnings {
 public:
  void begin_take() { earlier_.merge(present_); }
  void tell(const std::string& sentence) {
    std::string kind = sentence;
    std::erase_if(kind, [](unsigned char c) { return std::isdigit(c) != 0; });
    if (!earlier_.contains(kind)) print_warning(sentence);
    present_.insert(std::move(kind));
  }

 private:
  std::set<std::string> earlier_, present_;
};

/// What is told of the pictures of a scene through one structure.
struct Tally {
  std::size_t pictures = 0, finished_before = 0, empty = 0;
  double build_s = 0;
  std::size_t most_bytes = 0;  ///< of a structure
  double seconds = 0;
  std::uint64_t rays = 0;
};

/// The scenes of `options`; those without frames are refused where frames are asked for.
std::vector<SceneSource> find_pictured_scenes(const RenderOptions& options) {
  std::vector<SceneSource> sources;
  const MakingOptions making = takes_of(options.frames, options, options.settings.shutter).front().making;
  for (const std::string& scene : options.scenes) sources.push_back(find_scene(scene, making));
  return sources;
}

class RenderRun {
 public:
  explicit RenderRun(const RenderOptions& options)
      : options_(options), outputs_(options, find_pictured_scenes(options)) {
    if (!options.environment.empty()) environment_ = read_environment(options.environment);
    check_outputs(options);
    left_ = options.scenes.size() * options.structures.size() *
            std::max<std::size_t>(options.frames.numbers.size(), 1);
  }

  void run() {
    for (const std::string& scene : options_.scenes) render_scene(scene);
    write_records(options_, report_);
    if (not_finite_ > 0) {
      throw std::runtime_error(fmt::format("{} samples of \"{}\"{} were NaN or infinite and are left out.",
                                           not_finite_, not_finite_file_.string(),
                                           not_finite_files_ > 1 ? " and others" : ""));
    }
  }

 private:
  bool has_frames() const { return !options_.frames.numbers.empty(); }

  void render_scene(const std::string& asked) {
    TakeWarnings warnings;
    MakingOptions making = options_;
    making.warn = [&](const std::string& sentence) { warnings.tell(sentence); };
    std::vector<std::string> structures = options_.structures;
    std::map<std::string, Tally> tallies;
    std::string name;
    framing_.reset();
    for (const Take& take : takes_of(options_.frames, making, options_.settings.shutter)) {
      warnings.begin_take();
      const SceneSource source = find_scene(asked, take.making);
      progress_.stage(fmt::format("{}: making the scene", source.name));
      Scene scene = source.load();
      name = scene.name;
      if (environment_) scene.environment = environment_;
      if (has_frames() && scene.is_framed) scene.camera = framing(asked, making);
      structures = structures_that_fit(structures, scene, "");
      render_take(take, scene, structures, tallies);
    }
    if (!has_frames()) return;
    for (const auto& [structure, tally] : tallies) finish_shot(name, structure, tally);
  }

  /// One place to see all frames from, whichever of them are rendered here.
  Camera framing(const std::string& asked, const MakingOptions& making) {
    if (!framing_) framing_ = find_scene(asked, whole_file(making)).load().camera;
    return *framing_;
  }

  void render_take(const Take& take, const Scene& scene, const std::vector<std::string>& structures,
                   std::map<std::string, Tally>& tallies) {
    const std::string hash = scene_hash(scene);
    std::map<std::optional<int>, std::vector<RenderFile>> files;
    for (const std::string& name : structures) {
      std::unique_ptr<StructureUnderTest> structure;
      for (const Frame& frame : take.frames) {
        const fs::path file = outputs_.file(scene.name, name, frame.number);
        const std::string shown =
            frame.number ? fmt::format("{}.{:04}", scene.name, *frame.number) : scene.name;
        files[frame.number].push_back({shown, name, file});
        make_picture(scene, hash, name, frame, file, structure, tallies[name]);
      }
    }
    if (!options_.json) return;
    for (const auto& [frame, of_frame] : files) {
      const std::vector<RenderResult> shown = show_renderings(of_frame, of_frame.front().path.parent_path());
      report_.renders.insert(report_.renders.end(), shown.begin(), shown.end());
    }
  }

  /// Renders one picture and writes it, unless it is there. Builds `structure` when it is first needed.
  void make_picture(const Scene& scene, const std::string& hash, const std::string& name, const Frame& frame,
                    const fs::path& file, std::unique_ptr<StructureUnderTest>& structure, Tally& tally) {
    RenderSettings settings = options_.settings;
    settings.seed = options_.seed;
    settings.shutter = frame.shutter;
    settings.camera = chosen_camera(options_.camera, scene.camera);
    Metadata making = making_metadata(settings, scene, hash, name, options_.environment);
    if (frame.number) making.emplace_back("frame", fmt::format("{}", *frame.number));
    ++tally.pictures;
    if (scene.meshes.empty()) ++tally.empty;
    --left_;
    if (options_.resume) {
      progress_.clear();
      if (is_finished(file, making, settings.strip)) {
        ++tally.finished_before;
        if (!frame.number) fmt::print("{}: finished before\n", file.string());
        if (options_.png && !fs::exists(png_beside(file)))
          write_png(tone_mapped(read_exr(file)), png_beside(file));
        return;
      }
    }
    const std::string label = frame.number ? fmt::format("{}, {}, frame {}", scene.name, name, *frame.number)
                                           : fmt::format("{}, {}", scene.name, name);
    if (structure == nullptr) structure = build(scene, name, label, tally);
    double done = 0;
    const auto show = [&](double fraction) {
      done = fraction;
      progress_.stage(fmt::format("{}: rendering, {:.0f} %, {:.0f} s left", label, 100 * fraction,
                                  seconds_left(fraction)));
    };
    const Interruption interruption;
    Rendering rendering = render(scene, *structure, settings, show, &interruption.flag());
    progress_.clear();
    rendering.image.metadata = std::move(making);
    add_outcome(settings, rendering);
    write_exr(rendering.image, file);
    if (options_.png) write_png(tone_mapped(rendering.image), png_beside(file));
    if (!rendering.is_complete) {
      throw Interrupted(
          fmt::format("Interrupted: \"{}\" holds {:.0f} % of the picture.", file.string(), 100 * done));
    }
    ++made_;
    tally.seconds += rendering.seconds;
    tally.rays += rendering.rays;
    if (!frame.number)
      print_line("{} ({:.1f} s, {:.2f} million rays a second)\n", file.string(), rendering.seconds,
                 mrays_per_s(rendering.rays, rendering.seconds));
    note_not_finite(rendering.not_finite, file);
  }

  std::unique_ptr<StructureUnderTest> build(const Scene& scene, const std::string& name,
                                            const std::string& label, Tally& tally) {
    progress_.stage(label + ": building");
    try {
      auto structure = build_structure(name, scene, options_.settings.threads);
      tally.build_s += structure->build_record().build_s;
      tally.most_bytes = std::max(tally.most_bytes, structure->build_record().structure_bytes);
      return structure;
    } catch (const OverLimit& limit) {
      throw UsageError(fmt::format("--max-bytes: {} over {}: {}.", name, scene.name, limit.what()));
    }
  }

  /// Of all pictures, `fraction` of the present one being done; those that were there take no time.
  double seconds_left(double fraction) const {
    const double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double done = static_cast<double>(made_) + fraction;
    return passed / done * (1 - fraction + static_cast<double>(left_));
  }

  void finish_shot(const std::string& scene, const std::string& structure, const Tally& tally) {
    std::string line = fmt::format("{}: {} frame{}", outputs_.pattern(scene, structure).string(),
                                   tally.pictures, tally.pictures == 1 ? "" : "s");
    if (tally.empty > 0) line += fmt::format(", {} without a mesh", tally.empty);
    if (tally.finished_before > 0) line += fmt::format(", {} finished before", tally.finished_before);
    if (tally.finished_before < tally.pictures)
      line += fmt::format(
          " (builds {:.2f} s, {:.1f} MB at most; rendering {:.1f} s, {:.2f} million rays a second)",
          tally.build_s, static_cast<double>(tally.most_bytes) / 1e6, tally.seconds,
          mrays_per_s(tally.rays, tally.seconds));
    print_line("{}\n", line);
    if (!has_film(options_)) return;
    std::vector<fs::path> pictures;
    for (const int frame : options_.frames.numbers)
      pictures.push_back(png_beside(outputs_.file(scene, structure, frame)));
    const fs::path film = outputs_.film(scene, structure);
    const double rate = options_.frames.rate > 0 ? options_.frames.rate : kFrameRate;
    if (write_film(pictures, rate, film)) print_line("{}\n", film.string());
  }

  template <typename... Values>
  void print_line(fmt::format_string<Values...> text, Values&&... values) {
    progress_.clear();
    fmt::print(text, std::forward<Values>(values)...);
    std::fflush(stdout);
  }

  static double mrays_per_s(std::uint64_t rays, double seconds) {
    return static_cast<double>(rays) / 1e6 / seconds;
  }

  void note_not_finite(std::size_t samples, const fs::path& file) {
    if (samples == 0) return;
    if (not_finite_files_ == 0) not_finite_file_ = file;
    ++not_finite_files_;
    not_finite_ += samples;
  }

  const RenderOptions& options_;
  Outputs outputs_;
  std::optional<Environment> environment_;
  std::optional<Camera> framing_;  ///< of the scene in work
  Report report_;
  Progress progress_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::size_t made_ = 0, left_ = 0;  ///< pictures
  std::size_t not_finite_ = 0, not_finite_files_ = 0;
  fs::path not_finite_file_;
};

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
  RenderRun(options).run();
}

}  // namespace

Work render_command(CLI::App& app) {
  return make_work(app, run_render);
}

}  // namespace stbvh::harness
