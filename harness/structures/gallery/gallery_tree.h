/// A structure of the gallery: a tree in one block of memory, in the kernels' own nodes or in those of a
/// method, answered on the instruction set that the kernels choose.
#pragma once

#include <functional>
#include <memory>

#include "block.h"
#include "builder/build_context.h"
#include "harness/structures/gallery/gallery_view.h"
#include "harness/structures/gallery/mesh_records.h"
#include "harness/structures/gallery/one_by_one.h"
#include "harness/structures/gallery/top_down.h"
#include "harness/structures/structure_under_test.h"

namespace stbvh::harness::gallery {

/// A child of a node, as rays of one time meet it.
struct OutlinedChild {
  Link link;
  Outline corners;
};

/// The children of a node that are alive at `time`.
using ChildrenAt = std::vector<OutlinedChild> (*)(const GalleryView& view, Link node, float time);

/// Nodes and leaves that a method has written.
struct WrittenTree {
  Block block;
  Link root;
  GalleryKernels kernels;
  ChildrenAt children_at;
  std::shared_ptr<const void> method;  ///< GalleryView::method
  std::size_t method_bytes = 0;        ///< that it takes
};

/// The entry points for the kernels' own nodes.
GalleryKernels own_kernels();

/// Writes the tree below `root` in the kernels' own nodes.
WrittenTree write_own_nodes(BuildContext& context, BinaryNode& root);

/// The methods of others take steps as they are given: to leave some out is one of our ideas.
inline BuildSettings as_given() {
  return {.tolerance = kKeepAllSteps};
}

class GalleryTree final : public OneByOne<GalleryTree> {
 public:
  /// How a method makes its builder, and how it writes what that has built.
  using MakeBuilder = std::function<std::unique_ptr<TopDown>(BuildContext&)>;
  using Write = std::function<WrittenTree(BuildContext&, BinaryNode& root)>;
  /// What is done before triangles are split: by default they are grouped into meshlets.
  using Prepare = std::function<void(BuildContext&)>;

  struct Method {
    BuildSettings settings = as_given();
    Prepare prepare;
    MakeBuilder make_builder;
    Write write = write_own_nodes;
  };

  /// Throws BuildCancelled, std::bad_alloc.
  GalleryTree(const Scene& scene, const Method& method, unsigned threads, const BuildProgress& progress);

  const BuildRecord& build_record() const override { return record_; }
  bool intersect_one(const Ray& ray, Hit& hit) const override;
  bool occluded_one(const Ray& ray) const override;
  bool has_counters() const override { return true; }
  bool intersect_one_counted(const Ray& ray, Hit& hit, TraversalCounters& counters) const override;
  std::vector<Outline> outlines_at(float time, std::size_t level) const override;

 private:
  void build(const Scene& scene, const Method& method, const BuildProgress& progress);

  MeshRecords records_;
  std::unique_ptr<WrittenTree> tree_;  ///< null: there is nothing
  GalleryView view_;
  BuildRecord record_;
};

/// The structure of a method whose builder is `Builder`, in the kernels' own nodes.
template <typename Builder>
std::unique_ptr<StructureUnderTest> build_in_own_nodes(const Scene& scene, unsigned threads,
                                                       const BuildProgress& progress) {
  GalleryTree::Method method;
  method.make_builder = [](BuildContext& context) { return std::make_unique<Builder>(context); };
  return std::make_unique<GalleryTree>(scene, method, threads, progress);
}

}  // namespace stbvh::harness::gallery
