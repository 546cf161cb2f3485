#include "harness/preview/preview_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "harness/images/exr_file.h"
#include "harness/images/png_file.h"
#include "harness/preview/render_command.h"
#include "harness/program/closest_name.h"
#include "harness/program/picture_metadata.h"
#include "harness/program/scene_source.h"
#include "harness/program/usage_error.h"
#include "harness/rays/ray_generator.h"
#include "harness/scenes/scene_file.h"
#include "harness/scenes/scene_hash.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {

namespace fs = std::filesystem;

PreviewModel::PreviewModel(const ModelOptions& options, std::size_t most_samples,
                           PreviewSession::OnNews on_news)
    : options_(options),
      most_samples_(most_samples),
      session_(options.threads, most_samples, std::move(on_news)) {
  for (std::size_t slot = 0; slot < kSlots && slot < options.structures.size(); ++slot)
    structures_[slot] = options.structures[slot];
}

void PreviewModel::open(const std::string& name) {
  try {
    session_.loader().request({find_scene(name, options_), name, structures_});
    say("");
  } catch (const UserError& e) {
    say(e.what());
  }
}

void PreviewModel::choose_structure(std::size_t slot, const std::string& name) {
  const std::vector<std::string_view> known = structure_names();
  const bool is_none = name.empty() && slot > 0;
  if (!is_none && std::find(known.begin(), known.end(), name) == known.end())
    throw UsageError(unknown_name("structure", name, known));
  if (structures_[slot] == name) return;
  structures_[slot] = name;
  session_.loader().request({std::nullopt, "", structures_});
}

RenderSettings PreviewModel::settings() const {
  RenderSettings settings;
  settings.width = width_;
  settings.height = height_;
  settings.seed = options_.seed;
  settings.threads = options_.threads;
  settings.camera = camera.camera();
  settings.lens.radius = lens_radius;
  settings.shutter = animation.shutter();
  return settings;
}

void PreviewModel::update(double elapsed, std::size_t width, std::size_t height) {
  const std::uint64_t scene_before = state_.scene_number;
  state_ = session_.state();
  if (state_.scene_number != scene_before) {
    camera = CameraController(state_.structures[0]->scene->camera);
    picked_path_.clear();
  }
  if (animation.advance(elapsed)) ++frames_played_;
  width_ = std::clamp<std::size_t>(width, 1, kMaxPictureSide);
  height_ = std::clamp<std::size_t>(height, 1, kMaxPictureSide);
  session_.set_settings(settings(), state_.scene_number);
  const std::uint64_t scene_now = state_.scene_number;
  const LoadProgress loading = load_progress();  // before the state: what was built until then is in it
  state_ = session_.state();
  if (state_.scene_number != scene_now) state_.scene_number = scene_now;  // seen as new in the next call
  if (loading.ended != requests_ended_ && !loading.problem.empty()) say(loading.problem);
  requests_ended_ = loading.ended;
  is_loaded_ = !loading.is_busy;
}

bool PreviewModel::is_building(std::size_t slot) const {
  const BuiltStructurePtr& built = state_.structures[slot];
  const bool is_there = structures_[slot].empty() || (built && built->name == structures_[slot]);
  return !is_there && load_progress().is_busy;
}

float PreviewModel::tree_time() const {
  return static_cast<float>(animation.is_playing ? animation.shutter().open : animation.time());
}

const Structure* PreviewModel::tree() const {
  for (const BuiltStructurePtr& built : state_.structures) {
    if (built && built->structure->tree() != nullptr) return built->structure->tree();
  }
  return nullptr;
}

TimeLine PreviewModel::time_line() const {
  const Structure* t = tree();
  if (t == nullptr) return {};
  return harness::time_line(*t, picked_path_, tree_options.subtree_level, tree_options.depth,
                            tree_options.axis);
}

const ViewImage& PreviewModel::view() {
  if (!state_.picture) return view_;
  ComposeKey key{.picture = state_.picture_number,
                 .version = state_.picture->version,
                 .options = view_options,
                 .tree = tree_options.shows_boxes ? tree() : nullptr,
                 .level = tree_options.level,
                 .time = tree_time()};
  if (key == composed_ && view_.number > 0) return view_;
  const bool has_new_boxes = key.picture != composed_.picture || key.tree != composed_.tree ||
                             key.level != composed_.level || key.time != composed_.time;
  if (key.tree == nullptr) {
    boxes_ = {};
  } else if (has_new_boxes) {
    boxes_ = boxes_at(*key.tree, key.level, key.time);
  }
  composed_ = key;
  view_.image = composer_.compose(*state_.picture, view_options);
  if (key.tree != nullptr) draw_boxes(view_.image, boxes_.boxes, *state_.picture->settings.camera);
  ++view_.number;
  return view_;
}

std::optional<PreviewModel::Pick> PreviewModel::pick(double x, double y) const {
  if (!state_.structures[0] || width_ == 0) return std::nullopt;
  const LensCamera lens(camera.camera(), {}, width_, height_);
  const CameraRay through = lens.ray({x * static_cast<double>(width_), y * static_cast<double>(height_)}, {});
  Ray ray{.origin = to_float(through.origin),
          .tnear = 0,
          .direction = to_float(through.direction),
          .time = tree_time(),
          .tfar = std::numeric_limits<float>::infinity(),
          .mask = 0xFFFFFFFFu};
  Hit hit;
  if (!is_traceable(ray) || !state_.structures[0]->structure->intersect_one(ray, hit)) return std::nullopt;
  return Pick{hit, through.origin + static_cast<double>(hit.t) * through.direction};
}

bool PreviewModel::focus(double x, double y) {
  const auto picked = pick(x, y);
  if (picked) camera.focus(picked->point);
  return picked.has_value();
}

bool PreviewModel::pick_subtree(double x, double y) {
  const auto picked = pick(x, y);
  if (!picked || tree() == nullptr) return false;
  picked_path_ = path_to(*tree(), picked->hit.mesh, picked->hit.prim_id, tree_time(), picked->point);
  return true;
}

std::string PreviewModel::command_line() const {
  if (!state_.structures[0]) return {};
  RenderSettings now = settings();
  now.samples_per_pixel = std::max<std::size_t>(state_.figures.samples, 1);
  return render_command(options_, state_.structures[0]->asked_scene, structures_, now);
}

void PreviewModel::save(const fs::path& path) {
  if (!state_.picture) return say("There is no picture to save yet.");
  fs::path base = path;
  base.replace_extension();
  try {
    check_writable(base.string() + ".exr");
    write_png(view().image, base.string() + ".png");
  } catch (const OutputFileError& e) {
    return say(e.what());
  }
  {
    const std::lock_guard lock(message_mutex_);
    ++saving_;
  }
  session_.with_picture([this, base](const GrowingPicture& picture, const BuiltPair& structures,
                                     const RenderSettings& settings) {
    std::string said;
    try {
      write_layers(base, picture, structures, settings);
      said = fmt::format("Saved {}.png and {}.exr.", base.string(), base.string());
    } catch (const std::exception& e) {
      said = e.what();
    }
    const std::lock_guard lock(message_mutex_);
    message_ = said;
    --saving_;
  });
}

void PreviewModel::write_layers(const fs::path& base, const GrowingPicture& picture,
                                const BuiltPair& structures, const RenderSettings& settings) {
  RenderSettings made = settings;
  made.samples_per_pixel = picture.figures().samples;
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    if (!structures[slot]) continue;
    Rendering rendering = picture.rendering(slot);
    const BuiltStructure& built = *structures[slot];
    rendering.image.metadata = making_metadata(made, *built.scene, scene_hash(*built.scene), built.name, {});
    add_outcome(made, rendering);
    std::array<std::string, kSlots> one{built.name, ""};
    rendering.image.metadata.emplace_back("command", render_command(options_, built.asked_scene, one, made));
    write_exr(rendering.image, base.string() + (slot == 0 ? ".exr" : "-b.exr"));
  }
}

bool PreviewModel::is_saving() const {
  const std::lock_guard lock(message_mutex_);
  return saving_ > 0;
}

bool PreviewModel::has_samples(std::size_t samples) const {
  return is_loaded_ && !load_progress().is_busy && state_.is_up_to_date &&
         state_.figures.samples >= std::min(samples, most_samples_);
}

void PreviewModel::say(const std::string& sentence) {
  const std::lock_guard lock(message_mutex_);
  message_ = sentence;
}

std::string PreviewModel::message() const {
  if (!state_.problem.empty()) return state_.problem;
  const std::lock_guard lock(message_mutex_);
  return message_;
}

}  // namespace stbvh::harness
