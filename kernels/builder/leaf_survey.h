/// A sample of the leaves that a tree would have, with all temporal splits that each could have: what a tree
/// takes and costs at any price of memory, before there is one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/build_context.h"
#include "builder/byte_price.h"
#include "builder/reference_set.h"

namespace stbvh {

class LeafSurvey {
 public:
  /// Of the references of a whole scene, those of one mesh next to each other.
  LeafSurvey(const BuildContext& context, const ReferenceSet& all);

  /// That the survey itself takes.
  std::size_t bytes() const;

  /// Bytes of nodes and leaves of a tree that is built at `price`, about.
  double bytes_at(const BytePrice& price) const;

  /// The price of memory where it is not limited: a hundredth more bytes must save as many hundredths of what
  /// rays have to do in leaves of moving meshes as kElasticity says.
  const BytePrice& usual_price() const { return usual_price_; }
  /// The least price at which a tree takes at most `bytes`, about; not below usual_price().
  BytePrice price_for(double bytes) const;

 private:
  /// A leaf over some time range; `halves` is the place of its first half, or 0.
  struct Piece {
    float expected_area;
    std::uint32_t steps;
    std::uint32_t halves;
  };
  /// Leaves of one mesh over the whole time, `roots` of them, and all their pieces.
  struct Group {
    std::vector<Piece> pieces;
    std::size_t roots;
    bool moves;
    bool is_long;            ///< its motion: kLongMotion
    double leaves_for_each;  ///< that is in the sample
  };
  struct Totals {
    double area = 0;
    double bytes = 0;
  };

  static void survey(const BuildContext& context, std::span<const Reference> references,
                     const ClosedTimeRange& range, std::span<const std::uint32_t> places, Group& group);
  void add_sample(const BuildContext& context, const ReferenceSet& all, bool moving);
  void add_totals(const Group& group, const BytePrice& price, Totals& totals) const;
  bool is_split(const Group& group, const Piece& piece, const BytePrice& price) const;
  /// Adds the parts that `levels` halvings make; returns how many there are.
  std::size_t add_parts(const Group& group, const Piece& piece, int levels, const BytePrice& price,
                        SplitCosts& costs) const;
  void add(const Group& group, const Piece& piece, const BytePrice& price, Totals& totals) const;
  /// The least price for which `is_enough`, which holds from some price on.
  template <typename IsEnough>
  BytePrice least_price(bool may_index, const IsEnough& is_enough) const;

  BytePrice find_usual_price() const;

  std::vector<Group> groups_;
  float largest_area_ = 0;
  BytePrice usual_price_;
};

}  // namespace stbvh
