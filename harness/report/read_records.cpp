#include "harness/report/read_records.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "harness/files/input_file.h"

namespace stbvh::harness {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxBytes = std::size_t{64} << 20;  // a run over all scenes writes one
constexpr int kMaxDepth = 100;                            // of ours: 5

/// What is wrong with a file; to stand behind its name.
struct Problem : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Refuses, while a file is parsed, what parsers disagree about or need a deep stack for.
class ParseChecks {
 public:
  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    if (depth > kMaxDepth) throw Problem(fmt::format("is nested more than {} levels deep", kMaxDepth));
    if (event == Json::parse_event_t::object_start) names_.emplace_back();
    if (event == Json::parse_event_t::object_end) names_.pop_back();
    if (event == Json::parse_event_t::key && !names_.back().insert(parsed.get<std::string>()).second)
      throw Problem(fmt::format("has {} twice in one object", parsed.dump()));
    return true;
  }

 private:
  std::vector<std::set<std::string>> names_;  ///< of the objects that are not closed yet
};

Json parse(const std::string& text) {
  ParseChecks checks;
  Json file = Json::parse(
      text, [&](int depth, Json::parse_event_t event, Json& parsed) { return checks(depth, event, parsed); },
      false);
  if (file.is_discarded()) throw Problem("is not whole JSON");
  return file;
}

/// As machine_type() of record_files.py.
std::string machine_type(const Json& machine) {
  const auto fact = [&](const char* name) {
    const Json value = machine.is_object() ? machine.value(name, Json()) : Json();
    return value.is_string() ? value.get<std::string>() : value.dump();
  };
  return fmt::format("{}, {} cores, Embree {}", fact("cpu"), fact("cores"), fact("embree"));
}

Json file_of_records(const std::string& text) {
  Json file = parse(text);
  const bool is_ours = file.is_object() && file.contains("records") && file["records"].is_array() &&
                       file.contains("machine") && file.contains("commit");
  if (!is_ours) throw Problem("does not hold records of stbvh-ab");
  if (file["records"].empty()) throw Problem("has no records");
  return file;
}

/// Takes the fields of one record, each as what it should be.
class Fields {
 public:
  explicit Fields(const Json& record) : record_(record) {
    if (!record.is_object()) throw Problem("holds a record that is not an object");
  }

  std::string text(const char* name) const {
    const Json& value = field(name);
    if (!value.is_string()) wrong(name, "a text");
    return value;
  }
  std::size_t count(const char* name) const {
    const Json& value = field(name);
    if (!value.is_number_unsigned()) wrong(name, "a count");
    return value;
  }
  double number(const char* name) const {
    const Json& value = field(name);
    if (!value.is_number()) wrong(name, "a number");
    return value;
  }
  /// Positive ones.
  std::vector<double> ratios(const char* name) const {
    const Json& values = field(name);
    const auto is_ratio = [](const Json& v) { return v.is_number() && v.get<double>() > 0; };
    if (!values.is_array() || !std::all_of(values.begin(), values.end(), is_ratio))
      wrong(name, "an array of numbers above zero");
    return values;
  }
  bool is_null(const char* name) const { return field(name).is_null(); }

 private:
  const Json& field(const char* name) const {
    const auto found = record_.find(name);
    if (found == record_.end())
      throw Problem(
          fmt::format("has a record that lacks \"{}\": it is of another version of stbvh-ab", name));
    return *found;
  }
  [[noreturn]] static void wrong(const char* name, const char* what) {
    throw Problem(fmt::format("has a record whose \"{}\" is not {}", name, what));
  }

  const Json& record_;
};

SpeedResult to_speed(const Fields& r) {
  SpeedResult speed;
  speed.scene = r.text("scene");
  speed.structure = r.text("structure");
  speed.rays = r.text("rays");
  speed.ray_count = r.count("ray_count");
  speed.threads = static_cast<unsigned>(std::min<std::size_t>(r.count("threads"), 0xFFFFFFFFu));
  speed.repeats = r.count("repeats");
  speed.ratios_to_embree = r.ratios("ratios_to_embree");
  return speed;
}

HardResult to_hard(const Fields& r) {
  HardResult hard;
  hard.family = r.text("family");
  hard.structure = r.text("structure");
  hard.traced = r.count("traced");
  if (!r.is_null("leaks")) hard.leaks = r.count("leaks");
  hard.missed = r.count("missed");
  hard.false_hits = r.count("false_hits");
  hard.wrong_primitive = r.count("wrong_primitive");
  hard.within_rounding = r.count("within_rounding");
  if (!r.is_null("t_error_rel_p99")) hard.distance.relative.p99 = r.number("t_error_rel_p99");
  return hard;
}

ReadReport speeds_and_hards(const Json& file) {
  ReadReport report;
  report.machine = machine_type(file["machine"]);
  for (const Json& record : file["records"]) {
    const Fields fields(record);
    const std::string kind = fields.text("kind");
    if (kind == "speed") report.speeds.push_back(to_speed(fields));
    if (kind == "hard") report.hards.push_back(to_hard(fields));
  }
  return report;
}

}  // namespace

ReadReport read_speeds_and_hards(const std::filesystem::path& path) {
  std::string problem;
  try {
    return speeds_and_hards(file_of_records(read_whole_file(path, kMaxBytes)));
  } catch (const InputFileError& e) {
    problem = e.what();
  } catch (const Problem& e) {
    problem = e.what();
  }
  throw RecordFileError(fmt::format("The file of records \"{}\" {}.", path.string(), problem));
}

}  // namespace stbvh::harness
