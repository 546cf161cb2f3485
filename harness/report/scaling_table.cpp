#include <fmt/format.h>

#include "harness/report/distinct.h"
#include "harness/report/table.h"

namespace stbvh::harness {
namespace {

double per_triangle(double value, const BuildResult& build) {
  return value / static_cast<double>(build.triangles);
}

std::string row(const ScalingResult& r) {
  const BuildResult& b = r.build;
  const auto bytes = static_cast<double>(b.structure_bytes);
  std::string text =
      fmt::format("{:<21}{:>10}{:>10}{:>9.3f}{:>13.0f}{:>10.2f}{:>16.1f}{:>14.1f}", b.structure, r.value,
                  b.triangles, b.build_s.median, per_triangle(b.build_s.median * 1e9, b), bytes / 1e6,
                  per_triangle(bytes, b), per_triangle(static_cast<double>(b.peak_bytes), b));
  for (const SpeedResult& speed : r.speeds) text += fmt::format("{:>10.2f}", speed.mrays_per_s.median);
  return text + "\n";
}

}  // namespace

std::string scaling_table(const std::vector<ScalingResult>& results) {
  if (results.empty()) return "";
  std::string text =
      fmt::format("\n{:<21}{:>10}{:>10}{:>9}{:>13}{:>10}{:>16}{:>14}", "structure", results.front().over,
                  "in scene", "build s", "ns/triangle", "MB", "bytes/triangle", "peak bytes/t");
  for (const SpeedResult& speed : results.front().speeds) text += fmt::format("{:>10}", speed.rays);
  text += "\n";
  for (const std::string& structure :
       distinct(results, [](const ScalingResult& r) -> const std::string& { return r.build.structure; })) {
    for (const ScalingResult& r : results) {
      if (r.build.structure == structure) text += row(r);
    }
  }
  return text +
         "in scene: triangles; ns/triangle: build time; peak bytes/t: largest while building, for each "
         "triangle; rays: "
         "Mrays/s.\n" +
         (results.front().over == "bytes"       ? "bytes: percent of embree's that may be taken.\n"
          : results.front().over == "tolerance" ? "tolerance: 4 is 1e-4 of the diagonal.\n"
                                                : "");
}

}  // namespace stbvh::harness
