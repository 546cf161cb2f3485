#include "harness/report/json.h"

#include <nlohmann/json.hpp>

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
          {"resident_bytes", r.resident_bytes},
          {"budget_bytes", r.budget_bytes == 0 ? Json() : Json(r.budget_bytes)},
          {"wanted_bytes", r.wanted_bytes == 0 ? Json() : Json(r.wanted_bytes)},
          {"steps", r.steps},
          {"steps_kept", r.steps_kept},
          {"tolerance", r.tolerance},
          {"max_deviation", r.max_deviation}};
}

Json to_record(const SpeedResult& r) {
  Json ratio;  // null
  Json least;
  Json largest;
  if (const std::optional<Spread> spread = r.ratio_to_embree()) {
    ratio = spread->median;
    least = spread->min;
    largest = spread->max;
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
          {"ratios_to_embree", r.ratios_to_embree},
          {"hits", r.hits}};
}

void add_percentiles(const std::string& name, const Percentiles& p, Json& record) {
  record[name + "_p50"] = p.p50;
  record[name + "_p99"] = p.p99;
  record[name + "_max"] = p.max;
}

void add_distance(const DistanceFigures& d, Json& record) {
  add_percentiles("t_error_rel", d.relative, record);
  add_percentiles("t_error_ulps", d.ulps, record);
  add_percentiles("off_plane", d.off_plane, record);
  record["grazing"] = d.grazing;
}

/// Null: nothing was hit.
Json to_figures(const RecordedAnswer& answer) {
  if (!answer.is_hit) return {};
  if (!answer.hit) return Json::object();
  const RecordedAnswer::Hit& hit = *answer.hit;
  return {{"t", hit.t},
          {"mesh", hit.mesh},
          {"primitive", hit.primitive},
          {"face", hit.face.value_or(hit.primitive)}};
}

Json to_figures(const DifferingRay& r) {
  return {{"ray", r.ray},
          {"verdict", r.verdict},
          {"origin", r.origin},
          {"direction", r.direction},
          {"tnear", r.tnear},
          {"tfar", r.tfar},
          {"time", r.time},
          {"reported", to_figures(r.reported)},
          {"exact", to_figures(r.exact)},
          {"edge_distance_ulps", r.edge_distance_ulps}};
}

Json to_record(const ErrorResult& r) {
  Json differences = Json::array();
  for (const DifferingRay& difference : r.differences) differences.push_back(to_figures(difference));
  Json record{{"kind", "error"},
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
              {"differences", std::move(differences)}};
  add_distance(r.distance, record);
  return record;
}

Json count_or_null(std::optional<std::size_t> count) {
  return count ? Json(*count) : Json();
}

Json to_record(const HardResult& r) {
  Json record{{"kind", "hard"},
              {"family", r.family},
              {"structure", r.structure},
              {"traced", r.traced},
              {"oracle_hits", r.oracle_hits},
              {"leaks", count_or_null(r.leaks)},
              {"missed", r.missed},
              {"false_hits", r.false_hits},
              {"wrong_primitive", r.wrong_primitive},
              {"near_misses", r.near_misses},
              {"any_hit_wrong", r.any_hit_wrong},
              {"self_hits", count_or_null(r.self_hits)},
              {"exact_self_hits", count_or_null(r.exact_self_hits)},
              {"ties", r.ties},
              {"within_rounding", r.within_rounding},
              {"near_edge", r.near_edge}};
  add_distance(r.distance, record);
  return record;
}

Json to_record(const ParetoResult& r) {
  const auto rate = [](std::size_t count, std::size_t n) {
    return n > 0 ? Json(static_cast<double>(count) / static_cast<double>(n)) : Json();
  };
  return {{"kind", "pareto"},
          {"structure", r.structure},
          {"ratio_to_embree", r.ratio_to_embree.median},
          {"ratio_to_embree_min", r.ratio_to_embree.min},
          {"ratio_to_embree_max", r.ratio_to_embree.max},
          {"aimed", r.aimed},
          {"leaks", r.leaks},
          {"leak_rate", rate(r.leaks, r.aimed)},
          {"leak_rate_bound_95", rate_bound_95(r.leaks, r.aimed)},
          {"thin", r.thin},
          {"differing", r.differing},
          {"differing_rate", rate(r.differing, r.thin)},
          {"differing_rate_bound_95", rate_bound_95(r.differing, r.thin)},
          {"t_error_rel_p99", r.t_error_rel_p99}};
}

Json to_record(const SummaryResult& r) {
  return {{"kind", "summary"},
          {"structure", r.structure},
          {"reference", r.reference},
          {"measure", r.measure},
          {"rays", r.rays.empty() ? Json() : Json(r.rays)},
          {"threads", r.threads},
          {"scenes", r.scenes},
          {"mean_ratio", r.mean.median},
          {"mean_ratio_min", r.mean.min},
          {"mean_ratio_max", r.mean.max},
          {"worst_scene", r.worst_scene},
          {"worst_ratio", r.worst.median},
          {"worst_ratio_min", r.worst.min},
          {"worst_ratio_max", r.worst.max}};
}

Json to_record(const ScalingResult& r) {
  Json record = to_record(r.build);
  record["kind"] = "scaling";
  record["over"] = r.over;
  record["value"] = r.value;
  for (const SpeedResult& speed : r.speeds) {
    record[speed.rays + "_mrays_per_s"] = speed.mrays_per_s.median;
    record[speed.rays + "_mrays_per_s_min"] = speed.mrays_per_s.min;
    record[speed.rays + "_mrays_per_s_max"] = speed.mrays_per_s.max;
    if (const std::optional<Spread> ratio = speed.ratio_to_embree())
      record[speed.rays + "_ratio_to_embree"] = ratio->median;
  }
  return record;
}

Json to_record(const GalleryResult& r) {
  const auto of_visits = [&](double GalleryResult::Visits::*part) {
    return r.visits ? Json((*r.visits).*part) : Json();
  };
  return {{"kind", "gallery"},
          {"scene", r.scene},
          {"structure", r.structure},
          {"compared_with", r.compared_with},
          {"is_exact", r.is_exact ? 1 : 0},
          {"step_limit", r.steps},
          {"obstacle", r.obstacle.empty() ? Json() : Json(r.obstacle)},
          {"nodes_per_ray", of_visits(&GalleryResult::Visits::nodes)},
          {"leaves_per_ray", of_visits(&GalleryResult::Visits::leaves)},
          {"triangle_tests_per_ray", of_visits(&GalleryResult::Visits::triangle_tests)},
          {"traced", r.traced},
          {"wrong", r.wrong}};
}

Json to_record(const SliceResult& r) {
  return {{"kind", "slice"},
          {"scene", r.scene},
          {"structure", r.structure.empty() ? Json() : Json(r.structure)},
          {"time", r.time},
          {"shapes", r.shapes}};
}

Json to_record(const EditResult& r) {
  Json record = {{"kind", "edit"},
                 {"scene", r.scene},
                 {"structure", r.structure},
                 {"edit", r.edit},
                 {"what", r.what},
                 {"triangles", r.triangles},
                 {"changed_share", r.changed_share},
                 {"threads", r.threads},
                 {"commit_s", r.commit_s},
                 {"rebuild_s", r.rebuild_s},
                 {"rays", r.rays.empty() ? Json() : Json(r.rays)},
                 {"traced", r.traced},
                 {"differing", r.differing}};
  if (r.speed) {
    record["speed_to_rebuilt"] = r.speed->median;
    record["speed_to_rebuilt_min"] = r.speed->min;
    record["speed_to_rebuilt_max"] = r.speed->max;
  }
  return record;
}

Json to_record(const FramesResult& r) {
  return {{"kind", "frames"},
          {"scene", r.scene},
          {"structure", r.structure},
          {"frames", r.frames},
          {"triangles", r.triangles},
          {"threads", r.threads},
          {"build_s", r.build_s},
          {"bytes", r.bytes},
          {"buffer_bytes", r.buffer_bytes},
          {"frame_build_s", r.frame_build_s},
          {"frame_bytes", r.frame_bytes},
          {"mrays_per_s", r.mrays_per_s},
          {"frame_mrays_per_s", r.frame_mrays_per_s},
          {"traced", r.traced},
          {"differing", r.differing},
          {"crossover_rays", r.crossover_rays()}};
}

Json to_figures(const Comparison& c) {
  Json worst = Json::array();
  for (const PixelDifference& d : c.worst) {
    worst.push_back({{"x", d.x}, {"y", d.y}, {"picture", d.picture}, {"reference", d.reference}});
  }
  return {{"width", c.width},
          {"height", c.height},
          {"left", c.left},
          {"top", c.top},
          {"only_in_picture", c.only_in_picture},
          {"only_in_reference", c.only_in_reference},
          {"not_finite", c.not_finite},
          {"differing", c.differing},
          {"rmse", c.rmse},
          {"relative_mse", c.relative_mse},
          {"flip_mean", c.flip_mean},
          {"flip_max", c.flip_max},
          {"worst", std::move(worst)},
          {"warnings", c.warnings}};
}

Json to_record(const CompareResult& r) {
  Json record = {{"kind", "compare"}, {"picture", r.picture}, {"reference", r.reference}};
  record.update(to_figures(r.found));
  return record;
}

Json to_figures(const std::optional<HeatMapResult>& r) {
  if (!r) return {};
  return {{"picture", r->picture}, {"mean", r->mean}, {"largest", r->largest}};
}

Json to_record(const RenderResult& r) {
  Json difference;  // null: this is the reference
  if (!r.reference.empty()) {
    difference = {{"reference", r.reference}, {"picture", r.difference_picture}};
    difference.update(to_figures(r.found));
  }
  return {{"kind", "render"},
          {"scene", r.scene},
          {"structure", r.structure},
          {"width", r.width},
          {"height", r.height},
          {"samples_per_pixel", r.samples_per_pixel},
          {"seed", r.seed},
          {"seconds", r.seconds},
          {"mrays_per_s", r.mrays_per_s},
          {"picture", r.picture},
          {"difference", std::move(difference)},
          {"nodes", to_figures(r.nodes)},
          {"triangles", to_figures(r.triangles)}};
}

Json to_record(const TruthResult& r) {
  Json record = {{"kind", "truth"},
                 {"scene", r.scene},
                 {"structure", r.structure},
                 {"reference_structure", r.reference_structure},
                 {"frozen_times", r.frozen_times},
                 {"samples_per_pixel", r.samples_per_pixel},
                 {"picture", r.picture},
                 {"reference_picture", r.reference_picture},
                 {"difference_picture", r.difference_picture}};
  record.update(to_figures(r.found));
  return record;
}

}  // namespace

std::string to_json(const Report& report, const Machine& machine, const std::string& commit,
                    const std::string& command) {
  Json records = Json::array();
  for (const BuildResult& r : report.builds) records.push_back(to_record(r));
  for (const SpeedResult& r : report.speeds) records.push_back(to_record(r));
  for (const ErrorResult& r : report.errors) records.push_back(to_record(r));
  for (const HardResult& r : report.hards) records.push_back(to_record(r));
  for (const ParetoResult& r : report.paretos) records.push_back(to_record(r));
  for (const SummaryResult& r : report.summaries) records.push_back(to_record(r));
  for (const ScalingResult& r : report.scalings) records.push_back(to_record(r));
  for (const GalleryResult& r : report.galleries) records.push_back(to_record(r));
  for (const SliceResult& r : report.slices) records.push_back(to_record(r));
  for (const EditResult& r : report.edits) records.push_back(to_record(r));
  for (const FramesResult& r : report.frames) records.push_back(to_record(r));
  for (const CompareResult& r : report.compares) records.push_back(to_record(r));
  for (const RenderResult& r : report.renders) records.push_back(to_record(r));
  for (const TruthResult& r : report.truths) records.push_back(to_record(r));
  const Json root = {{"machine",
                      {{"cpu", machine.cpu},
                       {"cores", machine.cores},
                       {"memory_gb", machine.memory_gb},
                       {"instruction_set", machine.instruction_set},
                       {"embree", machine.embree}}},
                     {"commit", commit},
                     {"command", command},
                     {"records", std::move(records)}};
  // Names may hold bytes that are not UTF-8 (a file's name): replaced, not thrown over.
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace stbvh::harness
