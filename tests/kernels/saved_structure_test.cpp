/// Structures in files: the same answers, and no file that is not one is taken.
#include "stbvh/saved_structure.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "saved/file_format.h"
#include "stbvh/structure.h"
#include "test_meshes.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace stbvh {
namespace {

using test::Random;
using test::TestMesh;
using Bytes = std::vector<std::byte>;

std::vector<MeshView> views(std::vector<TestMesh>& meshes) {
  std::vector<MeshView> v;
  for (TestMesh& mesh : meshes) v.push_back(mesh.view());
  return v;
}

Bytes saved(const Structure& structure, std::span<const MeshView> meshes, const SaveOptions& options = {}) {
  Bytes file;
  save_structure(structure, meshes, options, [&](std::span<const std::byte> piece) {
    file.insert(file.end(), piece.begin(), piece.end());
  });
  return file;
}

std::vector<TestMesh> scene() {
  std::vector<TestMesh> meshes{test::sphere(14, 9), test::sphere(6, 1, test::tumble, {3, 0, 0}),
                               test::soup(60, 5, 3), test::timed(test::sphere(5, 3), {0.25f, 0.5f}),
                               test::at_times(test::soup(30, 6, 9), test::uneven_times(6, 4))};
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    meshes[i].geom_id = static_cast<std::uint32_t>(10 + i);
    meshes[i].mask = i == 2 ? 2u : ~0u;
  }
  return meshes;
}

Ray ray_through(Random& random) {
  const auto coordinate = [&] { return 8 * random.unit() - 4; };
  const Vec3f from{coordinate(), coordinate(), coordinate()};
  const Vec3f to{0.5f * coordinate(), 0.5f * coordinate(), 0.5f * coordinate()};
  Ray ray{from,
          0.0f,
          {to.x - from.x, to.y - from.y, to.z - from.z},
          random.unit(),
          std::numeric_limits<float>::infinity()};
  if (random.unit() < 0.2f) ray.mask = 1;
  return ray;
}

void expect_same(const Structure& a, const Structure& b, int rays = 2000) {
  Random random(7);
  int hits = 0;
  for (int i = 0; i < rays; ++i) {
    const Ray ray = ray_through(random);
    Hit hit_a, hit_b;
    const bool hit = a.intersect(ray, hit_a);
    ASSERT_EQ(hit, b.intersect(ray, hit_b));
    EXPECT_EQ(a.occluded(ray), b.occluded(ray));
    if (!hit) continue;
    ++hits;
    EXPECT_EQ(std::bit_cast<std::uint32_t>(hit_a.t), std::bit_cast<std::uint32_t>(hit_b.t));
    EXPECT_EQ(hit_a.prim_id, hit_b.prim_id);
    EXPECT_EQ(hit_a.geom_id, hit_b.geom_id);
    EXPECT_EQ(hit_a.mesh, hit_b.mesh);
    EXPECT_EQ(hit_a.u, hit_b.u);
  }
  EXPECT_GT(hits, rays / 10);
}

std::string problem_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const BadStructureFile& error) {
    return error.what();
  }
  return "";
}

std::string problem_of(const Bytes& file) {
  return problem_of([&] { SavedStructure(file).structure(); });
}

/// With checksums that are right, as somebody would make them who wants to do harm.
Bytes resealed(Bytes file) {
  FileHeader header;
  std::memcpy(static_cast<void*>(&header), file.data(), sizeof header);
  const auto hash = [](const std::byte* data, std::size_t bytes) {
    const XXH128_hash_t h = XXH3_128bits(data, bytes);
    return ContentHash{h.low64, h.high64};
  };
  const bool has_hashes = header.hashes.offset >= kHeaderBytes && header.hashes.offset <= file.size() &&
                          header.hashes.bytes <= file.size() - header.hashes.offset;
  if (has_hashes) {
    const std::size_t body = header.hashes.offset - kHeaderBytes;
    for (std::size_t i = 0; i * kHashedBytes < body && (i + 1) * sizeof(ContentHash) <= header.hashes.bytes;
         ++i) {
      const ContentHash h = hash(file.data() + kHeaderBytes + i * kHashedBytes,
                                 std::min(kHashedBytes, body - i * kHashedBytes));
      std::memcpy(file.data() + header.hashes.offset + i * sizeof h, &h, sizeof h);
    }
    header.hash_of_hashes = hash(file.data() + header.hashes.offset, header.hashes.bytes);
  }
  header.hash_of_header = {};
  header.hash_of_header = hash(reinterpret_cast<const std::byte*>(&header), sizeof header);
  std::memcpy(file.data(), &header, sizeof header);
  return file;
}

TEST(SavedStructure, AnswersAsTheOneThatWasSaved) {
  for (const float share : {1.0f, 0.5f}) {  // half: with indexed leaves
    for (const Precision precision : {Precision::kWatertight, Precision::kFast}) {
      std::vector<TestMesh> meshes = scene();
      BuildSettings settings;
      settings.precision = precision;
      const auto whole = Structure::build(views(meshes), settings);
      if (share < 1)
        settings.max_bytes =
            static_cast<std::size_t>(share * static_cast<float>(whole->statistics().structure_bytes));
      const auto structure = Structure::build(views(meshes), settings);
      EXPECT_EQ(structure->statistics().indexed_leaves > 0, share < 1);
      const std::string text = "what the caller wants to find";
      const Bytes file = saved(*structure, views(meshes),
                               {.with_buffers = true, .user_data = std::as_bytes(std::span(text))});
      const SavedStructure loaded(file);
      ASSERT_TRUE(loaded.has_buffers());
      EXPECT_EQ(
          std::string(reinterpret_cast<const char*>(loaded.user_data().data()), loaded.user_data().size()),
          text);
      ASSERT_EQ(loaded.meshes().size(), meshes.size());
      for (std::size_t i = 0; i < meshes.size(); ++i) {
        const MeshView view = loaded.meshes()[i];
        EXPECT_EQ(view.geom_id, meshes[i].geom_id);
        EXPECT_EQ(view.triangle_count, meshes[i].indices.size() / 3);
        ASSERT_EQ(view.steps.size(), meshes[i].positions.size());
        EXPECT_EQ(view.steps.back().position(1).y, meshes[i].positions.back()[1].y);
      }
      const auto again = loaded.structure();
      expect_same(*structure, *again);
      EXPECT_EQ(again->tree_hash(), structure->tree_hash());
      EXPECT_EQ(again->statistics().structure_bytes, structure->statistics().structure_bytes);
      EXPECT_EQ(again->statistics().nodes, structure->statistics().nodes);
      EXPECT_EQ(again->statistics().inline_leaves, structure->statistics().inline_leaves);
      EXPECT_EQ(again->statistics().indexed_leaves, structure->statistics().indexed_leaves);
      EXPECT_EQ(again->statistics().depth, structure->statistics().depth);
      EXPECT_EQ(again->statistics().steps_kept, structure->statistics().steps_kept);
      EXPECT_EQ(again->statistics().triangles, structure->statistics().triangles);
      EXPECT_EQ(
          saved(*again, loaded.meshes(), {.with_buffers = true, .user_data = std::as_bytes(std::span(text))}),
          file);
    }
  }
}

TEST(SavedStructure, OutlivesItsFile) {
  std::vector<TestMesh> meshes = scene();
  const auto structure = Structure::build(views(meshes));
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "outlives.stbvh";
  {
    std::ofstream out(path, std::ios::binary);
    save_structure(*structure, views(meshes), {.with_buffers = false}, [&](std::span<const std::byte> piece) {
      out.write(reinterpret_cast<const char*>(piece.data()), static_cast<std::streamsize>(piece.size()));
    });
  }
  std::unique_ptr<Structure> again;
  {
    const SavedStructure loaded(path);
    EXPECT_FALSE(loaded.has_buffers());
    EXPECT_NE(problem_of([&] { loaded.structure(); }), "");
    again = loaded.structure(views(meshes));
  }
  std::filesystem::remove(path);
  expect_same(*structure, *again);
  EXPECT_THROW(SavedStructure{path}, std::system_error);
  EXPECT_EQ(problem_of([] { SavedStructure{std::filesystem::path("/")}; }), "is not a file");
}

TEST(SavedStructure, IsGivenToTheSameMeshesOnly) {
  std::vector<TestMesh> meshes = scene();
  const auto structure = Structure::build(views(meshes));
  const SavedStructure loaded(saved(*structure, views(meshes), {.with_buffers = false}));
  meshes[2].mask = 1;  // what a tree does not depend on
  meshes[2].geom_id = 77;
  const auto masked = Structure::build(views(meshes));
  expect_same(*masked, *loaded.structure(views(meshes)));
  meshes[2].positions[1][3].x += 0.001f;
  EXPECT_EQ(problem_of([&] { loaded.structure(views(meshes)); }), "is of meshes that differ from these");
  meshes.pop_back();
  EXPECT_EQ(problem_of([&] { loaded.structure(views(meshes)); }), "is of another number of meshes");
}

TEST(SavedStructure, IsChangedAsAnyOther) {
  std::vector<TestMesh> meshes = scene();
  const Bytes file = saved(*Structure::build(views(meshes)), views(meshes));
  const SavedStructure loaded(file);
  const auto structure = loaded.structure();
  for (auto& step : meshes[0].positions) {
    for (Vec3f& p : step) p.z += 0.01f;
  }
  std::vector<MeshUpdate> updates;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    updates.push_back({i, i == 0 ? MeshChange::kPositions : MeshChange::kNothing});
  meshes.push_back(test::soup(20, 2, 99));
  updates.push_back({});
  ASSERT_TRUE(structure->update(views(meshes), updates));
  const auto anew = Structure::build(views(meshes));
  expect_same(*anew, *structure);
  // What was changed is put in order when it is saved; the file is as it was.
  expect_same(*anew, *SavedStructure(saved(*structure, views(meshes))).structure());
  expect_same(*Structure::build(loaded.meshes()), *SavedStructure(file).structure());
}

TEST(SavedStructure, MayBeEmpty) {
  const auto structure = Structure::build({});
  const SavedStructure loaded(saved(*structure, {}));
  const auto again = loaded.structure();
  Hit hit;
  EXPECT_FALSE(again->intersect({{0, 0, 0}, 0, {0, 0, 1}, 0.5f, 100}, hit));
}

TEST(SavedStructure, ThatIsDamagedIsRefused) {
  std::vector<TestMesh> meshes = scene();
  const Bytes file = saved(*Structure::build(views(meshes)), views(meshes));
  ASSERT_EQ(problem_of(file), "");
  EXPECT_EQ(problem_of(Bytes()), "is truncated");
  EXPECT_EQ(problem_of(Bytes(file.begin(), file.begin() + 4000)), "is truncated");
  EXPECT_EQ(problem_of(Bytes(file.begin(), file.end() - 1)), "is truncated");
  Bytes longer = file;
  longer.resize(longer.size() + 4096);
  EXPECT_EQ(problem_of(longer), "has another length than it says");
  Bytes foreign = file;
  foreign[1] = std::byte{'X'};
  EXPECT_EQ(problem_of(foreign), "is not a structure of STBVH");
  Bytes newer = file;
  newer[8] = std::byte{2};
  EXPECT_EQ(problem_of(newer), "is of another version of STBVH");
  Random random(3);
  for (int i = 0; i < 300; ++i) {  // one bit anywhere
    Bytes damaged = file;
    const auto place = static_cast<std::size_t>(random.unit() * 0.9999f * static_cast<float>(file.size()));
    if (place >= sizeof(FileHeader) && place < kHeaderBytes) continue;  // nothing stands there
    damaged[place] ^= std::byte{1} << (i % 8);
    const bool in_padding = [&] {
      FileHeader header;
      std::memcpy(static_cast<void*>(&header), file.data(), sizeof header);
      return place >= header.hashes.offset + header.hashes.bytes;
    }();
    EXPECT_EQ(problem_of(damaged).empty(), in_padding) << place;
  }
}

/// Files whose checksums are right, and whose contents are not: each is refused, or is a tree that can be
/// asked.
TEST(SavedStructure, ThatMeansHarmIsRefusedOrHarmless) {
  std::vector<TestMesh> meshes = scene();
  BuildSettings settings;
  settings.max_bytes = Structure::build(views(meshes))->statistics().structure_bytes / 2;
  const Bytes file = saved(*Structure::build(views(meshes), settings), views(meshes));
  FileHeader header;
  std::memcpy(static_cast<void*>(&header), file.data(), sizeof header);
  ASSERT_EQ(problem_of(resealed(file)), "");
  Random random(5);
  std::size_t refused = 0;
  const int runs = test::count(4000);
  for (int i = 0; i < runs; ++i) {
    Bytes harmful = file;
    const FileSection where = i % 3 == 0   ? FileSection{16, sizeof(FileHeader) - 48}
                              : i % 3 == 1 ? header.tables
                                           : header.block;
    for (int k = 0; k < 1 + i % 3; ++k) {
      const std::size_t place =
          where.offset + static_cast<std::size_t>(random.unit() * 0.9999f * static_cast<float>(where.bytes));
      harmful[place] = std::byte{static_cast<unsigned char>(random.unit() * 255.99f)};
    }
    harmful = resealed(std::move(harmful));
    try {
      const SavedStructure loaded(harmful);
      const auto structure = loaded.structure();
      Random rays(9);
      for (int k = 0; k < 20; ++k) {
        Hit hit;
        const Ray ray = ray_through(rays);
        structure->intersect(ray, hit);
        structure->occluded(ray);
      }
    } catch (const BadStructureFile&) {
      ++refused;
    } catch (const InvalidMesh&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, static_cast<std::size_t>(runs / 4));
  EXPECT_LT(refused, static_cast<std::size_t>(runs));
}

FileHeader header_of(const Bytes& file) {
  FileHeader header;
  std::memcpy(static_cast<void*>(&header), file.data(), sizeof header);
  return header;
}

/// Calls `change` with each link below `link`, and the bytes that it leads to.
void for_each_link(Bytes& file, Link link, const std::function<void(Link, std::byte*)>& change) {
  std::byte* const data = file.data() + header_of(file).block.offset + unit_of(link) * kUnitBytes;
  const bool is_leaf = kind_of(link) == LinkKind::kLeaf;
  const NodeSlots node = is_leaf ? NodeSlots{} : read_node(kind_of(link), data, {0, 1});
  change(link, data);
  for (const NodeSlot& child : node.used()) for_each_link(file, child.link, change);
}

template <typename Node>
void change_nodes(Bytes& file, LinkKind kind, const std::function<void(Node&)>& change) {
  std::size_t count = 0;
  for_each_link(file, header_of(file).root.link, [&](Link link, std::byte* data) {
    if (kind_of(link) != kind) return;
    Node node;
    std::memcpy(&node, data, sizeof node);
    change(node);
    std::memcpy(data, &node, sizeof node);
    ++count;
  });
  ASSERT_GT(count, 0u);
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// What rays would compute there is not a number, and comparisons of such let them in.
TEST(SavedStructure, WithNumbersThatAreNoneWhereNoChildIsIsRefused) {
  std::vector<TestMesh> meshes{test::sphere(3, 2)};
  const Bytes file = saved(*Structure::build(views(meshes)), views(meshes));
  const auto is_free = [](const LinearNode& node, std::size_t i) {
    return !(node.planes[0][i] <= node.planes[3][i]);
  };
  const std::function<void(LinearNode&)> changes[] = {[](LinearNode& node) { node.time_begin = kNan; },
                                                      [&](LinearNode& node) {
                                                        for (std::size_t i = 0; i < kWidth; ++i) {
                                                          if (is_free(node, i)) node.slopes[2][i] = kNan;
                                                        }
                                                      },
                                                      [&](LinearNode& node) {
                                                        for (std::size_t i = 0; i < kWidth; ++i) {
                                                          if (is_free(node, i)) node.children[i] = 7;
                                                        }
                                                      },
                                                      [](LinearNode& node) { node.slopes[1][0] = kNan; }};
  for (const auto& change : changes) {
    Bytes harmful = file;
    change_nodes<LinearNode>(harmful, LinkKind::kLinearNode, change);
    EXPECT_EQ(problem_of(resealed(std::move(harmful))), "has a tree that is not one");
  }
}

TEST(SavedStructure, WithASegmentThatIsNotThereIsRefused) {
  std::vector<TestMesh> meshes{test::at_times(test::soup(60, 6, 9), test::uneven_times(6, 4))};
  BuildSettings settings;
  settings.max_bytes = Structure::build(views(meshes))->statistics().structure_bytes / 2;
  Bytes file = saved(*Structure::build(views(meshes), settings), views(meshes));
  std::size_t changed = 0;
  for_each_link(file, header_of(file).root.link, [&](Link link, std::byte* data) {
    LeafHeader leaf;
    if (kind_of(link) != LinkKind::kLeaf) return;
    std::memcpy(&leaf, data, sizeof leaf);
    if (leaf.indexed == 0) return;
    leaf.first_segment = 60000;
    std::memcpy(data, &leaf, sizeof leaf);
    ++changed;
  });
  ASSERT_GT(changed, 0u);
  EXPECT_EQ(problem_of(resealed(std::move(file))), "has a tree that is not one");
}

/// An update finds the leaves of a mesh by its box, and reads its triangles.
TEST(SavedStructure, IsChangedSafelyWhateverItHolds) {
  std::vector<TestMesh> meshes;
  for (int i = 0; i < 8; ++i)
    meshes.push_back(test::sphere(6, 2, test::tumble, {4.0f * static_cast<float>(i), 0, 0}));
  const auto good = static_cast<std::uint32_t>(meshes[0].indices.size() / 3);
  meshes[0].indices.insert(meshes[0].indices.end(), {0x0fffffff, 0x0ffffffe, 0x0ffffffd});
  const Bytes file = saved(*Structure::build(views(meshes)), views(meshes), {.with_buffers = false});
  constexpr std::size_t kMeshBytes = 80, kBounds = 20,
                        kInvalid = kBounds + sizeof(Box3f) + 8;  // in the tables
  const std::size_t record = header_of(file).tables.offset + meshes.size() * kMeshBytes;

  Bytes elsewhere = file;
  const Box3f box{{1e6f, 1e6f, 1e6f}, {1e6f, 1e6f, 1e6f}};
  std::memcpy(elsewhere.data() + record + kBounds, &box, sizeof box);
  const SavedStructure moved(resealed(std::move(elsewhere)));
  EXPECT_EQ(problem_of([&] { moved.structure(views(meshes)); }), "has a tree that is not one");

  Bytes beyond = file;
  const std::uint64_t none = 0;
  std::uint64_t invalid = 0;
  std::memcpy(&invalid, beyond.data() + record + kInvalid, sizeof invalid);
  ASSERT_EQ(invalid, 1u);
  std::memcpy(beyond.data() + record + kInvalid, &none, sizeof none);
  for_each_link(beyond, header_of(beyond).root.link, [&](Link link, std::byte* data) {
    LeafHeader leaf;
    if (kind_of(link) != LinkKind::kLeaf) return;
    std::memcpy(&leaf, data, sizeof leaf);
    if (leaf.mesh == 0) leaf.prim_ids[0] = good;
    std::memcpy(data, &leaf, sizeof leaf);
  });
  const SavedStructure outside(resealed(std::move(beyond)));
  const auto structure = outside.structure(views(meshes));
  for (auto& step : meshes[0].positions) {
    for (Vec3f& p : step) p.x += 0.01f;
  }
  std::vector<MeshUpdate> updates;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    updates.push_back({i, i == 0 ? MeshChange::kPositions : MeshChange::kNothing});
  structure->update(views(meshes), updates);  // reads nothing that is not there, as sanitizers see
}

TEST(SavedStructure, OfMeshesWithoutTrianglesIsThereAgain) {
  std::vector<TestMesh> meshes{TestMesh{{}, {{}}, {}, {}}};
  const auto structure = Structure::build(views(meshes));
  EXPECT_EQ(SavedStructure(saved(*structure, views(meshes))).structure()->statistics().triangles, 0u);
}

}  // namespace
}  // namespace stbvh
