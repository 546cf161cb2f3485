#include "harness/report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "harness/report/distinct.h"

namespace stbvh::harness {
namespace {

constexpr double kMega = 1e6;
constexpr std::size_t kSpeedColumns = 4;  // side by side, before another block begins

std::string megabytes(double bytes) {
  return fmt::format("{:.{}f}", bytes / kMega, std::abs(bytes) < 10 * kMega ? 2 : 1);
}

const SpeedResult* find(const std::vector<SpeedResult>& results, const std::string& structure,
                        const std::string& rays) {
  for (const SpeedResult& r : results) {
    if (r.structure == structure && r.rays == rays) return &r;
  }
  return nullptr;
}

std::string speed_cell(const SpeedResult& r) {
  const std::string mrays = fmt::format("{:6.2f}", r.mrays_per_s.median);
  const std::optional<Spread> ratio = r.ratio_to_embree();
  if (!ratio) return "- " + mrays;
  return fmt::format("{:.2f} ({:.2f}-{:.2f}) {}", ratio->median, ratio->min, ratio->max, mrays);
}

std::string in_words(const RecordedAnswer& answer) {
  if (!answer.is_hit) return "nothing";
  if (!answer.hit) return "something";
  const RecordedAnswer::Hit& hit = *answer.hit;
  return fmt::format("triangle {}{} of mesh {} at t = {:.9g}", hit.primitive,
                     hit.face ? fmt::format(" (face {})", *hit.face) : "", hit.mesh, hit.t);
}

/// Speeds of a few kinds of rays side by side.
std::string speed_columns(const std::vector<SpeedResult>& results, std::span<const std::string> kinds) {
  std::string text = fmt::format("{:<21}", "structure");
  for (const std::string& kind : kinds) text += fmt::format("{:>25}", kind);
  text += "\n";
  for (const std::string& structure : distinct(results, &SpeedResult::structure)) {
    text += fmt::format("{:<21}", structure);
    for (const std::string& kind : kinds) {
      const SpeedResult* r = find(results, structure, kind);
      text += fmt::format("{:>25}", r == nullptr ? "-" : speed_cell(*r));
    }
    text += "\n";
  }
  return text;
}

std::string hit_line(const std::vector<SpeedResult>& results, const std::vector<std::string>& kinds) {
  std::string line = "hits";
  for (const std::string& kind : kinds) {
    std::size_t least = SIZE_MAX;
    std::size_t most = 0;
    std::size_t count = 0;
    for (const SpeedResult& r : results) {
      if (r.rays != kind) continue;
      least = std::min(least, r.hits);
      most = std::max(most, r.hits);
      count = r.ray_count;
    }
    const double share = 100.0 * static_cast<double>(most) / static_cast<double>(count);
    line += fmt::format("  {} {:.1f} % of {}", kind, share, count);
    if (least != most) line += fmt::format(" ({} fewer in the structure with least)", most - least);
    line += ";";
  }
  line.pop_back();
  return line + "\n";
}

}  // namespace

std::string machine_line(const Machine& machine, const std::string& commit) {
  return fmt::format("{}, {} cores, {:.0f} GB; Embree {}; stbvh {} on {}\n", machine.cpu, machine.cores,
                     machine.memory_gb, machine.embree, commit, machine.instruction_set);
}

std::string scene_heading(const SceneSummary& scene) {
  return fmt::format("\n== {}: {} triangles in {} meshes, {} primitive segments, buffers {} MB\n", scene.name,
                     scene.triangles, scene.meshes, scene.primitive_segments,
                     megabytes(static_cast<double>(scene.buffer_bytes)));
}

std::string build_table(const std::vector<BuildResult>& results) {
  if (results.empty()) return "";
  const auto embree = std::find_if(results.begin(), results.end(),
                                   [](const BuildResult& r) { return r.structure == "embree"; });
  const auto ratio = [&](double value, double reference) {
    return embree == results.end() || reference <= 0 ? std::string("-")
                                                     : fmt::format("{:.2f}", value / reference);
  };
  std::string text = fmt::format(
      "build, {} threads (ratios to embree; MB = 1e6 bytes; bytes as each one's own monitor counts)\n"
      "{:<21}{:>7}{:>9}{:>18}{:>8}{:>9}{:>9}{:>13}{:>12}{:>7}\n",
      results.front().threads, "structure", "time", "seconds", "min-max (builds)", "memory", "final MB",
      "peak MB", "with buffers", "resident MB", "steps");
  for (const BuildResult& r : results) {
    const bool has_reference = embree != results.end();
    const auto bytes = static_cast<double>(r.structure_bytes);
    text += fmt::format("{:<21}{:>7}{:>9.3f}{:>18}{:>8}{:>9}{:>9}{:>13}{:>12}{:>7}\n", r.structure,
                        ratio(r.build_s.median, has_reference ? embree->build_s.median : 0), r.build_s.median,
                        fmt::format("{:.2f}-{:.2f} ({})", r.build_s.min, r.build_s.max, r.builds),
                        ratio(bytes, has_reference ? static_cast<double>(embree->structure_bytes) : 0),
                        megabytes(bytes), megabytes(static_cast<double>(r.peak_bytes)),
                        megabytes(static_cast<double>(r.total_bytes)),
                        megabytes(static_cast<double>(r.resident_bytes)), r.steps_kept);
  }
  if (const auto off =
          std::max_element(results.begin(), results.end(),
                           [](const auto& a, const auto& b) { return a.max_deviation < b.max_deviation; });
      off->max_deviation > 0) {
    text += fmt::format("steps left out move no vertex by more than {:.2g} (tolerance {:.2g}; scene units)\n",
                        off->max_deviation, off->tolerance);
  }
  return text;
}

std::string speed_table(const std::vector<SpeedResult>& results) {
  if (results.empty()) return "";
  const auto kinds = distinct(results, &SpeedResult::rays);
  std::string text = fmt::format(
      "speed, {} threads, {} repeats (ratio to embree and its least and largest in a repeat; Mrays/s)\n",
      results.front().threads, results.front().repeats);
  for (std::size_t first = 0; first < kinds.size(); first += kSpeedColumns) {
    const std::size_t last = std::min(first + kSpeedColumns, kinds.size());
    text += speed_columns(results, std::span(kinds).subspan(first, last - first));
  }
  text += hit_line(results, kinds);
  if (STBVH_EMBREE_MAJOR == 3)
    text += "Debian's Embree carries assertions, which cost it 1 to 4 % of its speed.\n";
  return text;
}

std::string error_table(const std::vector<ErrorResult>& results) {
  if (results.empty()) return "";
  std::string text = fmt::format("{:<21}{:<17}{:>8}{:>8}{:>14}{:>14}{:>14}{:>7}{:>10}\n", "structure", "rays",
                                 "traced", "hits", "missed", "false", "wrong", "ties", "rounding");
  for (const ErrorResult& r : results) {
    const auto or_dash = [&](const std::string& s) { return r.is_any_hit ? std::string("-") : s; };
    text +=
        fmt::format("{:<21}{:<17}{:>8}{:>8}{:>14}{:>14}{:>14}{:>7}{:>10}\n", r.structure, r.rays, r.traced,
                    r.oracle_hits, bad_count(r.missed, r.traced), bad_count(r.false_hits, r.traced),
                    or_dash(bad_count(r.wrong_primitive, r.traced)), or_dash(fmt::format("{}", r.ties)),
                    fmt::format("{}/{}", r.within_rounding, r.near_edge));
  }
  return text +
         "rounding: answers that differ where the exact one changes within 3 ulps / rays where it can; "
         "counted apart.\n";
}

std::string distance_table(const std::vector<ErrorResult>& results) {
  std::string text;
  const auto percentiles = [](const Percentiles& p) {
    return fmt::format("{:>9.1e}{:>9.1e}{:>9.1e}", p.p50, p.p99, p.max);
  };
  for (const ErrorResult& r : results) {
    if (r.is_any_hit) continue;
    text +=
        fmt::format("{:<21}{:<17}{}  {}  {:>7}{}\n", r.structure, r.rays, percentiles(r.distance.relative),
                    percentiles(r.distance.ulps), r.distance.grazing, percentiles(r.distance.off_plane));
  }
  if (text.empty()) return "";
  return fmt::format(
             "{:<38}{:>27}  {:>27}  {:>34}\n{:<21}{:<17}{:>9}{:>9}{:>9}  {:>9}{:>9}{:>9}  "
             "{:>7}{:>9}{:>9}{:>9}\n",
             "error of t", "relative", "in float spacings", "grazing hits, off the plane", "structure",
             "rays", "p50", "p99", "max", "p50", "p99", "max", "hits", "p50", "p99", "max") +
         text;
}

std::string difference_lines(const std::vector<ErrorResult>& results) {
  std::string lines;
  for (const ErrorResult& result : results) {
    for (const DifferingRay& r : result.differences) {
      lines += fmt::format(
          "  {}, {} {}, {}: from ({:.9g} {:.9g} {:.9g}) along ({:.9g} {:.9g} {:.9g}) at time {:.9g}: it says "
          "{}, the oracle {}; an edge is {:.2g} ulps away\n",
          result.structure, result.rays, r.ray, r.verdict, r.origin[0], r.origin[1], r.origin[2],
          r.direction[0], r.direction[1], r.direction[2], r.time, in_words(r.reported), in_words(r.exact),
          r.edge_distance_ulps);
    }
  }
  return lines;
}

std::string hard_heading() {
  return fmt::format(
      "{:<25}{:<21}{:>8}{:>13}{:>13}{:>13}{:>13}{:>13}{:>13}{:>8}{:>8}{:>14}{:>10}{:>10}{:>10}\n", "family",
      "structure", "traced", "leaks", "missed", "false", "wrong", "any hit", "self", "ties", "near",
      "rounding", "t relative", "ulps", "off plane");
}

std::string hard_row(const HardResult& r) {
  const auto count = [&](std::size_t n) { return bad_count(n, r.traced); };
  const std::string self =
      r.self_hits ? fmt::format("{}/{}", *r.self_hits, r.exact_self_hits.value_or(0)) : "-";
  return fmt::format(
      "{:<25}{:<21}{:>8}{:>13}{:>13}{:>13}{:>13}{:>13}{:>13}{:>8}{:>8}{:>14}{:>10.1e}{:>10.1e}{:>10.1e}\n",
      r.family, r.structure, r.traced, r.leaks ? count(*r.leaks) : "-", count(r.missed), count(r.false_hits),
      count(r.wrong_primitive), count(r.any_hit_wrong), self, r.ties, r.near_misses,
      fmt::format("{}/{}", r.within_rounding, r.near_edge), r.distance.relative.p99, r.distance.ulps.p99,
      r.distance.off_plane.p99);
}

std::string hard_legend() {
  return "any hit: the same rays, asked whether anything is there; self: hits of the triangle that the ray "
         "leaves from / those that are exact;\nnear: misses where the exact answer changes within 3 ulps; "
         "rounding: all answers that differ there / rays where it can; counted apart.\nt: 99th percentiles "
         "of "
         "its error, relative and in float spacings; off plane: of grazing hits, how far from the exact "
         "plane.\n";
}

std::string pareto_table(const std::vector<ParetoResult>& points) {
  const auto rate = [](std::size_t count, std::size_t n) {
    if (n == 0) return std::string("-");
    return fmt::format("{:.1e} (<{:.1e})", static_cast<double>(count) / static_cast<double>(n),
                       rate_bound_95(count, n));
  };
  std::string text = fmt::format("{:<21}{:>20}{:>22}{:>22}{:>12}\n", "structure", "times embree", "leaks",
                                 "differ on needles", "t err p99");
  for (const ParetoResult& p : points) {
    const Spread& ratio = p.ratio_to_embree;
    text += fmt::format(
        "{:<21}{:>20}{:>22}{:>22}{:>12.1e}\n", p.structure,
        ratio.median > 0 ? fmt::format("{:.2f} ({:.2f}-{:.2f})", ratio.median, ratio.min, ratio.max) : "-",
        rate(p.leaks, p.aimed), rate(p.differing, p.thin), p.t_error_rel_p99);
  }
  return text +
         "times embree: geometric mean over scenes, bounce and uniform rays (least and largest); leaks: of "
         "rays "
         "aimed at vertices and edges of closed moving meshes from inside (95 % confidence bound); differ: "
         "answered otherwise than exactly, within rounding or not; t err: relative, 1e6 from the origin.\n";
}

std::string bad_count(std::size_t count, std::size_t n) {
  if (count > 0 || n == 0) return fmt::format("{}", count);
  return fmt::format("0 (<{:.1e})", 3.0 / static_cast<double>(n));
}

}  // namespace stbvh::harness
