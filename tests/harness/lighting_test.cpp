/// Light in pictures against what is known in closed form, and against itself by other ways.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "harness/path_tracer/lights.h"
#include "harness/scenes/procedural/shared/mesh_tools.h"
#include "tests/harness/picture_scenes.h"

namespace stbvh::harness {
namespace {

/// A unit sphere that fills the picture.
Scene sphere_in_view(const Material& material) {
  Scene scene;
  scene.meshes.push_back(sphere());
  scene.meshes.back().material = material;
  scene.camera = {.position = {0, 0, 5}, .target = {0, 0, 0}, .up = {0, 1, 0}, .vertical_fov_degrees = 10};
  scene.environment = constant_environment();
  return scene;
}

Material of_kind(Material::Kind kind, float roughness = 0) {
  Material material = white();
  material.kind = kind;
  material.roughness = roughness;
  return material;
}

TEST(Furnace, ConvexDiffuseShowsItsReflectance) {
  const Rendering r = rendered(sphere_in_view(white(0.8f)), small(16, 16));
  for (float value : *r.image.find("G")) EXPECT_NEAR(value, 0.8f, 1e-6f);
  EXPECT_EQ(r.not_finite, 0u);
}

TEST(Furnace, NoRayMeetsTheSurfaceThatItLeaves) {
  // Far from the origin, small, large and moving: a ray that met its own surface again would be darker.
  for (double offset : {1.0, 300.0, 1e4}) {
    for (double size : {1.0, 20.0}) {
      Scene scene = sphere_in_view(white(0.8f));
      const Vec3 center{offset, -2 * offset, offset / 3};
      scene.meshes[0] = sphere(4, [&](Vec3 p, std::size_t k) {
        return center + size * (rotate(axis_angle({1, 2, 3}, 0.7 * static_cast<double>(k)), p));
      });
      scene.meshes[0].material = white(0.8f);
      scene.camera.position = to_float(center + Vec3{0, 0, 5 * size});
      scene.camera.target = to_float(center);
      for (std::string_view structure : {"stbvh-direct", "embree"}) {
        const Rendering r = rendered(scene, small(16, 16), structure);
        EXPECT_NEAR(estimate(r.image).mean, 0.8, 1e-4) << structure << ", " << offset << ", " << size;
      }
    }
  }
}

TEST(Furnace, GlossyMirrorAndGlassOfWhiteAreInvisible) {
  for (float roughness : {0.1f, 0.4f, 1.0f}) {
    const Estimate e =
        estimate(rendered(sphere_in_view(of_kind(Material::Kind::kGlossy, roughness)), small(8, 256)).image);
    EXPECT_NEAR(e.mean, 1, 0.01 + 4 * e.error) << roughness;
    EXPECT_LT(e.error, 0.01);
  }
  for (Material::Kind kind : {Material::Kind::kMirror, Material::Kind::kGlass}) {
    EXPECT_NEAR(estimate(rendered(sphere_in_view(of_kind(kind)), small(16, 64)).image).mean, 1, 1e-3);
  }
}

TEST(Furnace, ClosedSphereIsTheSumOfAllBounces) {
  Scene scene = sphere_in_view(white(0.5f));
  scene.meshes[0].material.emission = {1, 1, 1};
  scene.environment.reset();
  scene.camera.position = {0.3f, 0.2f, 0.1f};
  scene.camera.vertical_fov_degrees = 90;
  for (LightSearch search : {LightSearch::kBoth, LightSearch::kScatteringOnly}) {
    RenderSettings settings = small(16, 64);
    settings.light_search = search;
    const Estimate e = estimate(rendered(scene, settings).image);
    EXPECT_NEAR(e.mean, 2, 4 * e.error + 1e-6);  // 1 + 1/2 + 1/4 + ...
    EXPECT_LT(e.error, 0.02);
  }
}

/// What a point below the middle of a parallel square sees of it, as a share of the cosine-weighted half
/// sphere (the sum over four of its quarters of the view factor of a rectangle from its corner).
double view_factor(double half_side, double height) {
  const double x = half_side / height, s = std::sqrt(1 + x * x);
  return 4 / (2 * kPi) * 2 * (x / s) * std::atan(x / s);
}

TEST(AreaLight, LightsAsItsFormFactorSays) {
  Scene scene;
  scene.meshes = {square(5), square(1, 1, [](Vec3 p, std::size_t) { return p + Vec3{0, 1.5, 0}; })};
  scene.meshes[0].material = white(0.6f);
  scene.meshes[1].material = white(0);
  scene.meshes[1].material.emission = {3, 3, 3};
  scene.camera = looking_down_at({0, 0, 0});
  scene.camera.position = {4, 0.8f, 0};
  for (LightSearch search : {LightSearch::kBoth, LightSearch::kLightsOnly, LightSearch::kScatteringOnly}) {
    RenderSettings settings = small(8, 1024);
    settings.light_search = search;
    const Estimate e = estimate(rendered(scene, settings).image);
    EXPECT_NEAR(e.mean, 0.6 * 3 * view_factor(1, 1.5), 4 * e.error);
    EXPECT_LT(e.error, 0.01);
  }
}

TEST(AreaLight, ThatMovesLightsAsItDoesAtEachTime) {
  // It rises from 1 to 2; the floor gets the mean over its heights.
  Scene scene;
  scene.meshes = {square(5), square(1, 3, [](Vec3 p, std::size_t k) {
                    return p + Vec3{0, 1 + 0.5 * static_cast<double>(k), 0};
                  })};
  scene.meshes[0].material = white(0.6f);
  scene.meshes[1].material = white(0);
  scene.meshes[1].material.emission = {3, 3, 3};
  scene.camera = looking_down_at({0, 0, 0});
  scene.camera.position = {4, 0.8f, 0};
  double expected = 0;
  for (int i = 0; i < 1000; ++i) expected += 0.6 * 3 * view_factor(1, 1 + (i + 0.5) / 1000) / 1000;
  const Estimate e = estimate(rendered(scene, small(8, 1024)).image);
  EXPECT_NEAR(e.mean, expected, 4 * e.error);
  EXPECT_LT(e.error, 0.01);
}

TEST(DirectionalLight, FallsOffWithTheCosine) {
  Scene scene;
  scene.meshes = {square(5)};
  scene.meshes[0].material = white(0.5f);
  scene.camera = looking_down_at({0, 0, 0});
  for (float half_angle : {0.0f, 0.2f, 10.0f}) {
    for (double degrees : {0.0, 30.0, 60.0}) {
      const double angle = degrees * kPi / 180;
      const auto e = static_cast<float>(kPi);
      scene.directional_lights = {{.direction = to_float(Vec3{7 * std::sin(angle), -7 * std::cos(angle), 0}),
                                   .irradiance = {e, e, e},
                                   .half_angle_degrees = half_angle}};
      const Estimate seen = estimate(rendered(scene, small(8, 256)).image);
      EXPECT_NEAR(seen.mean, 0.5 * std::cos(angle), 4 * seen.error + 1e-6) << half_angle << " " << degrees;
      EXPECT_LT(seen.error, 0.002);
    }
  }
}

TEST(PointLight, FallsOffWithTheSquareAndTheCosineAndEndsWithItsCone) {
  Scene scene;
  scene.meshes = {square(5)};
  scene.meshes[0].material = white(0.5f);
  scene.camera = looking_down_at({1, 0, 0});
  const auto i = static_cast<float>(kPi);
  const auto seen = [&] { return estimate(rendered(scene, small(8, 64)).image).mean; };
  for (const double height : {0.5, 2.0}) {
    scene.point_lights = {{.position = {0, static_cast<float>(height), 0}, .intensity = {i, i, i}}};
    const double distance2 = 1 + height * height;
    EXPECT_NEAR(seen(), 0.5 * height / std::sqrt(distance2) / distance2, 1e-3) << height;
  }
  // From height 1 the point is seen at 45 degrees to the axis.
  PointLight& spot = scene.point_lights[0];
  spot.position = {0, 1, 0};
  spot.axis = {0, -3, 0};
  const double whole = 0.5 / std::sqrt(8.0);
  const auto expect_share = [&](float inner, float outer, double share) {
    spot.inner_angle_degrees = inner;
    spot.outer_angle_degrees = outer;
    EXPECT_NEAR(seen(), share * whole, 1e-3) << inner << " " << outer;
  };
  expect_share(50, 60, 1);
  expect_share(46, 46, 1);
  expect_share(20, 40, 0);
  const double linear = (std::sqrt(0.5) - 0.5) / (std::sqrt(0.75) - 0.5);
  expect_share(30, 60, linear * linear);
  // What is between casts a shadow, what is behind does not.
  spot = {.position = {0, 1, 0}, .intensity = {i, i, i}};
  scene.meshes.push_back(square(0.2, 1, [](Vec3 p, std::size_t) { return p + Vec3{-0.5, 1.5, 0}; }));
  EXPECT_NEAR(seen(), whole, 2e-2);
  scene.meshes.back() = square(0.2, 1, [](Vec3 p, std::size_t) { return p + Vec3{0.5, 0.5, 0}; });
  scene.meshes.back().material = white(0);
  EXPECT_NEAR(seen(), 0, 1e-6);
}

/// Everything at once: rough and smooth things under a square light, a sun and a picture of the sky.
Scene busy_scene() {
  Scene scene;
  scene.meshes = {square(8), sphere(), sphere(2, [](Vec3 p, std::size_t k) {
                    return 0.7 * p + Vec3{1.5, 0.5 + 0.3 * static_cast<double>(k), 0.8};
                  })};
  scene.meshes[0].material = of_kind(Material::Kind::kGlossy, 0.4f);
  scene.meshes[0].material.color = {0.6f, 0.5f, 0.4f};
  scene.meshes[1].material = of_kind(Material::Kind::kGlossy, 0.25f);
  scene.meshes[1].material.color = {0.2f, 0.6f, 0.3f};
  scene.meshes[2].material = white(0.7f);
  scene.meshes.push_back(square(0.8, 2, [](Vec3 p, std::size_t k) {
    return Vec3{p.x, p.z, 0} + Vec3{-1.5 + static_cast<double>(k), 1.5, -1.5};
  }));
  scene.meshes.back().material.emission = {2, 2, 1};
  scene.directional_lights = {{.direction = {1, -2, -1}, .irradiance = {1, 1, 1}, .half_angle_degrees = 8}};
  Environment sky{.radiance = {0.5f, 0.5f, 0.5f}, .width = 16, .height = 8, .pixels = {}};
  for (std::size_t i = 0; i < 128; ++i) {
    const float value = i % 16 == 3 && i / 16 == 2 ? 20.0f : 0.1f * static_cast<float>(i % 5);
    sky.pixels.push_back({value, value, 0.5f * value});
  }
  scene.environment = sky;
  scene.camera = {
      .position = {0, 3, 7}, .target = {0.3f, 0.3f, 0}, .up = {0, 1, 0}, .vertical_fov_degrees = 30};
  return scene;
}

TEST(LightSearch, EachWayAloneAndBothAgree) {
  const Scene scene = busy_scene();
  std::vector<Estimate> estimates;
  for (LightSearch search : {LightSearch::kBoth, LightSearch::kLightsOnly, LightSearch::kScatteringOnly}) {
    RenderSettings settings = small(20, 600);
    settings.light_search = search;
    settings.max_bounces = 3;
    estimates.push_back(estimate(rendered(scene, settings).image, 'G'));
  }
  for (std::size_t i : {1u, 2u}) {
    EXPECT_NEAR(estimates[i].mean, estimates[0].mean, 4 * std::hypot(estimates[i].error, estimates[0].error));
    EXPECT_LT(estimates[i].error, 0.02 * estimates[i].mean);
    EXPECT_GT(estimates[i].error, estimates[0].error);
  }
}

TEST(EnvironmentLight, AimsAtWhatIsBright) {
  const EnvironmentLight light(busy_scene().environment);
  constexpr std::uint32_t kCount = 1 << 16;
  double integral = 0, aimed = 0, uniform = 0;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const SamplePoint s = scrambled_sobol(i, 9);
    const double y = 2 * s.x - 1, r = std::sqrt(1 - y * y);
    const Vec3 d{r * std::cos(2 * kPi * s.y), y, r * std::sin(2 * kPi * s.y)};
    integral += light.density(d) * 4 * kPi / kCount;
    uniform += light.radiance(d).x * 4 * kPi / kCount;
    const auto sample = light.sample(s);
    ASSERT_TRUE(sample);
    ASSERT_NEAR(length(sample->direction), 1, 1e-9);
    aimed += sample->radiance.x / sample->density / kCount;
  }
  EXPECT_NEAR(integral, 1, 0.01);
  EXPECT_NEAR(aimed, uniform, 0.01 * uniform);
}

TEST(EnvironmentLight, StandsAsTheSceneSays) {
  // Rows from +y down to -y; columns from -z over +x, +z and -x back to -z.
  Environment picture{.radiance = {2, 2, 2}, .width = 8, .height = 5, .pixels = std::vector<Vec3f>(40)};
  for (std::size_t i = 0; i < 40; ++i) {
    const float number = static_cast<float>(i);
    picture.pixels[i] = {number, number, number};
  }
  const EnvironmentLight light(picture);
  const auto middle = [](int eighths) {  // of the columns of row 2, as an angle from -z to +x
    const double a = (eighths + 0.5) * kPi / 4;
    return Vec3{std::sin(a), 0, -std::cos(a)};
  };
  for (int column = 0; column < 8; ++column)
    EXPECT_NEAR(light.radiance(middle(column)).x, 2 * (16 + column), 1e-9);
  EXPECT_NEAR(light.radiance({1, 0, 0}).x, 2 * (16 + 1.5), 1e-9);
  EXPECT_LT(light.radiance({0, 1, 0}).x, 2 * 8);
  EXPECT_GE(light.radiance({0, -1, 0}).x, 2 * 32);
  EXPECT_NEAR(light.radiance({0, 0, -1}).x, 2 * (16 + 3.5), 1e-9);  // between the last and the first column
}

TEST(Lights, RefuseWhatIsNoLight) {
  const float nan = std::nanf("");
  EXPECT_THROW(EnvironmentLight(constant_environment(nan)), std::invalid_argument);
  EXPECT_THROW(EnvironmentLight(constant_environment(-1)), std::invalid_argument);
  EXPECT_THROW(EnvironmentLight(Environment{.radiance = {1, 1, 1}, .width = 4, .height = 2, .pixels = {}}),
               std::invalid_argument);
  EXPECT_THROW(DirectionalLights({{.direction = {0, 0, 0}, .irradiance = {1, 1, 1}}}), std::invalid_argument);
  EXPECT_THROW(DirectionalLights({{.direction = {0, 1, 0}, .irradiance = {1, nan, 1}}}),
               std::invalid_argument);
  EXPECT_THROW(
      DirectionalLights({{.direction = {0, 1, 0}, .irradiance = {1, 1, 1}, .half_angle_degrees = 90}}),
      std::invalid_argument);
  EXPECT_THROW(PointLights({{.position = {nan, 0, 0}}}), std::invalid_argument);
  EXPECT_THROW(PointLights({{.intensity = {0, -1, 0}}}), std::invalid_argument);
  EXPECT_THROW(PointLights({{.axis = {0, 0, 0}}}), std::invalid_argument);
  EXPECT_THROW(PointLights({{.inner_angle_degrees = 50, .outer_angle_degrees = 40}}), std::invalid_argument);
  Scene scene = busy_scene();
  scene.meshes[0].material.emission = {0, -1, 0};
  EXPECT_THROW(AreaLights{scene}, std::invalid_argument);
}

TEST(Lights, BlackOnesAreNeverDrawn) {
  EXPECT_FALSE(DirectionalLights({{.direction = {0, 1, 0}, .irradiance = {0, 0, 0}}}).sample(0.5, {}));
  EXPECT_FALSE(EnvironmentLight(Environment{.radiance = {1, 1, 1},
                                            .width = 2,
                                            .height = 1,
                                            .pixels = std::vector<Vec3f>(2, Vec3f{0, 0, 0})})
                   .sample({0.5, 0.5}));
  EXPECT_FALSE(PointLights({{.intensity = {0, 0, 0}}}).sample({1, 1, 1}, 0.5));
  const Distribution choice({0, 2, 0, 1, 0});
  for (double number : {0.0, 0.3, 0.6, 0.7, std::nextafter(1.0, 0.0)}) {
    const Distribution::Pick pick = choice.pick(number);
    EXPECT_EQ(pick.index, number < 2.0 / 3 ? 1u : 3u) << number;
    EXPECT_NEAR(pick.probability, number < 2.0 / 3 ? 2.0 / 3 : 1.0 / 3, 1e-15);
    EXPECT_NEAR(pick.rest, number < 2.0 / 3 ? number * 1.5 : (number - 2.0 / 3) * 3, 1e-12);
  }
}

}  // namespace
}  // namespace stbvh::harness
