/// Lights, cameras, time ranges and places at the ends of what floats can say: what is read can be shown, and
/// what is written can be read.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "harness/scenes/embree_xml/writer.h"
#include "harness/scenes/gltf/framing.h"
#include "harness/scenes/light_check.h"
#include "harness/scenes/obj/obj.h"
#include "harness/scenes/reach.h"
#include "plugin/files/output_file.h"
#include "tests/harness/embree_xml_files.h"
#include "tests/random.h"

namespace stbvh::harness {
namespace {

using test::Random;

constexpr float kMost = std::numeric_limits<float>::max(), kInfinity = std::numeric_limits<float>::infinity();
const float kNan = std::nanf("");

bool is_usable(const Camera& camera) {
  return is_within_reach(to_double(camera.target)) && problem_of(camera).empty();
}

class EmbreeXmlExtremes : public EmbreeXmlTest {
 protected:
  fs::path write_xml(const Scene& scene) {
    warnings.clear();
    const EmbreeXml content = to_embree_xml(scene, [&](const std::string& w) { warnings.push_back(w); });
    const fs::path file = folder / "r.xml";
    const std::vector<FileContent> files{{embree_binary_file(file), content.binary}, {file, {content.xml}}};
    write_files(files);
    return file;
  }

  /// What is read of `file`, written, can be read, and is the same.
  void expect_round_trip(const Scene& scene) {
    const fs::path file = write_xml(scene);
    const std::string refusal = refusal_of(file);
    ASSERT_EQ(refusal, "") << read_file(file).substr(0, 2000);
    const Scene back = load_file(file);
    ASSERT_EQ(back.meshes.size(), scene.meshes.size());
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
      ASSERT_EQ(back.meshes[m].steps.size(), scene.meshes[m].steps.size());
      for (std::size_t s = 0; s < scene.meshes[m].steps.size(); ++s)
        EXPECT_TRUE(same_bits(back.meshes[m].steps[s], scene.meshes[m].steps[s]));
    }
    EXPECT_TRUE(is_usable(back.camera));
  }
};

Mesh mesh_of(const std::array<Vec3f, 3>& corners, std::size_t steps) {
  Mesh mesh;
  mesh.name = "m";
  mesh.indices = {0, 1, 2};
  for (std::size_t s = 0; s < steps; ++s) {
    VertexBuffer& step = mesh.steps.emplace_back(3);
    for (std::size_t v = 0; v < 3; ++v) step[v] = corners[(v + s) % 3];
  }
  return mesh;
}

Mesh triangle_of(float size, float x = 0) {
  return mesh_of({Vec3f{x, 0, 0}, Vec3f{x + size, 0, 0}, Vec3f{x, size, 0}}, 1);
}

float any_of(Random& random, const std::vector<float>& values) {
  return values[random.below(static_cast<unsigned>(values.size()))];
}

const std::vector<float> kValues{0, 0,     1,      -1,    0.3f,   -7.7f,    1e-45f,        1e-41f,
                                 3, -4e9f, 1e-38f, 1e18f, -1e18f, 1.2e-38f, 1.8439999e18f, -3e-20f};

Vec3f any_place(Random& random) {
  return {any_of(random, kValues), any_of(random, kValues), any_of(random, kValues)};
}

/// Now and then with what is no number, or none of its kind.
Vec3f any_vector(Random& random) {
  static const std::vector<float> kBad{kNan, kInfinity, -kInfinity, kMost, -kMost, 2e18f, 1.844e18f};
  Vec3f v = any_place(random);
  if (random.below(4) == 0) v.y = any_of(random, kBad);
  return v;
}

Vec3f any_color(Random& random) {
  static const std::vector<float> kColors{0, 1, 2.5f, 1e-45f, 1e-39f, 1e20f, 3e38f, kMost};
  static const std::vector<float> kBad{kNan, kInfinity, -1};
  Vec3f color{any_of(random, kColors), any_of(random, kColors), any_of(random, kColors)};
  if (random.below(8) == 0) color.z = any_of(random, kBad);
  return color;
}

Scene any_scene(Random& random) {
  static const std::vector<float> kAngles{0,  0,         1e-45f, 1e-30f, 1e-8f, 0.5f,
                                          30, 89.99999f, 90,     90.1f,  -1,    kNan};
  static const std::vector<float> kTimes{0, 1e-45f, 1e-39f, 1e-5f, 0.25f, 0.999f, 1, 2, 17, 3e38f};
  Scene scene;
  for (unsigned i = 0; i <= random.below(3); ++i) {
    Mesh& mesh = scene.meshes.emplace_back(
        mesh_of({any_place(random), any_place(random), any_place(random)}, 1 + random.below(3)));
    const float a = any_of(random, kTimes), b = any_of(random, kTimes);
    if (a != b) mesh.time_range = {random.below(4) == 0 ? -std::max(a, b) : std::min(a, b), std::max(a, b)};
    if (random.below(3) == 0) mesh.material.emission = any_color(random);
  }
  for (unsigned i = 0; i < random.below(4); ++i)
    scene.directional_lights.push_back({any_vector(random), any_color(random), any_of(random, kAngles)});
  if (random.below(2) == 0) scene.environment.emplace().radiance = any_color(random);
  scene.camera = {any_vector(random), any_vector(random), any_vector(random),
                  any_of(random, {40, 1e-42f, 179.99998f, 180, 0, kNan})};
  if (random.below(3) == 0) scene.camera = gltf::framing_camera(scene);
  return scene;
}

bool is_kept(const Mesh& mesh) {
  const TimeRange& range = mesh.time_range;
  return mesh.is_static() || (std::min(range.end, 1.0f) - std::max(range.begin, 0.0f) >= 0x1p-10f &&
                              range.end - range.begin <= 16);
}

float without_denormal(float x) {
  return std::fpclassify(x) == FP_SUBNORMAL ? 0.0f : x;
}

/// What Embree has words for comes back; the rest is told, and left out.
TEST_F(EmbreeXmlExtremes, WhatIsWrittenCanBeRead) {
  std::size_t cameras = 0, lights = 0, discs = 0, ranges = 0, empty = 0;
  for (std::uint32_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Scene scene = any_scene(random);
    std::vector<Mesh> kept;
    for (const Mesh& mesh : scene.meshes) {
      if (is_kept(mesh)) kept.push_back(mesh);
    }
    if (kept.empty()) {
      ++empty;
      EXPECT_THROW(to_embree_xml(scene), SceneFileError);
      continue;
    }
    const fs::path file = write_xml(scene);
    const bool told = !warnings.empty(), told_of_camera = warned_of("camera"),
               told_of_light = warned_of("A directional light is not written");
    const std::string refusal = refusal_of(file);
    ASSERT_EQ(refusal, "") << read_file(file).substr(0, 2000);
    const Scene back = load_file(file);
    EXPECT_TRUE(warnings.empty()) << warnings.front();
    EXPECT_TRUE(is_usable(back.camera));
    EXPECT_TRUE(kept.size() == scene.meshes.size() || told);
    ASSERT_EQ(back.meshes.size(), kept.size());
    for (std::size_t m = 0; m < kept.size(); ++m) {
      const Mesh &a = kept[m], &b = back.meshes[m];
      ASSERT_EQ(a.steps.size(), b.steps.size());
      for (std::size_t s = 0; s < a.steps.size(); ++s) EXPECT_TRUE(same_bits(a.steps[s], b.steps[s]));
      EXPECT_EQ(b.time_range.begin, a.is_static() ? 0 : without_denormal(a.time_range.begin));
      EXPECT_EQ(b.time_range.end, a.is_static() ? 1 : a.time_range.end);
      ranges += b.time_range.end != 1 ? 1u : 0u;
    }
    if (!told_of_camera) {
      const Vec3 was = normalize(to_double(scene.camera.target) - to_double(scene.camera.position));
      const Vec3 is = normalize(to_double(back.camera.target) - to_double(back.camera.position));
      EXPECT_GT(dot(was, is), 0.999);
      ++cameras;
    }
    std::vector<DirectionalLight> sound;
    for (const DirectionalLight& light : scene.directional_lights) {
      if (flaw_of(light).empty()) sound.push_back(light);
    }
    EXPECT_EQ(told_of_light, sound.size() < scene.directional_lights.size());
    if (scene.directional_lights.empty()) continue;  // there may be a sun of no one's
    ASSERT_EQ(back.directional_lights.size(), sound.size());
    for (std::size_t i = 0; i < sound.size(); ++i) {
      const DirectionalLight &a = sound[i], &b = back.directional_lights[i];
      EXPECT_EQ(std::memcmp(&a.direction, &b.direction, sizeof a.direction), 0);
      const auto expect_near = [](float x, float y) { EXPECT_NEAR(x, y, 1e-6f * x + 1e-38f); };
      expect_near(a.irradiance.x, b.irradiance.x);
      expect_near(a.irradiance.y, b.irradiance.y);
      expect_near(a.irradiance.z, b.irradiance.z);
      // A disc is too small for light of which its radiance would not be a float.
      const double sine = std::sin(a.half_angle_degrees * kPi / 180);
      const double radiance =
          std::max({a.irradiance.x, a.irradiance.y, a.irradiance.z}) / (kPi * sine * sine);
      EXPECT_EQ(b.half_angle_degrees, radiance <= double{kMost} ? a.half_angle_degrees : 0);
      ++lights;
      discs += b.half_angle_degrees > 0 ? 1u : 0u;
    }
  }
  for (const std::size_t count : {cameras, lights, discs, ranges, empty}) EXPECT_GT(count, 20u);
}

/// Of some the nearest radiance would be read as an infinite irradiance.
TEST_F(EmbreeXmlExtremes, TheBrightestDiscsCanBeReadAgain) {
  Scene scene;
  scene.meshes.push_back(triangle_of(1));
  for (float angle = 35; angle <= 90; angle += 0.5f) {
    scene.directional_lights = {
        {.direction = {0, -1, 0}, .irradiance = {kMost, kMost, 0}, .half_angle_degrees = angle}};
    const fs::path file = write_xml(scene);
    ASSERT_EQ(refusal_of(file), "") << angle;
    const DirectionalLight light = load_file(file).directional_lights.at(0);
    EXPECT_EQ(light.half_angle_degrees, angle);
    EXPECT_GE(light.irradiance.x, kMost * (1 - 1e-6f)) << angle;
  }
}

TEST_F(EmbreeXmlExtremes, CamerasOfTinyScenesComeBackBitForBit) {
  for (const float size : {1e-44f, 1e-40f, 1e-38f, 1e-30f, 1e-20f, 1.0f}) {
    Scene scene;
    scene.meshes.push_back(triangle_of(size));
    scene.camera = gltf::framing_camera(scene);
    EXPECT_TRUE(is_usable(scene.camera)) << size;
    const Scene back = load_file(write_xml(scene));
    for (const auto of : {&Camera::position, &Camera::target})
      EXPECT_EQ(std::memcmp(&(back.camera.*of), &(scene.camera.*of), sizeof(Vec3f)), 0) << size;
    EXPECT_GT(back.camera.up.y, 0) << size;
  }
}

/// The camera of a scene that has none is within reach and looks at it, wherever it is.
TEST_F(EmbreeXmlExtremes, AnySceneIsFramed) {
  const auto largest = static_cast<float>(kFarthest);
  const auto expect_framed = [&](const Mesh& mesh) {
    Scene scene;
    scene.meshes.push_back(mesh);
    scene.camera = gltf::framing_camera(scene);
    SCOPED_TRACE(scene.bounds().upper.x);
    ASSERT_TRUE(is_usable(scene.camera));
    const Vec3 position = to_double(scene.camera.position);
    const Vec3 way = normalize(to_double(scene.camera.target) - position);
    const Vec3 corner = normalize(to_double(mesh.steps[0][0]) - position);
    EXPECT_GT(dot(way, corner), 0.5);
    expect_round_trip(scene);
  };
  for (const float size : {1e-44f, 1.0f, 1e17f, 1.8e18f, largest}) expect_framed(triangle_of(size));
  for (const float x : {1e9f, -1e18f, 1.7e18f}) expect_framed(triangle_of(1e-3f, x));
  expect_framed(
      mesh_of({Vec3f{-largest, -largest, 0}, Vec3f{largest, -largest, 0}, Vec3f{0, largest, 0}}, 1));
  // One to which nothing is nearer than the end of reach.
  Scene corner;
  corner.meshes.push_back(mesh_of(
      {Vec3f{largest, largest, largest}, Vec3f{largest, largest, largest}, Vec3f{largest, largest, largest}},
      1));
  EXPECT_TRUE(is_usable(gltf::framing_camera(corner)));
  const Scene far = load_obj(write("far.obj", "v 0 0 0\nv 1.8e18 0 0\nv 0 1.8e18 0\nf 1 2 3\n").string());
  EXPECT_TRUE(is_usable(far.camera));
  expect_round_trip(far);
}

TEST_F(EmbreeXmlExtremes, LightsAreCheckedBehindTransformsAndSums) {
  const std::string ambient = "<AmbientLight><L>3e38 0 0</L></AmbientLight>";
  EXPECT_EQ(load(triangle() + ambient).environment.value().radiance.x, 3e38f);
  expect_refused(triangle() + ambient + ambient, "its ambient light shines with inf 0 0");
  const auto distant = [](const char* l) {
    return triangle() + R"(<DistantLight><AffineSpace scale="1 1 1"/><L>)" + l +
           "</L><halfAngle>90</halfAngle></DistantLight>";
  };
  expect_round_trip(load(distant("1e38 1 1")));
  expect_refused(distant("3e38 1 1"), ", line 3: a <DistantLight> shines with inf 3.1415927 3.1415927");
  const auto scaled = [](const std::string& scale) {
    return triangle() + "<Transform><AffineSpace scale=\"" + scale + "\"/><Transform><AffineSpace scale=\"" +
           scale + R"("/><DirectionalLight><AffineSpace scale="1 1 1"/><E>1 2 3</E></DirectionalLight>
           </Transform></Transform>)";
  };
  expect_refused(scaled("0 0 0"), "its directional light 1 has no direction");
  expect_refused(scaled("1 1 0"), "its directional light 1 has no direction");
  for (const char* const scale : {"1e-30 1e-30 1e-30", "1e30 1e30 1e30"}) {
    const Scene scene = load(scaled(scale));
    expect_at(scene.directional_lights.at(0).direction, 0, 0, 1);
    expect_round_trip(scene);
  }
}

TEST_F(EmbreeXmlExtremes, LightsOfCommandListsAreLights) {
  write_scene(triangle() + "<AmbientLight><L>3e38 0 0</L></AmbientLight>");
  const auto expect_list_refused = [&](const std::string& options, const std::string& because) {
    const std::string said = refusal_of(write("l.ecs", "-i s.xml " + options));
    EXPECT_EQ(said.substr(0, because.size() + 2), ": " + because) << options;
  };
  expect_list_refused("-dirlight 0 0 0 1 1 1", "-dirlight has no direction");
  expect_list_refused("-dirlight 0 -1 0 -1 -1 -1", "-dirlight shines with -1 -1 -1: each must be finite");
  expect_list_refused("-ambientlight -1 0 0", "-ambientlight shines with -1 0 0");
  expect_list_refused("-ambientlight 3e38 0 0", "its ambient light shines with inf 0 0");
  expect_list_refused("-distantlight 0 -1 0 1 1 1 0",
                      "-distantlight needs a half angle above 0 and up to 90");
  expect_list_refused("-distantlight 0 -1 0 1 1 1 400",
                      "-distantlight needs a half angle above 0 and up to 90");
  expect_list_refused("-distantlight 0 -1 0 3e38 1 1 90",
                      "-distantlight shines with inf 3.1415927 3.1415927");
  const Scene scene =
      load_file(write("l.ecs", "-i s.xml -distantlight 0 -1 0 1 1 1 90 -dirlight 1e-45 0 0 0 0 0"));
  EXPECT_FLOAT_EQ(scene.directional_lights.at(0).irradiance.x, 3.1415927f);
  expect_round_trip(scene);
}

TEST_F(EmbreeXmlExtremes, CommandListsLookAsFarAsTheyCan) {
  write_scene(triangle());
  const Scene scene = load_file(write("l.ecs", "-i s.xml -vp 1.8e18 0 0 -vd 1e18 0 1e16 -vu 0 1 0"));
  EXPECT_EQ(scene.camera.position.x, 1.8e18f);
  EXPECT_EQ(scene.camera.target.x, static_cast<float>(kFarthest));
  EXPECT_NEAR(scene.camera.target.z, 4.4e14f, 1e13f);  // as much of the way as of x
  expect_round_trip(scene);
}

/// A mesh that stands still is always there, whatever range is around it.
TEST_F(EmbreeXmlExtremes, TimeRangesOfStaticMeshesMeanNothing) {
  for (const char* const time : {"0 1e-42", "-3e38 3e38", "0.25 0.5"}) {
    const Scene scene = load("<TimeRange time=\"" + std::string(time) + "\">" + triangle() + "</TimeRange>");
    EXPECT_EQ(scene.meshes.at(0).time_range.begin, 0) << time;
    EXPECT_EQ(scene.meshes.at(0).time_range.end, 1) << time;
    expect_round_trip(scene);
  }
}

TEST_F(EmbreeXmlExtremes, NumbersBeyondADoubleAreZeroOrInfinite) {
  const Scene small = load(triangle("", "0 0 0 1 0 0 0 1 1e-400") + triangle("", "0 0 0 1 0 0 0 1 -1e-46"));
  EXPECT_EQ(small.meshes.at(0).steps[0][2].z, 0);
  EXPECT_EQ(small.meshes.at(1).steps[0][2].z, 0);
  EXPECT_TRUE(warnings.empty());
  for (const char* const big : {"1e400", "-1e400", "1e39"}) {
    EXPECT_EQ(load(triangle("", std::string("0 0 0 1 0 0 0 1 ") + big) + triangle()).meshes.size(), 1u);
    EXPECT_TRUE(warned_of("1 triangle is left out")) << big;
  }
  expect_refused(triangle("", "0 0 0 1 0 0 0 1 1e400x"), "\"1e400x\" among its numbers");
  expect_refused(
      R"(<QuadMesh><positions>0 0 0 1 0 0 1 1 0 0 1 nan</positions><indices>0 1 2 3</indices></QuadMesh>)",
      "nothing in it can be shown: all triangles of its meshes, 1, are left out");
}

}  // namespace
}  // namespace stbvh::harness
