/// load_embree_xml(): what it makes of files that are right.
#include "harness/scenes/embree_xml/embree_xml.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/harness/embree_xml_files.h"

namespace stbvh::harness {
namespace {

TEST_F(EmbreeXmlTest, TriangleMesh) {
  const Scene scene = load(R"(<PerspectiveCamera name="c" from="1 2 3" to="4 5 6" up="0 0 1" fov="33.5"/>
    <TriangleMesh name="roof"><positions>0 0 0 +1.0 0 0 <!-- 2 --> 0 1e0 0  .5 .5 1</positions>
    <normals>0 0 1 0 0 1 0 0 1 0 0 1</normals><texcoords>0 0 1 0 0 1 0 0</texcoords>
    <triangles>0 1 2  0 2 3</triangles></TriangleMesh>)");
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.name, "roof");
  EXPECT_EQ(mesh.indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  ASSERT_EQ(mesh.steps.size(), 1u);
  ASSERT_EQ(mesh.steps[0].size(), 4u);
  expect_at(mesh.steps[0][1], 1, 0, 0);
  expect_at(mesh.steps[0][3], 0.5f, 0.5f, 1);
  expect_at(scene.camera.position, 1, 2, 3);
  expect_at(scene.camera.target, 4, 5, 6);
  expect_at(scene.camera.up, 0, 0, 1);
  EXPECT_EQ(scene.camera.vertical_fov_degrees, 33.5f);
  EXPECT_EQ(scene.name, "s");
  EXPECT_TRUE(warnings.empty());
  EXPECT_FALSE(scene.environment);
}

TEST_F(EmbreeXmlTest, AnimatedPositionsAreSteps) {
  const Scene scene = load(R"(<TriangleMesh><animated_positions><positions>0 0 0 1 0 0 0 1 0</positions>
    <positions>0 0 1 1 0 1 0 1 1</positions><positions>0 0 4 1 0 4 0 1 4</positions></animated_positions>
    <triangles>0 1 2</triangles></TriangleMesh>
    <TriangleMesh><positions>0 0 0 1 0 0 0 1 0</positions><positions2>0 0 2 1 0 2 0 1 2</positions2>
    <triangles>0 1 2</triangles></TriangleMesh>)");
  ASSERT_EQ(scene.meshes.size(), 2u);
  ASSERT_EQ(scene.meshes[0].steps.size(), 3u);
  expect_at(scene.meshes[0].steps[2][1], 1, 0, 4);
  ASSERT_EQ(scene.meshes[1].steps.size(), 2u);
  expect_at(scene.meshes[1].steps[1][2], 0, 1, 2);
}

TEST_F(EmbreeXmlTest, BinaryArrays) {
  const std::string bytes =
      "four" + bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0.1f}) + bytes_of<std::uint32_t>({2, 0, 1});
  const std::string content =
      R"(<TriangleMesh><positions ofs="4" size="3"/><normals ofs="0" size="0"/><triangles ofs="40" size="1"/></TriangleMesh>)";
  for (const char* const name : {"s.bin", "s.xml.bin"}) {
    write(name, bytes);
    const Scene scene = load(content);
    EXPECT_EQ(scene.meshes[0].indices, (std::vector<std::uint32_t>{2, 0, 1}));
    EXPECT_EQ(scene.meshes[0].steps[0][2].z, 0.1f);
    fs::remove(folder / name);
  }
}

TEST_F(EmbreeXmlTest, QuadsAreSplitAsInEmbree) {
  const Scene scene = load(R"(<QuadMesh><positions>0 0 0 1 0 0 1 1 0 0 1 0</positions>
    <indices>0 1 2 3  0 1 2 2</indices></QuadMesh>)");
  EXPECT_EQ(scene.meshes[0].indices, (std::vector<std::uint32_t>{0, 1, 3, 2, 3, 1, 0, 1, 2}));
}

TEST_F(EmbreeXmlTest, MatricesAreWrittenRowByRow) {
  const Scene scene = load("<Transform><AffineSpace>1 2 3 4  5 6 7 8  9 10 11 12</AffineSpace>" + triangle() +
                           "</Transform>");
  const VertexBuffer& p = scene.meshes[0].steps[0];
  expect_at(p[0], 4, 8, 12);
  expect_at(p[1], 5, 13, 21);
  expect_at(p[2], 6, 14, 22);
}

TEST_F(EmbreeXmlTest, AttributesOfAffineSpaces) {
  const auto where = [&](const std::string& attributes) {
    return load("<Transform><AffineSpace " + attributes + "/>" + triangle("", "1 2 3 0 0 0 1 0 0") +
                "</Transform>")
        .meshes[0]
        .steps[0][0];
  };
  const auto expect_near = [](Vec3f p, float x, float y, float z) {
    EXPECT_NEAR(p.x, x, 1e-6f);
    EXPECT_NEAR(p.y, y, 1e-6f);
    EXPECT_NEAR(p.z, z, 1e-6f);
  };
  expect_near(where(R"(translate="10 20 30")"), 11, 22, 33);
  expect_near(where(R"(scale="2 3 4")"), 2, 6, 12);
  expect_near(where(R"(rotate_x="90")"), 1, -3, 2);
  expect_near(where(R"(rotate_y="90")"), 3, 2, -1);
  expect_near(where(R"(rotate_z="90")"), -2, 1, 3);
  expect_near(where(R"(axis="0 0 5" angle="90")"), -2, 1, 3);
  expect_near(where(R"(axis="0 0 5" angle="180" point="1 0 0")"), 1, -2, 3);
  expect_near(where(R"(axis="1 1 1" angle="120")"), 3, 1, 2);
}

TEST_F(EmbreeXmlTest, OuterTransformsComeLast) {
  const Scene scene =
      load(R"(<Transform><AffineSpace scale="2 2 2"/><Group><Transform><AffineSpace translate="1 0 0"/>)" +
           triangle() + "</Transform></Group></Transform>");
  expect_at(scene.meshes[0].steps[0][1], 4, 0, 0);
}

TEST_F(EmbreeXmlTest, UntouchedPositionsKeepTheirBits) {
  const Scene scene =
      load(triangle("", "0.1 -0 1.8439999e18  1e-45 1.17549435e-38 0.333333343  16777217 1 7e-46"));
  const VertexBuffer& p = scene.meshes[0].steps[0];
  EXPECT_EQ(p[0].x, 0.1f);
  EXPECT_TRUE(std::signbit(p[0].y));
  EXPECT_EQ(p[0].z, 1.8439999e18f);
  EXPECT_EQ(p[1].x, 1e-45f);
  EXPECT_EQ(p[2].x, 16777216.0f);
  EXPECT_EQ(p[2].z, 0.0f);
}

TEST_F(EmbreeXmlTest, TransformKeysBecomeSteps) {
  const Scene scene =
      load(R"(<TransformAnimation><AffineSpace translate="0 0 0"/><AffineSpace translate="10 0 0"/>
    <AffineSpace scale="3 3 3"/>)" +
           triangle() + "</TransformAnimation>");
  ASSERT_EQ(scene.meshes[0].steps.size(), 3u);
  expect_at(scene.meshes[0].steps[1][1], 11, 0, 0);
  expect_at(scene.meshes[0].steps[2][1], 3, 0, 0);
}

/// 3 keys over 4 steps: 6 segments. Between keys matrices are interpolated, not rotations.
TEST_F(EmbreeXmlTest, KeysOfTransformAndMeshAreAllSteps) {
  const Scene scene = load(R"(<TransformAnimation><AffineSpace scale="1 1 1"/><AffineSpace scale="3 1 1"/>
    <AffineSpace scale="1 1 5"/><TriangleMesh><animated_positions>
    <positions>1 0 0 0 0 1 0 0 0</positions><positions>4 0 0 0 0 1 0 0 0</positions>
    <positions>7 0 0 0 0 1 0 0 0</positions><positions>1 0 0 0 0 7 0 0 0</positions></animated_positions>
    <triangles>0 1 2</triangles></TriangleMesh></TransformAnimation>)");
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.steps.size(), 7u);
  // x of the mesh's vertex 0 at the common steps, and the scale of the transform.
  const float x[] = {1, 2.5f, 4, 5.5f, 7, 4, 1}, scale[] = {1, 5.f / 3, 7.f / 3, 3, 7.f / 3, 5.f / 3, 1};
  const float z[] = {1, 1, 1, 1, 1, 4, 7}, scale_z[] = {1, 1, 1, 1, 7.f / 3, 11.f / 3, 5};
  for (std::size_t i = 0; i < 7; ++i) {
    expect_at(mesh.steps[i][0], x[i] * scale[i], 0, 0);
    expect_at(mesh.steps[i][1], 0, 0, z[i] * scale_z[i]);
  }
}

TEST_F(EmbreeXmlTest, NestedMotionsMeetAtTheirKeys) {
  const Scene scene = load(R"(<TransformAnimation><AffineSpace scale="1 1 1"/><AffineSpace scale="2 2 2"/>
    <TransformAnimation><AffineSpace translate="0 0 0"/><AffineSpace translate="1 0 0"/><AffineSpace translate="4 0 0"/>)" +
                           triangle() + "</TransformAnimation></TransformAnimation>");
  ASSERT_EQ(scene.meshes[0].steps.size(), 3u);
  expect_at(scene.meshes[0].steps[0][0], 0, 0, 0);
  expect_at(scene.meshes[0].steps[1][0], 1.5f, 0, 0);
  expect_at(scene.meshes[0].steps[2][0], 8, 0, 0);
}

TEST_F(EmbreeXmlTest, SharedNodesAreInstanced) {
  const Scene scene = load(R"(<assign type="scene" id="a">)" + triangle() + R"(</assign>
    <assign type="scene"><Group id="pair"><ref id="a"/><Transform><AffineSpace translate="0 5 0"/><ref id="a"/></Transform>
    </Group></assign><ref id="pair"/><Transform><AffineSpace translate="7 0 0"/><ref id="pair"/></Transform>)");
  ASSERT_EQ(scene.meshes.size(), 4u);
  expect_at(scene.meshes[1].steps[0][0], 0, 5, 0);
  expect_at(scene.meshes[2].steps[0][0], 7, 0, 0);
  expect_at(scene.meshes[3].steps[0][0], 7, 5, 0);
}

TEST_F(EmbreeXmlTest, MultiTransformFromTheBinaryFile) {
  // Columns: the images of x, y, z, then the translation.
  write("s.bin", bytes_of<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 6, 7, 0, 2, 0, -2, 0, 0, 0, 0, 1, 0, 0, 0}));
  const Scene scene =
      load(R"(<MultiTransform><AffineSpace3f ofs="0" size="2"/>)" + triangle() + "</MultiTransform>");
  ASSERT_EQ(scene.meshes.size(), 2u);
  expect_at(scene.meshes[0].steps[0][1], 6, 6, 7);
  expect_at(scene.meshes[1].steps[0][1], 0, 2, 0);
  expect_at(scene.meshes[1].steps[0][2], -2, 0, 0);
}

TEST_F(EmbreeXmlTest, TimeRanges) {
  const std::string moving =
      R"(<TransformAnimation><AffineSpace translate="0 0 0"/><AffineSpace translate="1 0 0"/>)" + triangle() +
      "</TransformAnimation>";
  const Scene scene =
      load(moving + R"(<TimeRange time="-0.25 0.5">)" + moving +
           R"(</TimeRange><TimeRange time="0.5 2"><Flatten>)" + moving + "</Flatten></TimeRange>");
  ASSERT_EQ(scene.meshes.size(), 3u);
  EXPECT_EQ(scene.meshes[0].time_range.begin, 0.0f);
  EXPECT_EQ(scene.meshes[0].time_range.end, 1.0f);
  EXPECT_EQ(scene.meshes[1].time_range.begin, -0.25f);
  EXPECT_EQ(scene.meshes[1].time_range.end, 0.5f);
  EXPECT_EQ(scene.meshes[2].time_range.begin, 0.5f);
  EXPECT_EQ(scene.meshes[2].time_range.end, 2.0f);
}

/// Embree's loader changes the node itself; a flattened copy is another one.
TEST_F(EmbreeXmlTest, ATimeRangeReachesAllInstances) {
  const std::string shared =
      R"(<assign type="scene" id="a"><TriangleMesh><positions>0 0 0 1 0 0 0 1 0</positions>
    <positions2>0 0 1 1 0 1 0 1 1</positions2><triangles>0 1 2</triangles></TriangleMesh></assign>)";
  EXPECT_EQ(load(shared + R"(<ref id="a"/><TimeRange time="0 0.5"><ref id="a"/></TimeRange>)")
                .meshes[0]
                .time_range.end,
            0.5f);
  EXPECT_EQ(
      load(shared + R"(<ref id="a"/><TimeRange time="0 0.5"><Flatten><ref id="a"/></Flatten></TimeRange>)")
          .meshes[0]
          .time_range.end,
      1.0f);
}

TEST_F(EmbreeXmlTest, Materials) {
  const auto material = [&](const std::string& code, const std::string& parameters) {
    return load(triangle("<material><code>" + code + "</code><parameters>" + parameters +
                         "</parameters></material>"))
        .meshes[0]
        .material;
  };
  using Kind = Material::Kind;
  Material m = material("\"OBJ\"", R"(<float name="d">1</float><float3 name="Kd">0.9 0.3 0.2</float3>)");
  EXPECT_EQ(m.kind, Kind::kDiffuse);
  expect_at(m.color, 0.9f, 0.3f, 0.2f);
  m = material(
      "\"OBJ\"",
      R"(<float3 name="Kd">0 0 1</float3><float3 name="Ks">.04 .04 .04</float3><float name="Ns">198</float>)");
  EXPECT_EQ(m.kind, Kind::kGlossy);
  EXPECT_NEAR(m.index_of_refraction, 1.5f, 1e-5f);
  EXPECT_NEAR(m.roughness, 0.1f, 1e-6f);
  EXPECT_EQ(material("Matte", R"(<float3 name="reflectance">.1 .2 .3</float3>)").color.z, 0.3f);
  EXPECT_EQ(material("\"Mirror\"", "").kind, Kind::kMirror);
  EXPECT_EQ(material("\"Metal\"", R"(<float name="roughness">.5</float>)").kind, Kind::kMirror);
  m = material("\"Dielectric\"", R"(<float name="etaInside">1.33</float>)");
  EXPECT_EQ(m.kind, Kind::kGlass);
  EXPECT_EQ(m.index_of_refraction, 1.33f);
  EXPECT_EQ(material("\"ThinDielectric\"", "").index_of_refraction, 1.0f);
  m = material(
      "\"Plastic\"",
      R"(<param type="float3" name="pigmentColor">.1 .2 .3</param><float name="roughness">.25</float>)");
  EXPECT_EQ(m.kind, Kind::kGlossy);
  EXPECT_EQ(m.roughness, 0.25f);
  expect_at(m.color, 0.1f, 0.2f, 0.3f);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(material("\"Slime\"", "").kind, Kind::kDiffuse);
  EXPECT_TRUE(warned_of("Slime"));
  material("\"OBJ\"", R"(<texture3d name="map_Kd" src="x.png"/>)");
  EXPECT_TRUE(warned_of("Textures"));
}

TEST_F(EmbreeXmlTest, MaterialsAreKnownByTheirIds) {
  const Scene scene = load(
      R"(<assign type="material" id="red"><material><code>"Matte"</code><parameters>
    <float3 name="reflectance">1 0 0</float3></parameters></material></assign>)" +
      triangle(R"(<material id="red"/>)") +
      triangle(
          R"(<material id="7"><code>"Matte"</code><parameters><float3 name="reflectance">0 1 0</float3></parameters></material>)") +
      triangle(R"(<material id="7"/>)") + triangle(R"(<material id="8"/>)") +
      triangle(R"(<material id="9"/>)"));
  expect_at(scene.meshes[0].material.color, 1, 0, 0);
  expect_at(scene.meshes[2].material.color, 0, 1, 0);
  expect_at(scene.meshes[3].material.color, 0.7f, 0.7f, 0.7f);
  EXPECT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(
      warned_of(at("s.xml") + ": 2 materials are not defined, and read as diffuse grey: \"8\", \"9\""));
}

TEST_F(EmbreeXmlTest, Lights) {
  const Scene scene =
      load(triangle() + R"(<AmbientLight><L>1 2 3</L></AmbientLight><AmbientLight><L>1 1 1</L></AmbientLight>
    <Transform><AffineSpace>0 1 0 9  0 0 1 9  1 0 0 9</AffineSpace>
    <DirectionalLight><AffineSpace>1 0 5 0  0 1 6 0  0 0 7 0</AffineSpace><E>4 5 6</E></DirectionalLight></Transform>
    <DistantLight><AffineSpace>1 0 0 0 0 1 0 0 0 0 1 0</AffineSpace><L>1 2 4</L><halfAngle>30</halfAngle></DistantLight>
    <QuadLight><AffineSpace>2 0 0 1  0 3 0 0  0 0 1 0</AffineSpace><L>7 8 9</L></QuadLight>
    <TriangleLight><AffineSpace translate="0 0 1"/><L>1 1 1</L></TriangleLight>)");
  ASSERT_TRUE(scene.environment);
  expect_at(scene.environment->radiance, 2, 3, 4);
  ASSERT_EQ(scene.directional_lights.size(), 2u);
  expect_at(scene.directional_lights[0].direction, 6, 7, 5);
  expect_at(scene.directional_lights[0].irradiance, 4, 5, 6);
  EXPECT_EQ(scene.directional_lights[0].half_angle_degrees, 0);
  EXPECT_EQ(scene.directional_lights[1].half_angle_degrees, 30);
  // A disc of 30 degrees: pi sin^2 = pi / 4.
  EXPECT_NEAR(scene.directional_lights[1].irradiance.z, 3.14159265f, 1e-5f);
  ASSERT_EQ(scene.meshes.size(), 3u);
  const Mesh& quad = scene.meshes[1];
  EXPECT_EQ(quad.triangle_count(), 2u);
  expect_at(quad.material.emission, 7, 8, 9);
  expect_at(quad.steps[0][2], 3, 3, 0);
  expect_at(scene.meshes[2].steps[0][0], 1, 0, 1);
}

TEST_F(EmbreeXmlTest, WhatCannotBeShownIsNamed) {
  load(triangle() +
       R"(<Curves type="flat" basis="linear"/><Curves type="round" basis="bezier"/><Points type="sphere"/>
    <GridMesh id="g"/><ref id="g"/><PointLight/><SpotLight/><Nonsense/><TransformAnimation><Quaternion/></TransformAnimation>)");
  ASSERT_EQ(warnings.size(), 1u);
  for (const char* const part : {"2 <Curves>", "1 <Points>", "1 <GridMesh>", "1 <PointLight>",
                                 "1 <SpotLight>", "1 <Nonsense>", "Quaternion", "s.xml"}) {
    EXPECT_TRUE(warned_of(part)) << warnings[0];
  }
}

TEST_F(EmbreeXmlTest, TheFirstCameraCountsAndMovesWithTransforms) {
  const Scene scene = load(triangle() + R"(<Transform><AffineSpace translate="0 0 5"/>
    <PerspectiveCamera name="a" from="0 0 8" to="0 0 0" up="0 1 0" fov="10"/></Transform>
    <PerspectiveCamera name="b" from="0 0 9" to="0 0 0" up="0 1 0" fov="20"/>)");
  expect_at(scene.camera.position, 0, 0, 13);
  expect_at(scene.camera.target, 0, 0, 5);
  expect_at(scene.camera.up, 0, 1, 0);
}

TEST_F(EmbreeXmlTest, CommandLists) {
  write_scene(triangle() + R"(<PerspectiveCamera name="a" from="0 0 8" to="0 0 0" up="0 1 0" fov="10"/>
    <PerspectiveCamera name="b" from="0 0 9" to="0 0 0" up="0 1 0" fov="20"/>)");
  Scene scene = load_file(
      write("l.ecs",
            "-i s.xml\n#-vp 9 9 9\n-vp 1 2 3 -vi -1 -2 -.5 --vu 0 0 1 # up\n--righthanded --shader uv\n"
            "--size 10 20 -dirlight 1 -1 1 3 3 3 --ambientlight 1 .5 0 --fov 60"));
  expect_at(scene.camera.position, 1, 2, 3);
  expect_at(scene.camera.target, -1, -2, -0.5f);
  expect_at(scene.camera.up, 0, 0, 1);
  EXPECT_EQ(scene.camera.vertical_fov_degrees, 60);
  ASSERT_EQ(scene.directional_lights.size(), 1u);
  expect_at(scene.directional_lights[0].direction, 1, -1, 1);
  expect_at(scene.environment.value().radiance, 1, 0.5f, 0);
  EXPECT_TRUE(warned_of("--shader, --size"));
  scene = load_file(write("m.ecs", "-i s.xml -i s.xml --camera b -vp 1 1 1 -vd 0 0 -1"));
  EXPECT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.camera.vertical_fov_degrees, 20);
  expect_at(scene.camera.target, 1, 1, 0);
  EXPECT_TRUE(warnings.empty());
}

TEST_F(EmbreeXmlTest, CommandListsMayHaveBlanksInQuotes) {
  write("sub dir/d #1.xml", read_file(write_scene(triangle())));
  write_scene(triangle() + R"(<PerspectiveCamera name="a b" from="0 0 8" to="0 0 0" up="0 1 0" fov="10"/>)");
  const Scene scene =
      load_file(write("l.ecs", "-i \"sub dir/d #1.xml\" # \"\n-i \"s.xml\" --camera \"a b\"#"));
  EXPECT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.camera.vertical_fov_degrees, 10);
  EXPECT_TRUE(warnings.empty());
  EXPECT_NE(
      refusal_of(write("l.ecs", "-i \"sub dir\n-i s.xml")).find("the quote before sub dir is not closed"),
      std::string::npos);
}

/// Paths are relative to the list that they stand in; later words have the last word.
TEST_F(EmbreeXmlTest, CommandListsMayNameOthers) {
  write_scene(triangle());
  write("a/b/t.xml", read_file(write_scene(triangle())));
  write("a/b/deep.ecs", "-i t.xml -vp 1 2 3 -ambientlight 1 1 1 --shader uv -animlist frames.txt");
  write("a/inner.ecs", "-c b/deep.ecs -i ../s.xml -vp 4 5 6");
  const Scene scene =
      load_file(write("l.ecs", "-fov 20 -c a/inner.ecs -i s.xml -ambientlight 1 2 3 -c a/b/deep.ecs"));
  EXPECT_EQ(scene.meshes.size(), 4u);
  EXPECT_EQ(scene.camera.vertical_fov_degrees, 20);
  expect_at(scene.camera.position, 1, 2, 3);
  expect_at(scene.environment.value().radiance, 3, 4, 5);
  EXPECT_EQ(warnings.size(), 2u);
  EXPECT_TRUE(warned_of("left out: --shader, --shader."));
  EXPECT_TRUE(warned_of("-animlist is left out: its files are frames that follow each other"));
}

TEST_F(EmbreeXmlTest, CommandListsThatNameOthersForEver) {
  write_scene(triangle());
  EXPECT_EQ(refusal_of(write("l.ecs", "-i s.xml -c l.ecs")),
            ": \"" + at("l.ecs") + "\" names itself with -c");
  write("x/a.ecs", "-c ../x/../l.ecs");
  EXPECT_NE(refusal_of(write("l.ecs", "-i s.xml -c x/a.ecs")).find("l.ecs\" names itself with -c"),
            std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i s.xml -c none.ecs"))
                .find("none.ecs\", which it names with -c, does not exist"),
            std::string::npos);
  write("bad.ecs", "-fov 200");
  EXPECT_NE(refusal_of(write("l.ecs", "-i s.xml -c bad.ecs")).find("bad.ecs\": -fov must be above 0"),
            std::string::npos);
  // Each names the next twice: 2^60.
  for (int i = 0; i < 60; ++i) {
    const std::string next = std::to_string(i + 1) + ".ecs";
    write(std::to_string(i) + ".ecs", std::string("-c ").append(next).append(" -c ").append(next));
  }
  write("60.ecs", "-i s.xml");
  EXPECT_NE(refusal_of(folder / "0.ecs").find("it names more than 100 lists"), std::string::npos);
}

TEST_F(EmbreeXmlTest, CommandListsMayNameObjFiles) {
  write("w.mtl", "newmtl red\nKd 1 0 0\n");
  write("w.obj",
        "mtllib w.mtl\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nusemtl red\nf 1 2 3 4 5 6\n"
        "usemtl none\nf 1 2 3\n");
  write_scene(triangle());
  const Scene scene = load_file(write("l.ecs", "\xEF\xBB\xBF-i w.obj -i s.xml\n-vp 1 2 3 -vi 0 0 0 -fov 37"));
  ASSERT_EQ(scene.meshes.size(), 3u);
  EXPECT_EQ(scene.meshes[0].triangle_count(), 4u);
  EXPECT_EQ(scene.meshes[0].material.color.x, 1);
  EXPECT_EQ(scene.meshes[0].material.color.y, 0);
  EXPECT_EQ(scene.meshes[1].material.color.x, Material{}.color.x);
  EXPECT_EQ(scene.camera.vertical_fov_degrees, 37);
  expect_at(scene.camera.position, 1, 2, 3);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warned_of(at("w.obj") + ": 1 material is not defined, and read as diffuse grey: \"none\""));
}

TEST_F(EmbreeXmlTest, MaterialsThatAreMissingTakeOneLine) {
  std::string meshes;
  for (const std::string id : {"a", "b", "c", "d", "e", "f", "g", "a"}) {
    meshes += "<TriangleMesh><material id=\"" + id +
              "\"/><positions>0 0 0 1 0 0 0 1 0</positions><triangles>0 1 2</triangles></TriangleMesh>";
  }
  const Scene scene = load(meshes);
  ASSERT_EQ(scene.meshes.size(), 8u);
  EXPECT_EQ(scene.meshes[0].material.color.x, Material{}.color.x);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0], at("s.xml") +
                             ": 7 materials are not defined, and read as diffuse grey: "
                             "\"a\", \"b\", \"c\", \"d\", \"e\" and 2 more");
}

TEST_F(EmbreeXmlTest, CommandListsWithCarriageReturnsAndHashesInNames) {
  write_scene(triangle());
  for (const int step : {1, 2})
    write("w_" + std::to_string(step) + ".obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Scene scene = load_file(write("l.ecs", "# first\r-i s.xml\r-i w_##.obj\r-fov 37 # -fov 50\r"));
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[1].steps.size(), 2u);
  EXPECT_EQ(scene.camera.vertical_fov_degrees, 37);
}

TEST_F(EmbreeXmlTest, ByteOrderMarks) {
  const std::string text = "<?xml version=\"1.0\"?>\n<scene>" + triangle() + "\n</scene>";
  EXPECT_EQ(load_file(write("s.xml", "\xEF\xBB\xBF" + text)).triangle_count(), 1u);
  std::string wide = "\xFF\xFE", broken = wide;
  for (const char c : text) {
    wide.push_back(c);
    wide.push_back('\0');
  }
  EXPECT_EQ(load_file(write("s.xml", wide)).triangle_count(), 1u);
  EXPECT_NE(refusal_of(write("s.xml", wide.substr(0, 100))).find(": it is not XML: "), std::string::npos);
}

TEST_F(EmbreeXmlTest, TrianglesThatAreNotFiniteAreLeftOutAndCounted) {
  for (const char* const bad : {"nan", "+inf", "-1e39", "2e18", "1e400", "1.#INF", "-1.#IND", "-nan(ind)"}) {
    const std::string positions = std::string("0 0 0 1 0 0 0 1 0 1 1 ") + bad;
    const Scene scene = load("<TriangleMesh name=\"a\"><positions>" + positions +
                             "</positions><triangles>0 1 2 1 3 2</triangles></TriangleMesh>");
    ASSERT_EQ(scene.meshes.size(), 1u) << bad;
    EXPECT_EQ(scene.triangle_count(), 1u) << bad;
    EXPECT_LT(scene.bounds().upper.z, 1) << bad;
    ASSERT_EQ(warnings.size(), 1u) << bad;
    EXPECT_TRUE(warned_of(at("s.xml") + ": 1 triangle is left out")) << warnings[0];
    EXPECT_TRUE(warned_of("1 of 2 in \"a\"")) << warnings[0];
    // Where it is moved by transforms, and from key to key.
    const Scene moved =
        load("<TransformAnimation><AffineSpace scale=\"1 1 1\"/><AffineSpace scale=\"2 2 2\"/>" + triangle() +
             triangle("", positions.substr(12) + " 0 0 0") + "</TransformAnimation>");
    EXPECT_EQ(moved.triangle_count(), 1u) << bad;
    EXPECT_EQ(warnings.size(), 1u) << bad;
  }
  const Scene far =
      load(triangle() + "<Transform><AffineSpace scale=\"1e30 1 1\"/>" + triangle() + "</Transform>");
  EXPECT_EQ(far.triangle_count(), 1u);
  EXPECT_EQ(warnings.size(), 1u);
  // Of a cage, the surface near the vertex.
  const Scene cage = load(
      "<SubdivisionMesh><positions>0 0 0 1 0 0 2 0 0 3 0 0 4 0 0 0 1 0 1 1 0 2 1 0 3 1 0 4 1 nan</positions>"
      "<position_indices>0 1 6 5 1 2 7 6 2 3 8 7 3 4 9 8</position_indices><faces>4 4 4 4</faces>"
      "</SubdivisionMesh>");
  EXPECT_EQ(cage.triangle_count(), 2u * 64 * 2);
  EXPECT_EQ(warnings.size(), 1u);
}

/// A cage of the unit square and what else stands in it, beside a triangle.
std::string square_cage(const std::string& indices, const std::string& faces, const std::string& more = "") {
  return triangle() + "<SubdivisionMesh><positions>0 0 0 1 0 0 1 1 0 0 1 0</positions>" + indices +
         "<faces>" + faces + "</faces>" + more + "</SubdivisionMesh>";
}

const std::string kQuad = "<position_indices>0 1 2 3</position_indices>";

TEST_F(EmbreeXmlTest, CagesThatShowNothingAreLeftOutAndCounted) {
  const std::string no_boundary = R"(<position_indices subdiv_mode="no_boundary">0 1 2 3</position_indices>)";
  const std::string point = "<position_indices>0 0 0 0</position_indices>";
  for (const std::string& scene :
       {square_cage(kQuad, "4", "<holes>0</holes>"), square_cage(no_boundary, "4")}) {
    EXPECT_EQ(load(scene).meshes.size(), 1u);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0], at("s.xml") + ": left out: cages without a face to show: 1.");
  }
  EXPECT_EQ(load(square_cage(point, "4") + square_cage(kQuad, "4", "<holes>0</holes>")).meshes.size(), 2u);
  EXPECT_TRUE(warned_of("cages without a face to show: 2."));
  EXPECT_TRUE(warned_of("faces of cages with fewer than three corners, or one corner twice: 1."));
  const fs::path alone = write_scene(square_cage(no_boundary, "4").substr(triangle().size()));
  EXPECT_EQ(refusal_of(alone),
            ": nothing in it can be shown: there are no triangles, quads or cages to be seen");
}

TEST_F(EmbreeXmlTest, WhatIsDegenerateInACageIsLeftOutAndCounted) {
  const Mesh sound = load(square_cage(kQuad, "4")).meshes.at(1);
  EXPECT_TRUE(warnings.empty());
  const auto expect_sound = [&](const std::string& scene, const std::string& told) {
    const Mesh mesh = load(scene).meshes.at(1);
    EXPECT_EQ(mesh.indices, sound.indices);
    EXPECT_TRUE(same_bits(mesh.steps.at(0), sound.steps.at(0)));
    EXPECT_EQ(warnings, (std::vector<std::string>{at("s.xml") + ": left out: " + told})) << scene;
    return mesh;
  };
  const auto indices = [](const std::string& numbers) {
    return "<position_indices>" + numbers + "</position_indices>";
  };
  const std::string faces = "faces of cages with fewer than three corners, or one corner twice: ";
  expect_sound(square_cage(indices("0 1 2 3 0 1 1 2"), "4 4"), faces + "1.");
  expect_sound(square_cage(indices("0 1 2 3 0 1"), "4 2"), faces + "1.");
  // Numbers of faces, in holes and in hits, are those of the file.
  const Mesh last =
      expect_sound(square_cage(indices("0 2 0  1  0 1 2 3"), "3 1 4", "<holes>1 0</holes>"), faces + "2.");
  EXPECT_EQ(last.faces.front(), 2u);
  EXPECT_EQ(last.faces.back(), 2u);
  const std::string creases =
      "<edge_creases>0 2 1 3</edge_creases><edge_crease_weights>1 2</edge_crease_weights>";
  expect_sound(square_cage(kQuad, "4", creases), "creases of cages where no edge is: 2.");
  // The edge of a face that is gone is none.
  load(square_cage(indices("0 1 2 3 0 2 2"), "4 3", creases));
  EXPECT_TRUE(warned_of("creases of cages where no edge is: 2."));
  EXPECT_TRUE(warned_of(faces + "1."));
  // What Embree refuses is refused.
  const auto refused = [&](const std::string& scene, const std::string& because) {
    EXPECT_NE(refusal_of(write_scene(scene)).find(because), std::string::npos)
        << refusal_of(folder / "s.xml");
  };
  refused(square_cage(kQuad, "4", "<holes>1</holes>"), "face 1 of the cage is a hole, but there are only 1");
  refused(square_cage(kQuad, "4", "<edge_creases>0 1</edge_creases>"), "has fewer weights than creases");
  refused(square_cage(indices("0 1 2 3 0 4 4"), "4 3"), "has the index 4, but only 4 vertices");
  refused(square_cage(kQuad, "5"), "more corners than the 4 that are given");
  refused(
      square_cage(kQuad, "4", "<edge_creases>0 9</edge_creases><edge_crease_weights>1</edge_crease_weights>"),
      "a crease of the cage has vertex 9");
}

TEST_F(EmbreeXmlTest, TimeRangesThatEmbreeCannotBuildOverAreLeftOut) {
  const std::string moving =
      "<TriangleMesh name=\"m\"><positions>0 0 0 1 0 0 0 1 0</positions>"
      "<positions2>0 0 1 1 0 1 0 1 1</positions2><triangles>0 1 2</triangles></TriangleMesh>";
  for (const char* const time :
       {"0 1e-39", "0 1e-45", "-1e-45 1e-45", "-3e38 3e38", "0 1e38", "1 2", "-1 0", "2 3"}) {
    const Scene scene = load(triangle() + "<TimeRange time=\"" + time + "\">" + moving + "</TimeRange>");
    EXPECT_EQ(scene.meshes.size(), 1u) << time;
    EXPECT_TRUE(warned_of("are left out: \"m\".")) << time;
  }
  for (const char* const time : {"0 0.001", "-1 2", "0.999 1", "0.25 0.5"}) {
    const Scene scene = load(triangle() + "<TimeRange time=\"" + time + "\">" + moving + "</TimeRange>");
    EXPECT_EQ(scene.meshes.size(), 2u) << time;
    EXPECT_TRUE(warnings.empty()) << time;
  }
}

TEST_F(EmbreeXmlTest, EmissionIsOurWord) {
  const Scene scene =
      load(triangle(R"(<material><code>"OBJ"</code><parameters><float3 name="Kd">0 0 0</float3>
    <float3 name="emission">1 2 3</float3></parameters></material>)"));
  expect_at(scene.meshes[0].material.emission, 1, 2, 3);
}

}  // namespace
}  // namespace stbvh::harness
