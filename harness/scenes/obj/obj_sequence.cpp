#include "harness/scenes/obj/obj_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <new>
#include <optional>
#include <utility>

#include "harness/scenes/gltf/framing.h"
#include "harness/scenes/obj/obj_file.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

/// The number in a file's name, and what stands around it.
struct NumberedFile {
  fs::path path;
  std::string before, after;
  std::size_t number = 0;
};

template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) {
  throw SceneFileError(fmt::format(text, std::forward<Args>(args)...));
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool has_obj_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".obj";
}

std::optional<std::size_t> read_number(const std::string& digits) {
  std::size_t number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stopped, error] = std::from_chars(digits.data(), end, number);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return number;
}

/// Cut at the last number of the stem; nothing if there is none that fits.
std::optional<NumberedFile> cut_at_number(const fs::path& path) {
  const std::string stem = path.stem().string();
  std::size_t end = stem.size();
  while (end > 0 && !is_digit(stem[end - 1])) --end;
  std::size_t begin = end;
  while (begin > 0 && is_digit(stem[begin - 1])) --begin;
  const auto number = read_number(stem.substr(begin, end - begin));
  if (!number) return std::nullopt;
  return NumberedFile{path, stem.substr(0, begin), stem.substr(end), *number};
}

/// "walk_%04d.obj" as the text before and after the number and the number's least width.
struct Pattern {
  std::string before, after;
  std::size_t width = 0;
  char fill = ' ';

  explicit Pattern(const std::string& name) {
    const std::size_t percent = name.find('%');
    std::size_t end = percent + 1;
    while (end < name.size() && is_digit(name[end])) ++end;
    const std::string width_digits = name.substr(percent + 1, end - percent - 1);
    const bool is_sound = end < name.size() && name[end] == 'd' && width_digits.size() <= 3;
    if (!is_sound || name.find('%', end) != std::string::npos)
      fail("{}: a sequence has one number in its name, as in walk_%04d.obj", name);
    before = name.substr(0, percent);
    after = name.substr(end + 1);
    if (width_digits.starts_with('0')) fill = '0';
    if (!width_digits.empty()) width = read_number(width_digits).value_or(0);
  }

  std::string file_name(std::size_t number) const {
    std::string digits = std::to_string(number);
    if (digits.size() < width) digits.insert(0, width - digits.size(), fill);
    return before + digits + after;
  }
};

std::vector<fs::path> list_folder(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? fs::path(".") : folder, error), end;
       !error && entry != end; entry.increment(error)) {
    files.push_back(folder / entry->path().filename());
  }
  if (error) fail("{}: the folder cannot be read", folder.string());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<NumberedFile> files_of_pattern(const fs::path& name) {
  const Pattern pattern(name.filename().string());
  std::vector<NumberedFile> files;
  for (const fs::path& path : list_folder(name.parent_path())) {
    const std::string file = path.filename().string();
    if (file.size() <= pattern.before.size() + pattern.after.size() || !file.starts_with(pattern.before))
      continue;
    std::string digits =
        file.substr(pattern.before.size(), file.size() - pattern.before.size() - pattern.after.size());
    digits.erase(0, std::min(digits.find_first_not_of(' '), digits.size()));
    const auto number = read_number(digits);
    if (number && pattern.file_name(*number) == file)
      files.push_back({path, pattern.before, pattern.after, *number});
  }
  if (files.empty()) fail("{}: there is no such file", name.string());
  return files;
}

std::vector<NumberedFile> files_of_folder(const fs::path& folder) {
  std::vector<fs::path> paths = list_folder(folder);
  std::erase_if(paths, [](const fs::path& path) { return !has_obj_extension(path); });
  if (paths.empty()) fail("{}: the folder has no .obj files", folder.string());
  if (paths.size() == 1) return {{paths[0], {}, {}, 0}};
  std::vector<NumberedFile> files;
  for (const fs::path& path : paths) {
    const auto file = cut_at_number(path);
    if (!file)
      fail("{}: there is no number in its name, so its place in the sequence is unknown", path.string());
    if (!files.empty() && (file->before != files[0].before || file->after != files[0].after))
      fail("{}: it belongs to another sequence than {}", path.string(), files[0].path.string());
    files.push_back(*file);
  }
  return files;
}

/// Refuses gaps and what is there twice.
void check_numbers(const std::vector<NumberedFile>& files, const std::string& name) {
  if (files.size() > kMaxSteps)
    fail("{}: there are {} files, but at most {} steps are possible", name, files.size(), kMaxSteps);
  for (std::size_t i = 1; i < files.size(); ++i) {
    if (files[i].number == files[i - 1].number)
      fail("{} and {} have the same number", files[i - 1].path.string(), files[i].path.string());
    if (files[i].number != files[i - 1].number + 1) {
      fail("{}: number {} of the sequence is missing, between {} and {}", name, files[i - 1].number + 1,
           files[i - 1].path.filename().string(), files[i].path.filename().string());
    }
  }
}

void check_same_topology(const fs::path& path, const ObjFile& file, const fs::path& first_path,
                         std::size_t vertices, const std::vector<std::uint32_t>& indices) {
  if (file.positions.size() != vertices) {
    fail("{}: it has {} vertices, but {} has {}", path.string(), file.positions.size(), first_path.string(),
         vertices);
  }
  if (file.indices.size() != indices.size()) {
    fail("{}: it has {} triangles, but {} has {}", path.string(), file.indices.size() / 3,
         first_path.string(), indices.size() / 3);
  }
  const auto differs = std::mismatch(indices.begin(), indices.end(), file.indices.begin()).first;
  if (differs != indices.end()) {
    fail("{}: its triangle {} has other vertices than in {}", path.string(), (differs - indices.begin()) / 3,
         first_path.string());
  }
}

Scene load(const std::string& name) {
  const std::vector<fs::path> files = find_obj_files(name);
  Mesh mesh;
  mesh.name = obj_scene_name(name);
  for (const fs::path& path : files) {
    ObjFile file = read_obj_file(path);
    if (mesh.steps.empty())
      mesh.indices = std::move(file.indices);
    else
      check_same_topology(path, file, files[0], mesh.steps[0].size(), mesh.indices);
    if (file.positions.size() * sizeof(Vec3f) * files.size() > kMaxSceneFileBytes)
      fail("{}: its vertices need more than {} GB", name, kMaxSceneFileBytes >> 30);
    VertexBuffer& step = mesh.steps.emplace_back(file.positions.size());
    std::copy(file.positions.begin(), file.positions.end(), step.data());
  }
  Scene scene;
  scene.name = mesh.name;
  scene.meshes.push_back(std::move(mesh));
  scene.camera = gltf::framing_camera(scene);
  return scene;
}

}  // namespace

bool is_obj_name(const std::string& name) {
  std::error_code ignored;
  return has_obj_extension(name) || fs::is_directory(name, ignored);
}

std::string obj_scene_name(const std::string& name) {
  fs::path path(name);
  if (!has_obj_extension(path) && !path.has_filename()) path = path.parent_path();  // "folder/"
  std::string stem = has_obj_extension(path) ? path.stem().string() : path.filename().string();
  stem = stem.substr(0, stem.find('%'));
  while (!stem.empty() && std::string_view("_-. ").find(stem.back()) != std::string_view::npos)
    stem.pop_back();
  return stem.empty() ? "obj" : stem;
}

std::vector<fs::path> find_obj_files(const std::string& name) {
  std::error_code ignored;
  const bool is_folder = fs::is_directory(name, ignored);
  if (!is_folder && fs::path(name).filename().string().find('%') == std::string::npos) {
    if (!fs::exists(name, ignored)) fail("{}: there is no such file", name);
    return {name};
  }
  std::vector<NumberedFile> numbered = is_folder ? files_of_folder(name) : files_of_pattern(name);
  std::stable_sort(numbered.begin(), numbered.end(),
                   [](const NumberedFile& a, const NumberedFile& b) { return a.number < b.number; });
  check_numbers(numbered, name);
  std::vector<fs::path> files;
  for (NumberedFile& file : numbered) files.push_back(std::move(file.path));
  return files;
}

Scene load_obj(const std::string& name) {
  try {
    return load(name);
  } catch (const std::bad_alloc&) {
    fail("{}: there is not enough memory for it", name);
  }
}

}  // namespace stbvh::harness
