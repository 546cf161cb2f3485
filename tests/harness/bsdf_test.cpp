/// Scattering: no energy is made, what is drawn is what is evaluated, and light may go either way.
#include "harness/path_tracer/bsdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "harness/path_tracer/directions.h"
#include "tests/harness/picture_scenes.h"

namespace stbvh::harness {
namespace {

Material glossy(float roughness, float reflectance) {
  Material m;
  m.kind = Material::Kind::kGlossy;
  m.roughness = roughness;
  m.color = {reflectance, reflectance, reflectance};
  return m;
}

Vec3 viewer_at(double cosine) {
  return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

/// Mean weight of what is drawn: the share of light that is reflected.
double drawn_albedo(const Bsdf& bsdf, Vec3 viewer) {
  constexpr std::uint32_t kCount = 1 << 14;
  double sum = 0;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const auto s = bsdf.sample(viewer, true, scrambled_sobol(i, 1).x, scrambled_sobol(i, 2));
    if (s) sum += s->weight.x;
  }
  return sum / kCount;
}

TEST(Bsdf, WhiteGlossyReflectsAllLight) {
  for (float roughness : {0.0f, 0.1f, 0.3f, 0.6f, 1.0f}) {
    const Bsdf bsdf(glossy(roughness, 1));
    for (double cosine : {0.05, 0.3, 0.7, 1.0}) {
      EXPECT_NEAR(drawn_albedo(bsdf, viewer_at(cosine)), 1, 0.01) << roughness << " at " << cosine;
    }
  }
}

TEST(Bsdf, BlackGlossyReflectsTheFresnelShareWhereSmooth) {
  const Bsdf bsdf(glossy(0.05f, 0));
  EXPECT_NEAR(drawn_albedo(bsdf, viewer_at(1)), 0.04, 0.001);
  EXPECT_NEAR(drawn_albedo(bsdf, viewer_at(0.2)), fresnel(0.2, 1.5), 0.01);
}

TEST(Bsdf, DrawsWhatItEvaluates) {
  for (float roughness : {0.2f, 0.5f, 1.0f}) {
    const Bsdf bsdf(glossy(roughness, 0.6f));
    for (double cosine : {0.2, 0.8}) {
      const Vec3 viewer = viewer_at(cosine);
      constexpr std::uint32_t kCount = 1 << 18;
      double evaluated = 0, density = 0;
      for (std::uint32_t i = 0; i < kCount; ++i) {
        const Vec3 light = cone_direction(scrambled_sobol(i, 3), 0);
        evaluated += bsdf.evaluate(viewer, light).x * 2 * kPi / kCount;
        density += bsdf.density(viewer, light) * 2 * kPi / kCount;
      }
      EXPECT_NEAR(evaluated, drawn_albedo(bsdf, viewer), 0.01) << roughness << " at " << cosine;
      EXPECT_LE(density, 1.01);
      EXPECT_GE(density, 0.7);  // facets may reflect below the horizon: only a part of them
    }
  }
}

TEST(Bsdf, LightMayGoEitherWay) {
  for (const Material& material : {glossy(0.3f, 0.5f), white()}) {
    const Bsdf bsdf(material);
    for (std::uint32_t i = 0; i < 100; ++i) {
      const Vec3 a = cosine_direction(scrambled_sobol(i, 4)), b = cosine_direction(scrambled_sobol(i, 5));
      const double forth = bsdf.evaluate(a, b).x / b.z, back = bsdf.evaluate(b, a).x / a.z;
      EXPECT_NEAR(forth, back, 1e-9 * forth);
    }
  }
}

TEST(Bsdf, GlassRefractsAsSnellSays) {
  Material glass = glossy(0, 1);
  glass.kind = Material::Kind::kGlass;
  const Bsdf bsdf(glass);
  const Vec3 viewer = viewer_at(0.6);
  const auto into = bsdf.sample(viewer, true, 0.999, {});
  ASSERT_TRUE(into && into->is_specular);
  EXPECT_NEAR(-into->direction.x, viewer.x / 1.5, 1e-12);
  EXPECT_NEAR(length(into->direction), 1, 1e-12);
  EXPECT_LT(into->direction.z, 0);
  const auto reflected = bsdf.sample(viewer, false, 0.999, {});  // beyond the critical angle
  EXPECT_NEAR(reflected->direction.z, viewer.z, 1e-12);
  const double share = fresnel(0.6, 1.5);
  EXPECT_GT(bsdf.sample(viewer, true, 0.99 * share, {})->direction.z, 0);
  EXPECT_LT(bsdf.sample(viewer, true, 1.01 * share, {})->direction.z, 0);
}

TEST(Bsdf, RefusesNumbersOutOfRange) {
  const float nan = std::nanf("");
  for (const Material& bad : {glossy(-0.1f, 1), glossy(1.1f, 1), glossy(nan, 1), glossy(0.5f, 1.1f),
                              glossy(0.5f, -1), glossy(0.5f, nan)}) {
    EXPECT_THROW(Bsdf{bad}, std::invalid_argument);
  }
  Material bad_index;
  bad_index.index_of_refraction = 0.5f;
  EXPECT_THROW(Bsdf{bad_index}, std::invalid_argument);
}

}  // namespace
}  // namespace stbvh::harness
