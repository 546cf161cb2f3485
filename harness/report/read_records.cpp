#include "harness/report/read_records.h"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

namespace stbvh::harness {
namespace {

using Json = nlohmann::json;

Json read_records(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) {
    throw RecordFileError(
        fmt::format("Cannot read \"{}\": {}.", path.string(), std::generic_category().message(errno)));
  }
  const Json file = Json::parse(stream, nullptr, false);
  if (file.is_discarded()) throw RecordFileError(fmt::format("\"{}\" is not whole JSON.", path.string()));
  const bool is_ours = file.is_object() && file.contains("records") && file["records"].is_array() &&
                       file.contains("machine") && file.contains("commit");
  if (!is_ours) {
    throw RecordFileError(fmt::format("\"{}\" does not hold records of stbvh-ab.", path.string()));
  }
  if (file["records"].empty()) {
    throw RecordFileError(fmt::format("There are no records in \"{}\".", path.string()));
  }
  return file["records"];
}

SpeedResult to_speed(const Json& r) {
  SpeedResult speed;
  speed.scene = r.at("scene");
  speed.structure = r.at("structure");
  speed.rays = r.at("rays");
  speed.ray_count = r.at("ray_count");
  speed.threads = r.at("threads");
  speed.repeats = r.at("repeats");
  speed.ratios_to_embree = r.at("ratios_to_embree").get<std::vector<double>>();
  return speed;
}

HardResult to_hard(const Json& r) {
  HardResult hard;
  hard.family = r.at("family");
  hard.structure = r.at("structure");
  hard.traced = r.at("traced");
  if (!r.at("leaks").is_null()) hard.leaks = r.at("leaks").get<std::size_t>();
  hard.missed = r.at("missed");
  hard.false_hits = r.at("false_hits");
  hard.wrong_primitive = r.at("wrong_primitive");
  hard.within_rounding = r.at("within_rounding");
  if (!r.at("t_error_rel_p99").is_null()) hard.distance.relative.p99 = r.at("t_error_rel_p99");
  return hard;
}

}  // namespace

void check_records(const std::filesystem::path& path) {
  read_records(path);
}

Report read_speeds_and_hards(const std::filesystem::path& path) {
  Report report;
  try {
    for (const Json& record : read_records(path)) {
      const std::string kind = record.at("kind");
      if (kind == "speed") report.speeds.push_back(to_speed(record));
      if (kind == "hard") report.hards.push_back(to_hard(record));
    }
  } catch (const Json::exception&) {
    throw RecordFileError(fmt::format(
        "Records of \"{}\" lack a field: they are of another version of stbvh-ab.", path.string()));
  }
  return report;
}

}  // namespace stbvh::harness
