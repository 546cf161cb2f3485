#include "harness/scenes/obj/obj_sequence.h"

#include <dirent.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <memory>
#include <optional>
#include <regex>
#include <string_view>
#include <system_error>
#include <utility>

#include "harness/scenes/name_list.h"
#include "harness/scenes/scene.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

/// The number in a file's name, and what stands around it.
struct NumberedFile {
  fs::path path;
  std::string before, after;
  std::int64_t number = 0;
};

template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) {
  throw SceneFileError(fmt::format(text, std::forward<Args>(args)...));
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_alphanumeric(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool has_obj_extension(const fs::path& path) {
  return lower(path.extension().string()) == ".obj";
}

bool is_hidden(const fs::path& path) {
  return path.filename().string().starts_with('.');
}

std::optional<std::int64_t> read_number(std::string_view digits) {
  std::int64_t number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stopped, error] = std::from_chars(digits.data(), end, number);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return number;
}

/// Cut at the last number of the stem; nothing if there is none that fits. A dash is its sign where no letter
/// or digit stands before it: "w_-1", but not "walk-1".
std::optional<NumberedFile> cut_at_number(const fs::path& path) {
  const std::string stem = path.stem().string();
  std::size_t end = stem.size();
  while (end > 0 && !is_digit(stem[end - 1])) --end;
  std::size_t begin = end;
  while (begin > 0 && is_digit(stem[begin - 1])) --begin;
  if (begin > 0 && stem[begin - 1] == '-' && (begin == 1 || !is_alphanumeric(stem[begin - 2]))) --begin;
  const auto number = read_number(std::string_view(stem).substr(begin, end - begin));
  if (!number) return std::nullopt;
  return NumberedFile{path, stem.substr(0, begin), stem.substr(end), *number};
}

/// Where the numbers of a pattern stand: those as in printf, or where there are none, those in other forms. A
/// % that is doubled, or begins no number, is only itself.
std::vector<std::string_view> numbers_in(std::string_view name) {
  static const std::regex kPrintf(R"(%%|%[0-9]{0,3}d)"), kOthers(R"(#+|\$F[0-9]{0,3})");
  std::vector<std::string_view> numbers;
  for (const std::regex* const form : {&kPrintf, &kOthers}) {
    const char* const end = name.data() + name.size();
    for (std::cregex_iterator match(name.data(), end, *form), last; match != last; ++match) {
      if (match->str() != "%%")
        numbers.push_back(name.substr(static_cast<std::size_t>(match->position()), match->str().size()));
    }
    if (!numbers.empty()) break;
  }
  return numbers;
}

std::string without_doubled_percents(std::string_view text) {
  std::string single;
  for (std::size_t i = 0; i < text.size(); ++i) {
    single += text[i];
    if (text.substr(i, 2) == "%%") ++i;
  }
  return single;
}

/// "walk_%04d.obj" as the text before and after the number. Its width does not matter: what is there in two
/// widths has the same number twice.
struct Pattern {
  std::string before, after;

  /// Nothing where `name` has no number, or more than one.
  static std::optional<Pattern> read(std::string_view name) {
    const std::vector<std::string_view> numbers = numbers_in(name);
    if (numbers.size() != 1) return std::nullopt;
    const auto begin = static_cast<std::size_t>(numbers[0].data() - name.data());
    return Pattern{without_doubled_percents(name.substr(0, begin)),
                   without_doubled_percents(name.substr(begin + numbers[0].size()))};
  }

  /// What stands in the place of the number; nothing where the name is of another kind. The case of letters
  /// behind the number does not matter, as extensions are written in both.
  std::optional<std::string> number_in(const std::string& file) const {
    if (file.size() <= before.size() + after.size() || !file.starts_with(before)) return std::nullopt;
    const std::size_t end = file.size() - after.size();
    if (lower(file.substr(end)) != lower(after)) return std::nullopt;
    const std::string text = file.substr(before.size(), end - before.size());
    return text.substr(std::min(text.find_first_not_of(' '), text.size() - 1));
  }
};

bool begins_as_number(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return !text.empty() && is_digit(text.front());
}

/// By POSIX: where memory runs out, libstdc++'s directory_iterator ends the process (14's by a stray read).
std::vector<fs::path> list_folder(const fs::path& folder) {
  const std::unique_ptr<DIR, int (*)(DIR*)> open(opendir(folder.empty() ? "." : folder.c_str()), closedir);
  errno = open ? 0 : errno;
  std::vector<fs::path> files;
  while (const dirent* const entry = open ? readdir(open.get()) : nullptr) {
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") files.push_back(folder / name);
    errno = 0;
  }
  if (errno != 0)
    fail("{}: the folder cannot be read: {}", folder.string(), std::generic_category().message(errno));
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<NumberedFile> files_of_pattern(const fs::path& name) {
  const auto pattern = Pattern::read(name.filename().string());
  if (!pattern) {
    fail("{}: a sequence has one number in its name, as in walk_%04d.obj, walk_####.obj or walk_$F4.obj",
         name.filename().string());
  }
  std::vector<NumberedFile> files;
  for (const fs::path& path : list_folder(name.parent_path())) {
    const auto text = pattern->number_in(path.filename().string());
    if (!text || !begins_as_number(*text)) continue;
    const auto number = read_number(*text);
    if (!number) fail("{}: \"{}\" stands in its name where a number should", path.string(), *text);
    files.push_back({path, pattern->before, pattern->after, *number});
  }
  if (files.empty()) fail("{}: there is no such file", name.string());
  return files;
}

/// Takes the hidden files out, such as those that macOS leaves beside others.
void leave_out_hidden(std::vector<fs::path>& paths, const fs::path& folder, const SceneWarning& warn) {
  NameList names;
  for (const fs::path& path : paths) {
    if (is_hidden(path)) names.add(path.filename().string());
  }
  if (names.count() == 0) return;
  std::erase_if(paths, is_hidden);
  if (paths.empty())
    fail("{}: the folder has no .obj files but hidden ones, which are left out: {}", folder.string(),
         names.text());
  if (warn) warn(fmt::format("{}: hidden files are left out: {}", folder.string(), names.text()));
}

std::vector<NumberedFile> files_of_folder(const fs::path& folder, const SceneWarning& warn) {
  std::vector<fs::path> paths = list_folder(folder);
  std::erase_if(paths, [](const fs::path& path) { return !has_obj_extension(path); });
  leave_out_hidden(paths, folder, warn);
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

std::uint64_t distance(std::int64_t from, std::int64_t to) {
  return static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from);
}

/// The step of a sequence in which all numbers are as far from the next one, for people who did not know of
/// it.
std::string step_hint(const std::vector<NumberedFile>& files) {
  const std::uint64_t step = distance(files[0].number, files[1].number);
  for (std::size_t i = 1; i < files.size(); ++i) {
    if (distance(files[i - 1].number, files[i].number) != step) return {};
  }
  return fmt::format(" (with --step {} the numbers go up by {})", step, step);
}

/// Refuses gaps and what is there twice, or between.
void check_numbers(const std::vector<NumberedFile>& files, const std::string& name, std::size_t step) {
  if (files.size() > kMaxSceneSteps)
    fail("{}: there are {} files, but at most {} steps are possible", name, files.size(), kMaxSceneSteps);
  for (std::size_t i = 1; i < files.size(); ++i) {
    const NumberedFile &last = files[i - 1], &file = files[i];
    const std::uint64_t apart = distance(last.number, file.number);
    if (apart == 0) fail("{} and {} have the same number", last.path.string(), file.path.string());
    if (apart < step)
      fail("{}: its number is only {} more than that of {}, not {}", file.path.string(), apart,
           last.path.filename().string(), step);
    if (apart > step) {
      fail("{}: number {} of the sequence is missing, between {} and {}{}", name,
           last.number + static_cast<std::int64_t>(step), last.path.filename().string(),
           file.path.filename().string(), step_hint(files));
    }
  }
}

}  // namespace

std::vector<fs::path> find_obj_files(const std::string& name, const SceneWarning& warn,
                                     std::size_t number_step) {
  std::error_code unreachable;  // what is wrong with it then, the reader of files says
  const fs::file_status status = fs::status(name, unreachable);
  const std::string file_name = fs::path(name).filename().string();
  const bool is_there = status.type() != fs::file_type::not_found;
  if (is_there && !fs::is_directory(status)) return {name};
  if (!is_there && file_name.find_first_of("%#$") == std::string::npos)
    fail("{}: there is no such file", name);
  std::vector<NumberedFile> numbered = is_there ? files_of_folder(name, warn) : files_of_pattern(name);
  std::stable_sort(numbered.begin(), numbered.end(),
                   [](const NumberedFile& a, const NumberedFile& b) { return a.number < b.number; });
  check_numbers(numbered, name, number_step);
  std::vector<fs::path> files;
  for (NumberedFile& file : numbered) files.push_back(std::move(file.path));
  return files;
}

bool is_obj_name(const std::string& name) {
  std::error_code ignored;
  return has_obj_extension(name) || fs::is_directory(name, ignored);
}

std::string obj_scene_name(const std::string& name) {
  fs::path path(name);
  if (!has_obj_extension(path) && !path.has_filename()) path = path.parent_path();  // "folder/"
  std::string stem = has_obj_extension(path) ? path.stem().string() : path.filename().string();
  std::error_code ignored;
  const auto pattern = fs::exists(path, ignored) ? std::nullopt : Pattern::read(stem);
  if (pattern) stem = pattern->before;
  while (!stem.empty() && std::string_view("_-. ").find(stem.back()) != std::string_view::npos)
    stem.pop_back();
  return stem.empty() ? "obj" : stem;
}

}  // namespace stbvh::harness
