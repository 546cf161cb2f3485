#include "harness/scenes/embree_xml/ecs.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "harness/files/input_file.h"
#include "harness/files/numbers.h"
#include "harness/files/text.h"
#include "harness/scenes/embree_xml/disc_light.h"
#include "harness/scenes/reach.h"

namespace stbvh::harness::embree_xml {
namespace {

std::deque<std::string> words_of(const std::filesystem::path& file) {
  const std::string text = read_text_file(file, kMaxHandwrittenBytes);
  std::deque<std::string> words;
  for (std::string_view rest = text; !rest.empty();) {
    std::string_view line = take_line(rest);
    line = without_comment(line);
    for (auto word = take_word(line); !word.empty(); word = take_word(line)) words.emplace_back(word);
  }
  return words;
}

/// Whether a word begins with a dash and is no number.
bool is_option(const std::string& word) {
  return word.size() > 1 && word.front() == '-' && !to_number<float>(word);
}

class Parser {
 public:
  Parser(const std::filesystem::path& file) : folder_(file.parent_path()), words_(words_of(file)) {}

  CommandList parse(const Warn& warn) {
    std::string ignored;
    while (!words_.empty()) {
      std::string name = words_.front();
      words_.pop_front();
      const std::string as_written = name;
      name.erase(0, std::min(name.find_first_not_of('-'), name.size()));
      if (!is_option(as_written))
        throw Problem(fmt::format("\"{}\" stands where an option should", as_written));
      if (known(name)) continue;
      ignored += (ignored.empty() ? "" : ", ") + as_written;
      while (!words_.empty() && !is_option(words_.front())) words_.pop_front();
    }
    if (!ignored.empty())
      warn(fmt::format("Options that do not change the scene, or that are not supported, are left out: {}.",
                       ignored));
    if (list_.scene_files.empty()) throw Problem("it names no scene file (-i FILE.xml)");
    return std::move(list_);
  }

 private:
  bool known(const std::string& name) {
    if (name == "i") {
      list_.scene_files.push_back(folder_ / text(name));
    } else if (name == "camera") {
      list_.camera_name = text(name);
    } else if (name == "vp") {
      list_.position = near_vector(name);
    } else if (name == "vi") {
      list_.target = near_vector(name);
      list_.direction.reset();
    } else if (name == "vd") {
      list_.direction = near_vector(name);
      list_.target.reset();
    } else if (name == "vu") {
      list_.up = near_vector(name);
    } else if (name == "fov") {
      list_.vertical_fov_degrees = number(name);
      if (!(*list_.vertical_fov_degrees > 0 && *list_.vertical_fov_degrees < 180))
        throw Problem("-fov must be above 0 and below 180");
    } else if (name == "ambientlight") {
      const Vec3f more = vector(name), sum = list_.ambient.value_or(Vec3f{0, 0, 0});
      list_.ambient = Vec3f{sum.x + more.x, sum.y + more.y, sum.z + more.z};
    } else if (name == "dirlight" || name == "directionallight" || name == "distantlight") {
      add_light(name);
    } else {
      return name == "righthanded";  // as we are
    }
    return true;
  }

  void add_light(const std::string& name) {
    DirectionalLight light;
    light.direction = vector(name);
    light.irradiance = vector(name);
    if (name == "distantlight") {
      light.half_angle_degrees = number(name);
      light.irradiance = scaled(light.irradiance, projected_solid_angle(light.half_angle_degrees));
    }
    list_.directional_lights.push_back(light);
  }

  std::string text(const std::string& option) {
    if (words_.empty()) throw Problem(fmt::format("-{} lacks its argument", option));
    std::string word = words_.front();
    words_.pop_front();
    return word;
  }

  float number(const std::string& option) {
    const auto value = to_number<float>(text(option));
    if (!value || !std::isfinite(*value)) throw Problem(fmt::format("-{} lacks a number", option));
    return *value;
  }

  Vec3f vector(const std::string& option) {
    const float x = number(option), y = number(option), z = number(option);
    return {x, y, z};
  }

  Vec3f near_vector(const std::string& option) {
    const Vec3f v = vector(option);
    if (!is_within_reach(to_double(v))) throw Problem(fmt::format("-{} is too far away", option));
    return v;
  }

  std::filesystem::path folder_;
  std::deque<std::string> words_;
  CommandList list_;
};

}  // namespace

Camera camera_of(const CommandList& list, Camera camera) {
  camera.position = list.position.value_or(camera.position);
  camera.target = list.target.value_or(camera.target);
  if (list.direction) {
    const Vec3f &p = camera.position, &d = *list.direction;
    camera.target = {p.x + d.x, p.y + d.y, p.z + d.z};
  }
  camera.up = list.up.value_or(camera.up);
  camera.vertical_fov_degrees = list.vertical_fov_degrees.value_or(camera.vertical_fov_degrees);
  return camera;
}

CommandList read_command_list(const std::filesystem::path& file, const Warn& warn) {
  return Parser(file).parse(warn);
}

}  // namespace stbvh::harness::embree_xml
