/// The report: what is missing is measured by the other commands, then one page is made of it all.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "harness/cli/commands.h"
#include "harness/cli/pareto.h"
#include "harness/cli/report_options.h"
#include "harness/cli/report_pictures.h"
#include "harness/cli/wrong_answers.h"
#include "harness/files/input_file.h"
#include "harness/program/make_folder.h"
#include "harness/program/scene_source.h"
#include "harness/program/script.h"
#include "harness/program/session.h"
#include "harness/program/usage_error.h"
#include "harness/report/json.h"
#include "harness/report/read_records.h"
#include "harness/structures/structure_under_test.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr std::string_view kBenchStructures =
    "embree,embree-robust,embree-compact,embree-4v,lbvh,lbvh-4v,stbvh,stbvh-compact,stbvh-direct";
constexpr std::string_view kPictureStructures = "embree,embree-4v,lbvh,stbvh,stbvh-direct";
/// Rendered large, with many samples: how long a picture takes.
constexpr std::string_view kLargePicture = "barbarian";
constexpr std::size_t kMaxCopiedBytes = std::size_t{1} << 30;
/// Beside those that speed against error is made of.
constexpr std::string_view kOtherFamilies =
    "step-times-7,temporal-splits,time-ranges-touching,scale-1e-10,scale-1e10,origin-far,coplanar,zero-"
    "directions,"
    "fast-closed-16,half-turn,nan-rays,infinite-rays";

std::string joined(const Words& words) {
  return fmt::format("{}", fmt::join(words, ","));
}

class ReportRun {
 public:
  explicit ReportRun(const ReportOptions& options) : options_(options), folder_(options.output) {}

  void run() {
    const std::vector<SceneSource> sources = find_scenes(options_);
    prepare();
    measure("bench", bench());
    measure("error", error());
    measure("hard", hard());
    if (!is_reused("renders")) make_renders(sources);
    if (!is_reused("pareto")) make_pareto();
    if (!is_reused("truth")) make_truth();
    run_script("report.py", {folder_.string()});
    if (wrong_) throw WrongAnswers("Wrong answers of our structures: see above, and the page.");
  }

 private:
  fs::path record_file(const std::string& part) const { return folder_ / "records" / (part + ".json"); }

  /// Everything that can be known to fail before hours of work.
  void prepare() {
    for (const char* inner : {"records", "images", "renders"}) make_folder(folder_ / inner);
    for (const char* name : {"index.html", "report.md", "records/bench.json", "images/a.png"})
      check_writable(folder_ / name);
    if (!options_.from) return;
    std::error_code error;
    if (!fs::is_directory(*options_.from, error))
      throw UsageError(fmt::format("--from: \"{}\" is not a folder.", options_.from->string()));
    for (const char* part : {"bench", "error", "hard", "renders", "pareto", "truth"}) take(part);
    if (taken_.empty())
      throw UsageError(fmt::format("--from: no records in \"{}\".", options_.from->string()));
    take_images();
  }

  /// Takes a part's records from --from, if they are there.
  void take(const std::string& part) {
    const std::string name = part + ".json";
    const fs::path inner = *options_.from / "records" / name;
    const fs::path file = is_there(inner) ? inner : *options_.from / name;
    if (!is_there(file)) return;
    check_records(file);
    taken_[part] = true;
    copy(file, record_file(part));
  }

  void take_images() {
    const fs::path images = *options_.from / "images";
    if (!is_there(images)) return;
    for (const fs::directory_entry& entry : fs::directory_iterator(images)) {
      if (entry.is_regular_file()) copy(entry.path(), folder_ / "images" / entry.path().filename());
    }
  }

  /// Also of what cannot be reached: reading it will tell why.
  static bool is_there(const fs::path& path) {
    std::error_code ignored;
    return fs::symlink_status(path, ignored).type() != fs::file_type::not_found;
  }

  static void copy(const fs::path& from, const fs::path& to) {
    std::error_code error;
    if (fs::equivalent(from, to, error)) return;
    try {
      write_file(to, read_whole_file(from, kMaxCopiedBytes));
    } catch (const InputFileError& e) {
      throw UsageError(fmt::format("\"{}\" {}.", from.string(), e.what()));
    }
  }

  bool is_reused(const std::string& part) const { return taken_.contains(part); }

  /// Runs a command of this program as from a command line.
  void run_command(const Words& words) {
    std::vector<const char*> argv{"stbvh-ab"};
    for (const std::string& word : words) argv.push_back(word.c_str());
    fmt::print("\n-- stbvh-ab {}\n", fmt::join(words, " "));
    std::fflush(stdout);
    const int code = run_program(static_cast<int>(argv.size()), argv.data());
    if (code == 0) return;
    if (code != 1) throw ScriptFailure{code};
    wrong_ = true;
  }

  void measure(const std::string& part, Words words) {
    if (is_reused(part)) return;
    std::error_code ignored;
    fs::remove(record_file(part), ignored);
    words.insert(words.end(), {"--json", record_file(part).string()});
    run_command(words);
    if (!fs::exists(record_file(part))) throw ScriptFailure{1};
  }

  /// The options of scenes as they were given, and the threads.
  Words with_scenes(Words words) const {
    words.insert(words.end(), options_.scene_words.begin(), options_.scene_words.end());
    words.insert(words.end(), {"--threads", fmt::format("{}", options_.threads)});
    return words;
  }

  std::string structures(std::string_view otherwise) const {
    return options_.structures.empty() ? std::string(otherwise) : joined(options_.structures);
  }

  Words bench() const {
    Words words = with_scenes({"bench", "--structures", structures(kBenchStructures)});
    words.insert(words.end(), {"--count", options_.quick ? "20000" : "100000", "--build-budget",
                               options_.quick ? "0" : "2"});
    return words;
  }

  Words error() const {
    return with_scenes({"error", "--structures", structures(kBenchStructures), "--count",
                        options_.quick ? "2000" : "20000"});
  }

  Words hard() const {
    return {"hard",
            "--families",
            joined(pareto_families()) + "," + std::string(kOtherFamilies),
            "--structures",
            structures(kBenchStructures),
            "--count",
            options_.quick ? "2000" : "20000",
            "--threads",
            fmt::format("{}", options_.threads)};
  }

  void make_renders(const std::vector<SceneSource>& sources) {
    const std::string names = structures(kPictureStructures);
    const fs::path renders = folder_ / "renders";
    Words small = with_scenes({"render", "--structures", names});
    small.insert(small.end(), {"--size", options_.quick ? "192x108" : "384x216", "--spp",
                               options_.quick ? "4" : "8", "-o", renders.string()});
    std::error_code ignored;
    for (const auto& file : files_of(sources, names)) fs::remove(file.path, ignored);
    run_command(small);
    std::string commands = fmt::format("stbvh-ab {}", fmt::join(small, " "));
    if (has_large_picture()) {
      const Words large = large_picture(names, renders);
      run_command(large);
      commands += fmt::format("\nstbvh-ab {}", fmt::join(large, " "));
    }
    Report report;
    std::map<std::string, std::vector<RenderFile>> by_scene;
    for (const RenderFile& file : files_of(sources, names)) {
      if (fs::exists(file.path)) by_scene[file.scene].push_back(file);
    }
    for (const SceneSource& source : sources) {
      if (!by_scene.contains(source.name)) continue;
      for (RenderResult& r : show_renderings(by_scene[source.name], folder_ / "images"))
        report.renders.push_back(std::move(r));
    }
    if (report.renders.empty()) throw ScriptFailure{1};
    write(report, "renders", commands);
    renders_ = std::move(report.renders);
  }

  bool has_large_picture() const {
    return !options_.quick &&
           std::find(options_.scenes.begin(), options_.scenes.end(), kLargePicture) != options_.scenes.end();
  }

  Words large_picture(const std::string& structures, const fs::path& folder) const {
    Words words{"render",       "--scenes",     std::string(kLargePicture),
                "--structures", structures,     "--size",
                "960x540",      "--spp",        "64",
                "-o",           folder.string()};
    words.insert(words.end(), {"--seed", fmt::format("{}", options_.seed), "--threads",
                               fmt::format("{}", options_.threads)});
    if (options_.scale) words.insert(words.end(), {"--scale", fmt::format("{}", *options_.scale)});
    return words;
  }

  std::vector<RenderFile> files_of(const std::vector<SceneSource>& sources, const std::string& names) const {
    std::vector<RenderFile> files;
    for (const SceneSource& source : sources) {
      for (std::string_view name : structure_names()) {
        if (("," + names + ",").find(fmt::format(",{},", name)) == std::string::npos) continue;
        const std::string file = fmt::format("{}-{}.exr", source.name, name);
        files.push_back({source.name, std::string(name), folder_ / "renders" / file});
      }
    }
    return files;
  }

  /// From the speeds, hard cases and pictures that there are: nothing is measured twice.
  void make_pareto() {
    const std::vector<SpeedResult> speeds = read_speeds_and_hards(record_file("bench")).speeds;
    const std::vector<HardResult> hards = read_speeds_and_hards(record_file("hard")).hards;
    Words names;
    for (std::string_view name : structure_names()) {
      const auto has = [&](const auto& r) { return r.structure == name; };
      if (std::any_of(speeds.begin(), speeds.end(), has) && std::any_of(hards.begin(), hards.end(), has))
        names.emplace_back(name);
    }
    Report report;
    report.paretos = pareto_points(names, speeds, hards);
    for (ParetoResult& point : report.paretos) point.image_rmse = image_rmse(point.structure);
    if (!report.paretos.empty()) write(report, "pareto", "");
  }

  /// Root of the mean square over the scenes.
  std::optional<double> image_rmse(const std::string& structure) const {
    double squares = 0;
    std::size_t count = 0;
    for (const RenderResult& r : renders_) {
      if (r.structure != structure) continue;
      squares += r.found.rmse * r.found.rmse;
      ++count;
    }
    return count > 0 ? std::optional(std::sqrt(squares / static_cast<double>(count))) : std::nullopt;
  }

  void make_truth() {
    Words words{
        "truth", "--scenes", "wheels", "--scale", "0.02", "--size", options_.quick ? "96x54" : "192x108"};
    words.insert(words.end(),
                 {"--spp", options_.quick ? "64" : "256", "--frozen-times", options_.quick ? "128" : "1024",
                  "--threads", fmt::format("{}", options_.threads), "-o", (folder_ / "images").string()});
    measure("truth", words);
  }

  void write(const Report& report, const std::string& part, const std::string& command) const {
    write_file(record_file(part), to_json(report, this_machine(), built_commit(), command));
  }

  const ReportOptions& options_;
  const fs::path folder_;
  std::map<std::string, bool> taken_;
  std::vector<RenderResult> renders_;
  bool wrong_ = false;
};

}  // namespace

void run_report(const ReportOptions& options) {
  ReportRun(options).run();
}

}  // namespace stbvh::harness
