#include "harness/report/json.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

namespace stbvh::harness {
namespace {

using Json = nlohmann::ordered_json;

Json to_record(const BuildResult& r) {
  return {{"kind", "build"},
          {"scene", r.scene},
          {"structure", r.structure},
          {"triangles", r.triangles},
          {"primitive_segments", r.primitive_segments},
          {"threads", r.threads},
          {"builds", r.builds},
          {"build_s", r.build_s.median},
          {"build_s_min", r.build_s.min},
          {"build_s_max", r.build_s.max},
          {"peak_bytes", r.peak_bytes},
          {"structure_bytes", r.structure_bytes},
          {"monitor_bytes", r.monitor_bytes},
          {"total_bytes", r.total_bytes},
          {"resident_bytes", r.resident_bytes}};
}

Json to_record(const SpeedResult& r) {
  Json ratio;  // null
  Json least;
  Json largest;
  if (r.ratio_to_embree) {
    ratio = r.ratio_to_embree->median;
    least = r.ratio_to_embree->min;
    largest = r.ratio_to_embree->max;
  }
  return {{"kind", "speed"},
          {"scene", r.scene},
          {"structure", r.structure},
          {"rays", r.rays},
          {"ray_count", r.ray_count},
          {"threads", r.threads},
          {"repeats", r.repeats},
          {"mrays_per_s", r.mrays_per_s.median},
          {"mrays_per_s_min", r.mrays_per_s.min},
          {"mrays_per_s_max", r.mrays_per_s.max},
          {"ratio_to_embree", ratio},
          {"ratio_to_embree_min", least},
          {"ratio_to_embree_max", largest},
          {"hits", r.hits}};
}

Json to_record(const ErrorResult& r) {
  return {{"kind", "error"},
          {"scene", r.scene},
          {"structure", r.structure},
          {"rays", r.rays},
          {"traced", r.traced},
          {"oracle_hits", r.oracle_hits},
          {"missed", r.missed},
          {"false_hits", r.false_hits},
          {"wrong_primitive", r.wrong_primitive},
          {"ties", r.ties},
          {"within_rounding", r.within_rounding},
          {"near_edge", r.near_edge},
          {"t_error_rel_p50", r.t_error_rel_p50},
          {"t_error_rel_p99", r.t_error_rel_p99},
          {"t_error_rel_max", r.t_error_rel_max}};
}

/// A file descriptor with an owner.
class OpenFile {
 public:
  OpenFile(const std::filesystem::path& path, int flags)
      : descriptor_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~OpenFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  bool is_open() const { return descriptor_ >= 0; }

  /// Whether all of `text` arrived, also on the disk where there is one. A failure is in errno.
  bool write_all(const std::string& text) {
    std::size_t done = 0;
    while (done < text.size()) {
      const ssize_t n = write(descriptor_, text.data() + done, text.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      done += static_cast<std::size_t>(n);
    }
    return fsync(descriptor_) == 0 || errno == EINVAL || errno == EROFS;
  }

 private:
  int descriptor_;
};

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw ReportFileError(
      fmt::format("Cannot write to \"{}\": {}.", path.string(), std::generic_category().message(error)));
}

bool is_special(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  std::filesystem::path temporary = path;
  temporary += fmt::format(".{}.tmp", getpid());
  return temporary;
}

}  // namespace

std::string to_json(const Report& report, const Machine& machine, const std::string& commit) {
  Json records = Json::array();
  for (const BuildResult& r : report.builds) records.push_back(to_record(r));
  for (const SpeedResult& r : report.speeds) records.push_back(to_record(r));
  for (const ErrorResult& r : report.errors) records.push_back(to_record(r));
  const Json root = {{"machine",
                      {{"cpu", machine.cpu},
                       {"cores", machine.cores},
                       {"memory_gb", machine.memory_gb},
                       {"instruction_set", machine.instruction_set},
                       {"embree", machine.embree}}},
                     {"commit", commit},
                     {"records", std::move(records)}};
  // Names may hold bytes that are not UTF-8 (a file's name): replaced, not thrown over.
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void check_writable(const std::filesystem::path& path) {
  if (path.filename().empty()) fail(path, EISDIR);
  if (is_special(path)) {
    const OpenFile file(path, O_WRONLY | O_NONBLOCK);
    if (!file.is_open() && errno != ENXIO) fail(path, errno);  // ENXIO: a pipe that nobody reads yet
    return;
  }
  const std::filesystem::path temporary = temporary_beside(path);
  const OpenFile file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.is_open()) fail(path, errno);
  unlink(temporary.c_str());
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  if (is_special(path)) {
    OpenFile file(path, O_WRONLY);
    if (!file.is_open() || !file.write_all(text)) fail(path, errno);
    return;
  }
  const std::filesystem::path temporary = temporary_beside(path);
  OpenFile file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.is_open()) fail(path, errno);
  if (!file.write_all(text) || rename(temporary.c_str(), path.c_str()) != 0) {
    const int error = errno;
    unlink(temporary.c_str());
    fail(path, error);
  }
}

}  // namespace stbvh::harness
