#include "builder/leaf_survey.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "builder/motion_bounds.h"

namespace stbvh {

namespace {

constexpr double kSample = 1024;            ///< leaves of moving meshes, and of others, at most
constexpr double kSampledSegments = 65536;  ///< of all leaves of the sample, about
constexpr int kPriceBits = 40;              ///< prices from 2^-40 of the largest area on

/// A run of references of one mesh.
std::size_t run_end(std::span<const Reference> references, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < references.size() && references[end].mesh == references[begin].mesh) ++end;
  return end;
}

}  // namespace

LeafSurvey::LeafSurvey(const BuildContext& context, const ReferenceSet& all) {
  for (const bool moving : {false, true}) add_sample(context, all, moving);
  for (const Group& group : groups_) {
    for (const Piece& piece : group.pieces) largest_area_ = std::max(largest_area_, piece.expected_area);
  }
  usual_price_ = find_usual_price();
}

void LeafSurvey::add_sample(const BuildContext& context, const ReferenceSet& all, bool moving) {
  const auto is_meant = [&](const Reference& r) { return context.meshes[r.mesh].is_static() != moving; };
  double leaves = 0, segments = 0;
  for (const Reference& reference : all.references) {
    if (!is_meant(reference)) continue;
    ++leaves;
    segments += static_cast<double>(context.meshes[reference.mesh].segments());
  }
  const auto stride =
      static_cast<std::size_t>(std::ceil(std::max({1.0, leaves / kSample, segments / kSampledSegments})));
  std::vector<Reference> sample;
  std::size_t next = 0;
  for (const Reference& reference : all.references) {
    if (is_meant(reference) && next++ % stride == 0) sample.push_back(reference);
  }
  std::vector<std::span<const Reference>> runs;
  for (std::size_t begin = 0, end; begin < sample.size(); begin = end) {
    end = run_end(sample, begin);
    runs.push_back(std::span(sample).subspan(begin, end - begin));
  }
  const std::size_t first = groups_.size();
  groups_.resize(first + runs.size());
  tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t i) {
    Group& group = groups_[first + i];
    group = {std::vector<Piece>(runs[i].size()), runs[i].size(), moving,
             context.meshes[runs[i].front().mesh].view().steps.size() > kLongMotion,
             static_cast<double>(stride)};
    std::vector<std::uint32_t> places(group.roots);
    for (std::uint32_t place = 0; place < places.size(); ++place) places[place] = place;
    survey(context, runs[i], all.range, places, group);
  });
}

void LeafSurvey::survey(const BuildContext& context, std::span<const Reference> references,
                        const ClosedTimeRange& range, std::span<const std::uint32_t> places, Group& group) {
  const std::uint32_t number = references.front().mesh;
  const BuildMesh& mesh = context.meshes[number];
  const MotionSamples samples(mesh, range);
  const std::span<const Meshlet> meshlets = context.meshlets[number].meshlets();
  for (std::size_t i = 0; i < references.size(); ++i) {
    Piece& piece = group.pieces[places[i]];
    piece = {0.0f, static_cast<std::uint32_t>(mesh.steps_in(range)), 0};
    if (samples.empty()) continue;
    const Meshlet& meshlet = meshlets[references[i].meshlet];
    piece.expected_area = expected_area(motion_bounds(mesh, samples, meshlet.used_vertices()), range);
  }
  const std::optional<float> boundary = mesh.central_boundary(range);
  if (samples.empty() || !boundary) return;
  const auto [first, second] = halves_at(range, *boundary);
  std::vector<std::uint32_t> halves(references.size());
  for (std::size_t i = 0; i < references.size(); ++i) {
    halves[i] = static_cast<std::uint32_t>(group.pieces.size());
    group.pieces[places[i]].halves = halves[i];
    group.pieces.resize(group.pieces.size() + 2);
  }
  survey(context, references, first, halves, group);
  for (std::uint32_t& half : halves) ++half;
  survey(context, references, second, halves, group);
}

std::size_t LeafSurvey::add_parts(const Group& group, const Piece& piece, int levels, const BytePrice& price,
                                  SplitCosts& costs) const {
  if (levels == 0 || piece.halves == 0) {
    costs.add_part(price, piece.expected_area, piece.steps);
    return 1;
  }
  const Piece* const halves = &group.pieces[piece.halves];
  return add_parts(group, halves[0], levels - 1, price, costs) +
         add_parts(group, halves[1], levels - 1, price, costs);
}

bool LeafSurvey::is_split(const Group& group, const Piece& piece, const BytePrice& price) const {
  std::size_t before = 1;
  for (int levels = 1;; ++levels) {
    SplitCosts costs{piece.expected_area, price.of_leaf(piece.expected_area, piece.steps)};
    const std::size_t parts = add_parts(group, piece, levels, price, costs);
    if (parts == before) return false;
    before = parts;
    costs.more_leaves = parts - 1;
    if (costs.is_worth_it(price)) return true;
    if (!group.is_long) return false;
  }
}

void LeafSurvey::add(const Group& group, const Piece& piece, const BytePrice& price, Totals& totals) const {
  if (piece.halves != 0 && is_split(group, piece, price)) {
    const Piece* const halves = &group.pieces[piece.halves];
    for (int half = 0; half < 2; ++half) add(group, halves[half], price, totals);
    return;
  }
  if (piece.steps == 0) return;  // not alive then
  const bool indexed = price.indexes(piece.expected_area, piece.steps);
  totals.area += group.leaves_for_each * piece.expected_area * (indexed ? kIndexedLeafCost : kLeafCost);
  const std::size_t leaf_bytes = indexed ? kIndexedLeafBytes : inline_leaf_bytes(piece.steps);
  const std::size_t node_bytes = group.moves ? kNodeShareBytes : kStaticNodeShareBytes;
  totals.bytes += group.leaves_for_each * static_cast<double>(leaf_bytes + node_bytes);
}

std::size_t LeafSurvey::bytes() const {
  std::size_t bytes = groups_.size() * sizeof(Group);
  for (const Group& group : groups_) bytes += group.pieces.capacity() * sizeof(Piece);
  return bytes;
}

void LeafSurvey::add_totals(const Group& group, const BytePrice& price, Totals& totals) const {
  for (std::size_t i = 0; i < group.roots; ++i) add(group, group.pieces[i], price, totals);
}

double LeafSurvey::bytes_at(const BytePrice& price) const {
  Totals totals;
  for (const Group& group : groups_) add_totals(group, price, totals);
  return totals.bytes;
}

template <typename IsEnough>
BytePrice LeafSurvey::least_price(bool may_index, const IsEnough& is_enough) const {
  float low = -kPriceBits, high = 0.0f;
  const auto price_at = [&](float bits) { return BytePrice{largest_area_ * std::exp2(bits), may_index}; };
  for (int i = 0; i < 20; ++i) {
    const float middle = 0.5f * (low + high);
    (is_enough(price_at(middle)) ? high : low) = middle;
  }
  return price_at(high);
}

BytePrice LeafSurvey::find_usual_price() const {
  return least_price(false, [&](const BytePrice& price) {
    Totals totals;
    for (const Group& group : groups_) {
      if (group.moves) add_totals(group, price, totals);
    }
    return price.area_per_byte * totals.bytes >= kElasticity * totals.area;
  });
}

BytePrice LeafSurvey::price_for(double bytes) const {
  BytePrice price = least_price(true, [&](const BytePrice& p) { return bytes_at(p) <= bytes; });
  price.area_per_byte = std::max(price.area_per_byte, usual_price_.area_per_byte);
  return price;
}

}  // namespace stbvh
