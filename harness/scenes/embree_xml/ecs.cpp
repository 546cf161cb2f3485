#include "harness/scenes/embree_xml/ecs.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <system_error>
#include <utility>

#include "harness/files/input_file.h"
#include "harness/files/numbers.h"
#include "harness/files/text.h"
#include "harness/scenes/embree_xml/disc_light.h"
#include "harness/scenes/light_check.h"
#include "harness/scenes/reach.h"

namespace stbvh::harness::embree_xml {
namespace {

namespace fs = std::filesystem;

/// Most lists that one names with -c, and those with theirs.
constexpr std::size_t kMostLists = 100;

/// Words are separated by blanks, but in double quotes. A # that begins a word begins a comment.
std::deque<std::string> words_of(const fs::path& file) {
  const std::string text = read_text_file(file, kMaxHandwrittenBytes);
  std::deque<std::string> words;
  for (std::string_view rest = text; !rest.empty();) {
    std::string_view line = take_line(rest);
    for (line = without_leading_blanks(line); !line.empty() && line.front() != '#';
         line = without_leading_blanks(line)) {
      const bool is_quoted = line.front() == '"';
      if (is_quoted) line.remove_prefix(1);
      const std::size_t end = is_quoted ? line.find('"') : line.find_first_of(kBlanks);
      const std::string_view word = line.substr(0, end);
      if (is_quoted && end == line.npos)
        throw Problem(fmt::format("the quote before {} is not closed", word));
      words.emplace_back(word);
      line.remove_prefix(word.size() + (is_quoted ? 1 : 0));
    }
  }
  return words;
}

fs::path canonical_path(const fs::path& file) {
  std::error_code unreachable;  // reading says it
  fs::path path = fs::weakly_canonical(file, unreachable);
  return unreachable ? file : path;
}

/// Whether a word begins with a dash and is no number.
bool is_option(const std::string& word) {
  return word.size() > 1 && word.front() == '-' && !to_number<float>(word);
}

class Parser {
 public:
  CommandList parse(const fs::path& file, const Warn& warn) {
    open_.push_back(canonical_path(file));
    read(file);
    if (!ignored_.empty())
      warn(fmt::format("Options that do not change the scene, or that are not supported, are left out: {}.",
                       ignored_));
    if (names_frames_)
      warn("-animlist is left out: its files are frames that follow each other, and a scene has one.");
    if (list_.scene_files.empty()) throw Problem("it names no scene file (-i FILE.xml)");
    return std::move(list_);
  }

 private:
  /// All of a list, between the words of the one that names it.
  void read(const fs::path& file) {
    if (++lists_ > kMostLists) throw Problem(fmt::format("it names more than {} lists", kMostLists));
    std::deque<std::string> outer = std::exchange(words_, words_of(file));
    const fs::path outer_folder = std::exchange(folder_, file.parent_path());
    while (!words_.empty()) {
      std::string name = words_.front();
      words_.pop_front();
      const std::string as_written = name;
      name.erase(0, std::min(name.find_first_not_of('-'), name.size()));
      if (!is_option(as_written))
        throw Problem(fmt::format("\"{}\" stands where an option should", as_written));
      if (known(name)) continue;
      ignored_ += (ignored_.empty() ? "" : ", ") + as_written;
      while (!words_.empty() && !is_option(words_.front())) words_.pop_front();
    }
    words_ = std::move(outer);
    folder_ = outer_folder;
  }

  /// A list that another names: what is wrong with it is said with its name.
  void read_inner(const fs::path& file) {
    if (std::ranges::find(open_, canonical_path(file)) != open_.end())
      throw Problem(fmt::format("\"{}\" names itself with -c", file.string()));
    open_.push_back(canonical_path(file));
    try {
      read(file);
    } catch (const InputFileError& problem) {
      throw Problem(fmt::format("\"{}\", which it names with -c, {}", file.string(), problem.what()));
    } catch (const Problem& problem) {
      throw Problem(fmt::format("in \"{}\": {}", file.string(), problem.what()));
    }
    open_.pop_back();
  }

  bool known(const std::string& name) {
    if (name == "i") {
      list_.scene_files.push_back(folder_ / text(name));
    } else if (name == "c") {
      read_inner(folder_ / text(name));
    } else if (name == "animlist") {
      text(name);
      names_frames_ = true;
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
      if (const std::string flaw = flaw_of(more); !flaw.empty())
        throw Problem(fmt::format("-{} {}", name, flaw));
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
      if (!is_half_angle(light.half_angle_degrees))
        throw Problem(fmt::format("-{} needs a half angle above 0 and up to 90 degrees", name));
      light.irradiance = scaled(light.irradiance, projected_solid_angle(light.half_angle_degrees));
    }
    if (const std::string flaw = flaw_of(light); !flaw.empty())
      throw Problem(fmt::format("-{} {}", name, flaw));
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

  fs::path folder_;  ///< of the list that is read
  std::deque<std::string> words_;
  std::vector<fs::path> open_;  ///< lists that are read, each named by the one before
  std::size_t lists_ = 0;       ///< so far
  CommandList list_;
  std::string ignored_;
  bool names_frames_ = false;
};

}  // namespace

Camera camera_of(const CommandList& list, Camera camera) {
  camera.position = list.position.value_or(camera.position);
  camera.target = list.target.value_or(camera.target);
  if (list.direction) {
    const Vec3 from = to_double(camera.position), way = to_double(*list.direction);
    camera.target = to_float(from + way * share_within_reach(from, way));
  }
  camera.up = list.up.value_or(camera.up);
  camera.vertical_fov_degrees = list.vertical_fov_degrees.value_or(camera.vertical_fov_degrees);
  return camera;
}

CommandList read_command_list(const fs::path& file, const Warn& warn) {
  return Parser().parse(file, warn);
}

}  // namespace stbvh::harness::embree_xml
