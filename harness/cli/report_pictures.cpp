#include "harness/cli/report_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "harness/images/exr_file.h"
#include "harness/images/heat_map.h"
#include "harness/images/png_file.h"
#include "harness/images/tone_map.h"

namespace stbvh::harness {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kReference = "stbvh-direct";  // exact: the oracle finds nothing wrong with it

/// A number that `render` left in the file.
template <class Number>
Number metadata(const LayeredImage& image, const fs::path& file, std::string_view name) {
  for (const auto& [key, value] : image.metadata) {
    Number number{};
    if (key == name && std::from_chars(value.data(), value.data() + value.size(), number).ec == std::errc())
      return number;
  }
  throw ImageFileError(
      fmt::format("\"{}\" does not say its {}: render did not write it.", file.string(), name));
}

/// How often camera rays met something; none where the structure did not count.
std::optional<HeatMapResult> write_counts(const LayeredImage& image, const char* channel,
                                          const fs::path& folder, const std::string& name) {
  const std::vector<float>* counts = image.find(channel);
  if (counts == nullptr) return std::nullopt;
  double total = 0;
  for (float count : *counts) total += static_cast<double>(count);
  const double largest = static_cast<double>(*std::max_element(counts->begin(), counts->end()));
  if (!(largest > 0)) return std::nullopt;
  write_png(heat_map(*counts, image.width, image.height, largest), folder / (name + ".png"));
  return HeatMapResult{name + ".png", total / static_cast<double>(counts->size()), largest};
}

RenderResult show(const RenderFile& file, const LayeredImage& image, const fs::path& folder) {
  const std::string name = fmt::format("{}-{}", file.scene, file.structure);
  RenderResult result{.scene = file.scene,
                      .structure = file.structure,
                      .width = image.width,
                      .height = image.height,
                      .samples_per_pixel = metadata<std::size_t>(image, file.path, "spp"),
                      .seed = metadata<std::uint64_t>(image, file.path, "seed"),
                      .seconds = metadata<double>(image, file.path, "seconds"),
                      .mrays_per_s = metadata<double>(image, file.path, "mrays_per_s"),
                      .picture = write_picture(image, folder, name),
                      .reference = "",
                      .difference_picture = ""};
  result.nodes = write_counts(image, "nodes.N", folder, name + "-nodes");
  result.triangles = write_counts(image, "triangles.N", folder, name + "-triangles");
  return result;
}

}  // namespace

std::string write_picture(const LayeredImage& image, const fs::path& folder, const std::string& name) {
  write_png(tone_mapped(image), folder / (name + ".png"));
  return name + ".png";
}

std::string write_difference(const Comparison& found, const fs::path& folder, const std::string& name) {
  write_png(heat_map(found.flip_map, found.width, found.height, 1), folder / (name + ".png"));
  return name + ".png";
}

std::vector<RenderResult> show_renderings(const std::vector<RenderFile>& files, const fs::path& folder) {
  const auto exact =
      std::find_if(files.begin(), files.end(), [](const RenderFile& f) { return f.structure == kReference; });
  const RenderFile& reference = exact != files.end() ? *exact : files.front();
  const LayeredImage reference_image = read_exr(reference.path);
  std::vector<RenderResult> results;
  for (const RenderFile& file : files) {
    const LayeredImage image = read_exr(file.path);
    RenderResult& result = results.emplace_back(show(file, image, folder));
    if (&file == &reference) continue;
    result.reference = reference.structure;
    result.found = compare(image, reference_image);
    if (result.found.differing > 0) {
      result.difference_picture =
          write_difference(result.found, folder, fmt::format("{}-{}-difference", file.scene, file.structure));
    }
  }
  return results;
}

}  // namespace stbvh::harness
