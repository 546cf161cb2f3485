/// Scenes to XML and back, and what Embree's own pathtracer makes of them.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <sstream>

#include "harness/scenes/embree_xml/writer.h"
#include "harness/scenes/gltf/gltf.h"
#include "harness/scenes/moving_triangle.h"
#include "harness/scenes/procedural/procedural.h"
#include "harness/structures/structure_under_test.h"
#include "plugin/files/output_file.h"
#include "tests/harness/embree_xml_files.h"
#include "tests/harness/run_stbvh_ab.h"

namespace stbvh::harness {
namespace {

// As Debian names them, of the same major version as the harness.
const std::string kPathtracer = STBVH_EMBREE_MAJOR >= 4 ? "embree_pathtracer" : "pathtracer";
const fs::path kModels =
    STBVH_EMBREE_MAJOR >= 4 ? "/usr/share/doc/embree4/models" : "/usr/share/doc/embree3/models";
constexpr std::size_t kWidth = 160, kHeight = 90;

class EmbreeXmlTools : public EmbreeXmlTest {
 protected:
  static bool has_pathtracer() {
    return std::system(("command -v " + kPathtracer + " > /dev/null").c_str()) == 0;
  }

  fs::path write_xml(const Scene& scene, const std::string& name = "r.xml") {
    const fs::path file = folder / name;
    const EmbreeXml content = to_embree_xml(scene, [&](const std::string& w) { warnings.push_back(w); });
    const std::vector<FileContent> files{{embree_binary_file(file), content.binary}, {file, {content.xml}}};
    write_files(files);
    return file;
  }

  /// |cos| between ray and normal in green, at a time, through the upper left corner of each pixel; black
  /// where nothing is hit. Embree 3's pathtracer shows that with --time, of Embree 4 the viewer by a shader.
  std::vector<int> pathtracer_cosines(const fs::path& file, float time, const std::string& more) {
    const fs::path image = folder / "o.ppm";
    fs::remove(image);
    std::ostringstream command;
    command << (STBVH_EMBREE_MAJOR >= 4 ? "embree_viewer --shader eyelight" : kPathtracer)
            << " --threads 1 -i " << file << ' ' << more << " --time " << time << " --size " << kWidth << ' '
            << kHeight << " -o " << image << " > " << folder / "log"
            << " 2>&1";
    EXPECT_EQ(std::system(command.str().c_str()), 0) << command.str();
    const std::string bytes = read_file(image);
    const std::size_t size = 3 * kWidth * kHeight;
    std::vector<int> cosines;
    if (bytes.size() < size) return cosines;
    for (std::size_t i = bytes.size() - size; i < bytes.size(); i += 3)
      cosines.push_back(static_cast<unsigned char>(bytes[i + 1]) - static_cast<unsigned char>(bytes[i]));
    return cosines;
  }

  /// The same of `scene`, by rays of ours.
  static std::vector<int> our_cosines(const Scene& scene, float time) {
    const Camera& c = scene.camera;
    const Vec3 forward = normalize(to_double(c.target) - to_double(c.position));
    const Vec3 right = normalize(cross(forward, to_double(c.up))), up = cross(right, forward);
    const double focal =
        0.5 * kHeight / std::tan(static_cast<double>(c.vertical_fov_degrees) * std::numbers::pi / 360);
    std::vector<Ray> rays;
    for (std::size_t y = 0; y < kHeight; ++y) {
      for (std::size_t x = 0; x < kWidth; ++x) {
        const Vec3 d = right * (static_cast<double>(x) - 0.5 * kWidth) +
                       up * (0.5 * kHeight - static_cast<double>(y)) + forward * focal;
        rays.push_back({.origin = c.position,
                        .tnear = 0,
                        .direction = to_float(normalize(d)),
                        .time = time,
                        .tfar = std::numeric_limits<float>::infinity(),
                        .mask = 0xFFFFFFFFu});
      }
    }
    std::vector<HitRecord> hits(rays.size());
    build_structure("embree", scene, 1)->intersect(rays, hits);
    std::vector<int> cosines(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!hits[i].is_hit()) continue;
      const Mesh& mesh = scene.meshes[hits[i].geom_id];
      const auto v = triangle_at(mesh, hits[i].prim_id, motion_sample(mesh, time));
      const Vec3 normal = normalize(cross(v[1] - v[0], v[2] - v[0]));
      cosines[i] = static_cast<int>(-255 * dot(normal, to_double(rays[i].direction)));
    }
    return cosines;
  }

  /// Nearly all pixels are equal; the few that are not lie where a float decides which triangle is hit.
  void expect_same_picture(const Scene& scene, const fs::path& file, float time,
                           const std::string& more = "") {
    SCOPED_TRACE(file.string() + " at " + std::to_string(time));
    const std::vector<int> theirs = pathtracer_cosines(file, time, more), ours = our_cosines(scene, time);
    ASSERT_EQ(theirs.size(), ours.size());
    std::size_t different = 0, hit = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      different += std::abs(ours[i] - theirs[i]) > 2 ? 1u : 0u;
      hit += ours[i] != 0 ? 1u : 0u;
    }
    EXPECT_LE(different, ours.size() / 200) << "of " << hit << " that we hit";
    most_hit = std::max(most_hit, hit);
  }

  std::size_t most_hit = 0;
};

void expect_same_scene(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t m = 0; m < a.meshes.size(); ++m) {
    const Mesh &x = a.meshes[m], &y = b.meshes[m];
    EXPECT_EQ(x.indices, y.indices);
    EXPECT_EQ(x.time_range.begin, y.time_range.begin);
    EXPECT_EQ(x.time_range.end, y.time_range.end);
    ASSERT_EQ(x.steps.size(), y.steps.size());
    for (std::size_t s = 0; s < x.steps.size(); ++s)
      EXPECT_TRUE(same_bits(x.steps[s], y.steps[s])) << m << ' ' << s;
    EXPECT_EQ(x.material.kind, y.material.kind);
    EXPECT_EQ(std::memcmp(&x.material.color, &y.material.color, sizeof(Vec3f)), 0);
    EXPECT_EQ(std::memcmp(&x.material.emission, &y.material.emission, sizeof(Vec3f)), 0);
  }
  EXPECT_EQ(std::memcmp(&a.camera.position, &b.camera.position, sizeof(Vec3f)), 0);
  EXPECT_EQ(std::memcmp(&a.camera.target, &b.camera.target, sizeof(Vec3f)), 0);
  EXPECT_EQ(a.camera.vertical_fov_degrees, b.camera.vertical_fov_degrees);
}

Scene built_in(const char* name) {
  return find_procedural_scene(name)->make(0.002, 1);
}

TEST_F(EmbreeXmlTools, RoundTripOfBuiltInScenes) {
  for (const char* const name : {"train", "cloth", "static-city"}) {
    const Scene scene = built_in(name);
    expect_same_scene(scene, load_file(write_xml(scene)));
    EXPECT_TRUE(warnings.empty());
  }
}

TEST_F(EmbreeXmlTools, RoundTripOfAnAsset) {
  const fs::path asset = fs::path(STBVH_SOURCE_DIR) / "../shared/assets/CesiumMan.glb";
  if (!fs::exists(asset)) GTEST_SKIP() << "no asset " << asset;
  const Scene scene = load_gltf(asset);
  expect_same_scene(scene, load_file(write_xml(scene)));
}

TEST_F(EmbreeXmlTools, RoundTripOfEverythingTheFormatSays) {
  Scene scene = load(triangle(R"(<material><code>"Plastic"</code><parameters/></material>)",
                              "0.1 1e-40 -0  3.3 0.7 1e17  0 1 0"));
  Mesh moving = scene.meshes[0];
  moving.name = "a<b & \"c\"";
  moving.steps.push_back(moving.steps[0]);
  moving.steps[1][2].x = 0.3f;
  moving.time_range = {-0.1f, 0.7f};
  moving.material = {.kind = Material::Kind::kGlass, .color = {1, 0.5f, 0.3f}, .index_of_refraction = 1.31f};
  scene.meshes.push_back(moving);
  moving.material = {.kind = Material::Kind::kMirror, .emission = {1, 2, 3}};
  scene.meshes.push_back(moving);
  scene.directional_lights = {{.direction = {0.3f, -1, 0.1f}, .irradiance = {1, 2, 3}},
                              {.direction = {-2, 0, 0}, .irradiance = {3, 2, 1}, .half_angle_degrees = 4}};
  scene.environment.emplace().radiance = {0.1f, 0.2f, 0.3f};
  const Scene back = load_file(write_xml(scene));
  expect_same_scene(scene, back);
  EXPECT_FALSE(fs::file_size(folder / "r.bin"));  // small enough for the text
  EXPECT_EQ(back.meshes[0].material.index_of_refraction, scene.meshes[0].material.index_of_refraction);
  EXPECT_EQ(back.meshes[0].material.roughness, scene.meshes[0].material.roughness);
  EXPECT_EQ(back.meshes[1].material.index_of_refraction, 1.31f);
  ASSERT_EQ(back.directional_lights.size(), 2u);
  expect_at(back.directional_lights[0].direction, 0.3f, -1, 0.1f);
  expect_at(back.directional_lights[0].irradiance, 1, 2, 3);
  expect_at(back.directional_lights[1].irradiance, 3, 2, 1);
  EXPECT_EQ(back.directional_lights[1].half_angle_degrees, 4);
  expect_at(back.environment.value().radiance, 0.1f, 0.2f, 0.3f);
}

TEST_F(EmbreeXmlTools, WhatTheFormatCannotSayIsTold) {
  Scene scene = load(triangle());
  scene.meshes[0].material.emission = {1, 1, 1};
  Environment picture{
      .radiance = {2, 2, 2}, .width = 2, .height = 2, .pixels = {{1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 2}}};
  scene.environment = picture;
  const fs::path file = write_xml(scene);
  EXPECT_TRUE(warned_of("mean"));
  EXPECT_TRUE(warned_of("dark"));
  expect_at(load_file(file).environment.value().radiance, 1, 1, 1);  // halves, and a quarter of 2, doubled
}

TEST_F(EmbreeXmlTools, ConvertedScenesLookTheSameToPathtracer) {
  if (!has_pathtracer()) GTEST_SKIP() << "no pathtracer (embree-tools)";
  for (const char* const name : {"train", "dancer"}) {
    const Scene scene = built_in(name);
    const fs::path file = write_xml(scene);
    for (const float time : {0.0f, 0.37f, 1.0f}) expect_same_picture(scene, file, time);
  }
  EXPECT_GT(most_hit, kWidth * kHeight / 10);
}

TEST_F(EmbreeXmlTools, EmbreesOwnScenesLookTheSameToUs) {
  if (!has_pathtracer() || !fs::exists(kModels)) GTEST_SKIP() << "no pathtracer or no models (embree-tools)";
  for (const char* const name : {"cornell_box.xml", "cornell_box_mblur.xml", "mblur_time_range_triangle.xml",
                                 "mblur_time_range_quad.xml"}) {
    const Scene scene = load_file(kModels / name);
    for (const float time : {0.03f, 0.15f, 0.45f, 0.7f, 0.97f})
      expect_same_picture(scene, kModels / name, time);
    EXPECT_GT(most_hit, kWidth * kHeight / 100) << name;
    most_hit = 0;
  }
}

/// Embree's tools cut a surface as finely as the picture needs it, we everywhere alike: outlines nearly
/// agree. (Not of subdiv0.xml: where creases of different sharpness meet, Embree departs from DeRose's
/// rules.)
TEST_F(EmbreeXmlTools, EmbreesCagesHaveNearlyOurOutlines) {
  if (!has_pathtracer() || !fs::exists(kModels)) GTEST_SKIP() << "no pathtracer or no models (embree-tools)";
  for (const char* const name : {"subdiv1", "subdiv6", "subdiv_smooth_boundary", "subdiv_pin_corners"}) {
    SCOPED_TRACE(name);
    const fs::path file = kModels / (std::string(name) + ".xml");
    const Scene scene = load_file(file);
    const Camera& c = scene.camera;
    std::ostringstream view;
    view << "--vp " << c.position.x << ' ' << c.position.y << ' ' << c.position.z << " --vi " << c.target.x
         << ' ' << c.target.y << ' ' << c.target.z << " --vu 0 1 0 --fov " << c.vertical_fov_degrees;
    const std::vector<int> theirs = pathtracer_cosines(file, 0, view.str()), ours = our_cosines(scene, 0);
    ASSERT_EQ(theirs.size(), ours.size());
    std::size_t different = 0, hit = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      different += (ours[i] == 0) != (theirs[i] == 0) ? 1u : 0u;
      hit += ours[i] != 0 ? 1u : 0u;
    }
    EXPECT_GT(hit, ours.size() / 20);
    EXPECT_LE(different, hit / 50);
  }
}

/// All that places and moves, with shapes and matrices that no mirroring or transposing leaves as they are.
TEST_F(EmbreeXmlTools, TransformsMeanWhatTheyMeanToEmbree) {
  if (!has_pathtracer()) GTEST_SKIP() << "no pathtracer (embree-tools)";
  const std::string material =
      R"(<material><code>"OBJ"</code><parameters><float3 name="Kd">1 1 1</float3></parameters></material>)";
  const std::string shape =
      "<TriangleMesh>" + material + R"(<positions>0 0 0  2 0 0  0 1 0  0 0 0.5</positions>
    <triangles>0 1 2  0 2 3  0 3 1</triangles></TriangleMesh>)";
  const std::string moving =
      "<TriangleMesh>" + material + R"(<animated_positions><positions>0 0 0 2 0 0 0 1 0</positions>
    <positions>0 0 1 3 0 0 0 1 0</positions><positions>0 0 0 2 2 0 0 1 2</positions></animated_positions><triangles>0 1 2</triangles></TriangleMesh>)";
  const fs::path file =
      write_scene(R"(<PerspectiveCamera name="c" from="1 2 12" to="0 0.5 0" up="0.1 1 0" fov="35"/>
    <assign type="scene" id="shape">)" +
                  shape + R"(</assign>
    <Transform><AffineSpace>0.6 -0.7 0.2 -4  0.5 0.9 -0.3 1  0.1 0.4 1.2 0.5</AffineSpace><ref id="shape"/></Transform>
    <Transform><AffineSpace axis="1 2 3" angle="50" point="3 1 0"/><Transform><AffineSpace scale="1 2 1"/><ref id="shape"/></Transform></Transform>
    <Transform><AffineSpace translate="-2 -2 0"/><TransformAnimation><AffineSpace rotate_z="0"/><AffineSpace rotate_z="80"/>
    <AffineSpace rotate_y="-60"/><ref id="shape"/></TransformAnimation></Transform>
    <TransformAnimation><AffineSpace translate="2 -2 0"/><AffineSpace translate="3 -2 1"/><AffineSpace rotate_x="50"/>)" +
                  moving + R"(</TransformAnimation>
    <TimeRange time="0.2 0.6"><Flatten><TransformAnimation><AffineSpace translate="-1 2 0"/><AffineSpace translate="1 2 0"/><ref id="shape"/>
    </TransformAnimation></Flatten></TimeRange>)");
  const Scene scene = load_file(file);
  for (const float time : {0.0f, 0.1f, 0.25f, 0.5f, 0.55f, 0.8f, 1.0f})
    expect_same_picture(scene, file, time);
  EXPECT_GT(most_hit, kWidth * kHeight / 50);
}

/// Embree forgets the time range of a transform that it flattens, and heeds it where it makes instances.
TEST_F(EmbreeXmlTools, TimeRangesOfTransformsAreThoseOfInstances) {
  if (!has_pathtracer()) GTEST_SKIP() << "no pathtracer (embree-tools)";
  const fs::path file =
      write_scene(R"(<PerspectiveCamera name="c" from="0 0 8" to="0 0 0" up="0 1 0" fov="35"/>
    <TimeRange time="0.25 0.75"><TransformAnimation><AffineSpace translate="-1 0 0"/><AffineSpace translate="1 0 0"/>)" +
                  triangle(R"(<material><code>"OBJ"</code><parameters/></material>)") +
                  "</TransformAnimation></TimeRange>");
  const Scene scene = load_file(file);
  for (const float time : {0.1f, 0.3f, 0.6f, 0.9f})
    expect_same_picture(scene, file, time, "--instancing geometry");
}

/// A diffuse wall shows albedo / pi times the irradiance times the cosine, whatever the light's length.
TEST_F(EmbreeXmlTools, SunsShineWhereTheyShineForEmbree) {
  if (!has_pathtracer()) GTEST_SKIP() << "no pathtracer (embree-tools)";
  Scene scene = load(R"(<PerspectiveCamera name="c" from="0 0 8" to="0 0 0" up="0 1 0" fov="35"/>)" +
                     triangle("", "-90 -90 0  90 -90 0  0 90 0"));
  scene.meshes[0].material.color = {0.5f, 0.25f, 1};
  scene.directional_lights = {{.direction = {0.6f, 3, -4}, .irradiance = {3, 4, 2}}};
  const fs::path file = write_xml(scene), image = folder / "o.ppm";
  const std::string command =
      kPathtracer + " --threads 1 -i " + file.string() + " --size 8 8 --spp 4 -o " + image.string();
  ASSERT_EQ(std::system((command + " > /dev/null 2>&1").c_str()), 0);
  const std::string bytes = read_file(image);
  ASSERT_GE(bytes.size(), 3 * 64u);
  const double cosine = 4 / std::sqrt(0.36 + 9 + 16);
  const double expected[] = {0.5 * 3, 0.25 * 4, 1.0 * 2};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto shown = static_cast<unsigned char>(bytes[bytes.size() - 3 * 64 + 3 * 35 + i]);
    EXPECT_NEAR(shown, 255 * expected[i] * cosine / std::numbers::pi, 1.5);
  }
}

TEST_F(EmbreeXmlTools, ConvertCommand) {
  const std::string at = folder.string();
  const Outcome done = stbvh_ab("convert train --scale 0.002 -o " + at + "/t.xml");
  EXPECT_EQ(done.exit_code, 0) << done.out;
  EXPECT_NE(done.out.find(at + "/t.bin\n" + at + "/t.xml\n"), std::string::npos) << done.out;
  expect_same_scene(built_in("train"), load_file(folder / "t.xml"));
  const Outcome again = stbvh_ab("convert " + at + "/t.xml -o " + at + "/u.xml");
  EXPECT_EQ(again.exit_code, 0) << again.out;
  expect_same_scene(built_in("train"), load_file(folder / "u.xml"));
  const Outcome used = stbvh_ab("error --scenes " + at + "/t.xml --structures stbvh --count 50 --threads 1");
  EXPECT_EQ(used.exit_code, 0) << used.out;
}

TEST_F(EmbreeXmlTools, ConvertLeavesBuffersOfOthersAlone) {
  const std::string command = "convert train --scale 0.002 -o " + (folder / "a.xml").string();
  write("a.bin", "mine");
  EXPECT_EQ(stbvh_ab(command).exit_code, 2);
  write("a.xml", "");
  write("a.gltf", "");
  EXPECT_EQ(stbvh_ab(command).exit_code, 2);
  EXPECT_EQ(fs::file_size(folder / "a.bin"), 4u);
  fs::remove(folder / "a.gltf");
  EXPECT_EQ(stbvh_ab(command).exit_code, 0);
  EXPECT_GT(fs::file_size(folder / "a.bin"), 4u);
}

TEST_F(EmbreeXmlTools, ConvertRefuses) {
  const std::string at = folder.string();
  EXPECT_EQ(stbvh_ab("convert train").exit_code, 2);
  EXPECT_EQ(stbvh_ab("convert -o " + at + "/t.xml").exit_code, 2);
  EXPECT_EQ(stbvh_ab("convert train -o " + at + "/t.obj").exit_code, 2);
  EXPECT_EQ(stbvh_ab("convert all -o " + at + "/t.xml").exit_code, 2);
  EXPECT_EQ(stbvh_ab("convert none.xml -o " + at + "/t.xml").exit_code, 2);
  EXPECT_EQ(stbvh_ab("convert train -o " + at + "/none/t.xml").exit_code, 2);
  write_scene("<Points/>");
  const Outcome nothing = stbvh_ab("convert " + at + "/s.xml -o " + at + "/t.xml");
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_NE(nothing.out.find("1 <Points>"), std::string::npos) << nothing.out;
  // A full disk behind the binary file: the text stays what it was.
  if (!make_device("full", Device::kFull)) GTEST_SKIP() << "only root may make device nodes";
  fs::create_symlink("full", folder / "t.bin");
  write("t.xml", "old");
  const Outcome full = stbvh_ab("convert train --scale 0.002 -o " + at + "/t.xml");
  EXPECT_EQ(full.exit_code, 2) << full.out;
  EXPECT_NE(full.out.find("No space left"), std::string::npos) << full.out;
  EXPECT_EQ(fs::file_size(folder / "t.xml"), 3u);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    EXPECT_NE(entry.path().extension(), ".partial") << entry.path();
}

}  // namespace
}  // namespace stbvh::harness
