#include "harness/structures/memory_estimate.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <string>
#include <string_view>

#include "harness/files/input_file.h"
#include "harness/structures/lbvh.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness {
namespace {

// Bytes for each primitive segment, rounded up from what seven built-in scenes take (57 to 73 final with
// indexed leaves, 2.07 times that with the vertices in the leaves, and 20 to 80 more while building);
// `stbvh-ab bench` prints what they are now.
constexpr double kFinalBytes = 70;
constexpr double kFinalBytesWithVertices = 140;
constexpr double kBuildBytes = 60;
constexpr double kStbvhBuildBytes = 130;  // temporal splits make references anew: most on barbarian-rotate
// Of ours, for all of a triangle's segments but the first ones: in connected meshes a leaf grows by 12 bytes
// for each of up to eight triangles (17 on barbarian-rotate from 33 to 129 steps, with the build).
constexpr std::size_t kFirstSegments = 16;
constexpr double kStbvhFurtherBytes = 40;
// Of the methods of the gallery, of which most split time less often, and some hold a leaf for each segment.
constexpr double kGalleryBytes = 400;

std::size_t lbvh_segments(const Scene& scene, std::size_t& largest_window) {
  const TimeWindows windows(scene);
  std::size_t total = 0;
  largest_window = 0;
  for (std::size_t w = 0; w < windows.count(); ++w) {
    std::size_t in_window = 0;
    for (const MeshSegment& s : windows.segments(w)) in_window += scene.meshes[s.mesh].triangle_count();
    total += in_window;
    largest_window = std::max(largest_window, in_window);
  }
  for (const Mesh& mesh : scene.meshes) total += mesh.is_static() ? mesh.triangle_count() : 0;
  return total;
}

double further_segments(const Scene& scene) {
  double count = 0;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.segment_count() > kFirstSegments)
      count += static_cast<double>(mesh.triangle_count() * (mesh.segment_count() - kFirstSegments));
  }
  return count;
}

}  // namespace

std::size_t estimate_peak_bytes(std::string_view name, const Scene& scene) {
  const double final_bytes = name.ends_with("-4v") ? kFinalBytesWithVertices : kFinalBytes;
  double segments = static_cast<double>(scene.primitive_segment_count());
  double in_work = segments;
  if (name.starts_with("lbvh")) {
    std::size_t largest_window = 0;
    segments = static_cast<double>(lbvh_segments(scene, largest_window));
    in_work = static_cast<double>(largest_window);
  }
  if (is_in_gallery(name)) return static_cast<std::size_t>(kGalleryBytes * segments);
  if (name.starts_with("stbvh")) {
    const double further = further_segments(scene);
    return static_cast<std::size_t>((final_bytes + kStbvhBuildBytes) * (segments - further) +
                                    kStbvhFurtherBytes * further);
  }
  return static_cast<std::size_t>(final_bytes * segments + kBuildBytes * in_work);
}

std::size_t available_memory_bytes() {
  constexpr std::string_view kKey = "\nMemAvailable:";
  const std::string text = read_proc_file("/proc/meminfo");
  const std::size_t at = text.find(kKey);
  if (at == std::string::npos) return std::numeric_limits<std::size_t>::max();
  return std::strtoul(text.c_str() + at + kKey.size(), nullptr, 10) * 1024;
}

}  // namespace stbvh::harness
