/// A picture against a reference.
#include "harness/images/compare.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "harness/cli/commands.h"
#include "harness/images/exr_file.h"
#include "harness/images/flip.h"
#include "harness/images/heat_map.h"
#include "harness/images/png_file.h"
#include "harness/program/scene_source.h"
#include "harness/program/session.h"
#include "harness/report/records.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

struct CompareOptions : RecordOptions {
  std::string picture, reference;
  std::string difference_png;  ///< empty: none
};

void add_options(CLI::App& app, CompareOptions& o) {
  app.add_option("picture", o.picture, "OpenEXR file with R, G and B")->required();
  app.add_option("reference", o.reference, "OpenEXR file of the same size")->required();
  app.add_option("--png", o.difference_png, "File for a picture of the differences (FLIP), with its scale");
  add_json_option(app, o, "File for the record");
}

std::string describe(const Comparison& c) {
  std::string text = fmt::format("pixels        {} x {}, {} differ, {} not finite\n", c.width, c.height,
                                 c.differing, c.not_finite);
  if (c.only_in_picture + c.only_in_reference > 0) {
    text += fmt::format("not compared  {} of the picture, {} of the reference: only one has pixels there\n",
                        c.only_in_picture, c.only_in_reference);
    text += fmt::format("compared      from ({}, {}) on\n", c.left, c.top);
  }
  text += fmt::format(
      "RMSE          {:.6g}\n"
      "relative MSE  {:.6g}\n"
      "FLIP          {:.6g} mean, {:.6g} largest (0 to 1; {:.0f} pixels per degree)\n",
      c.rmse, c.relative_mse, c.flip_mean, c.flip_max, kFlipPixelsPerDegree);
  if (!c.worst.empty()) text += "worst pixels  x, y from the upper left: R G B, and of the reference\n";
  for (const PixelDifference& d : c.worst) {
    text +=
        fmt::format("  {:4}, {:4}  {:.6g} {:.6g} {:.6g}  against  {:.6g} {:.6g} {:.6g}\n", d.x, d.y,
                    d.picture[0], d.picture[1], d.picture[2], d.reference[0], d.reference[1], d.reference[2]);
  }
  return text;
}

void run_compare(const CompareOptions& options) {
  if (!options.difference_png.empty()) check_writable(options.difference_png);
  if (options.json) check_writable(*options.json);
  const Comparison found = compare(read_exr(options.picture), read_exr(options.reference));
  for (const std::string& warning : found.warnings) print_warning(warning);
  fmt::print("{}", describe(found));
  if (!options.difference_png.empty()) {
    write_png(heat_map(found.flip_map, found.width, found.height, 1), options.difference_png);
    fmt::print("{}: FLIP, from 0 (black) to 1 (pale yellow){}\n", options.difference_png,
               found.not_finite > 0 ? "; green: not finite" : "");
  }
  Report report;
  report.compares.push_back({options.picture, options.reference, found});
  write_records(options, report);
}

}  // namespace

Work compare_command(CLI::App& app) {
  return make_work(app, run_compare);
}

}  // namespace stbvh::harness
