/// load_embree_xml(): files that are broken, or ask for what is not possible. All are refused with a
/// sentence.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <string>

#include "tests/harness/embree_xml_files.h"

namespace stbvh::harness {
namespace {

class EmbreeXmlRefusal : public EmbreeXmlTest {};

const std::string kMoving = R"(<animated_positions><positions>0 0 0 1 0 0 0 1 0</positions>
  <positions>0 0 1 1 0 1 0 1 1</positions></animated_positions><triangles>0 1 2</triangles>)";

/// `count` keys of a transform.
std::string keys(std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i)
    text += "<AffineSpace translate=\"" + std::to_string(i) + " 0 0\"/>";
  return text;
}

TEST_F(EmbreeXmlRefusal, WhatIsNoSceneFile) {
  EXPECT_NE(refusal_of(folder / "none.xml").find("it does not exist"), std::string::npos);
  EXPECT_NE(refusal_of(folder).find("neither an .xml nor an .obj file"), std::string::npos);
  fs::create_directory(folder / "d.xml");
  EXPECT_NE(refusal_of(folder / "d.xml").find("not a regular file"), std::string::npos);
  EXPECT_NE(refusal_of(write("e.xml", "")).find("not XML"), std::string::npos);
  EXPECT_NE(refusal_of(write("e.xml", "{}")).find("not XML"), std::string::npos);
  EXPECT_NE(refusal_of(write("e.xml", "<scene>\n\n</szene>")).find("line 3"), std::string::npos);
  EXPECT_NE(refusal_of(write("e.xml", "<BGFscene/>")).find("<BGFscene>, not <scene>"), std::string::npos);
}

TEST_F(EmbreeXmlRefusal, NothingToShow) {
  expect_refused("", "nothing in it can be shown");
  expect_refused("<Curves/><GridMesh/>", "nothing in it can be shown");
  EXPECT_TRUE(warned_of("<Curves>"));
  expect_refused("<TriangleMesh/>", "nothing in it can be shown");
  expect_refused(R"(<assign type="scene" id="a">)" + triangle() + "</assign>", "nothing in it can be shown");
}

TEST_F(EmbreeXmlRefusal, Arrays) {
  expect_refused(triangle("", "0 0 0 1 0 0 0 1"), "not a multiple of 3");
  expect_refused(triangle("", "0 0 0 1 0 x 0 1 0"), "has \"x\" among its numbers");
  expect_refused(triangle("", "0 0 0 1 0 0"), "has the index 2, but only 2 vertices");
  expect_refused("<TriangleMesh><positions>0 0 0</positions><triangles>0 0 -1</triangles></TriangleMesh>",
                 "\"-1\"");
  expect_refused(
      "<TriangleMesh><positions>0 0 0</positions><triangles>0 0 4294967296</triangles></TriangleMesh>",
      "4294967296");
  expect_refused("<TriangleMesh><triangles>0 1 2</triangles></TriangleMesh>", "has no positions");
  expect_refused("<TriangleMesh><animated_positions/><triangles>0 1 2</triangles></TriangleMesh>",
                 "has no positions");
  expect_refused("<QuadMesh><positions>0 0 0</positions><indices>0 0 0</indices></QuadMesh>",
                 "not a multiple of 4");
  expect_refused(
      R"(<TriangleMesh><animated_positions><positions>0 0 0 1 0 0 0 1 0</positions><positions>0 0 0</positions>
    </animated_positions><triangles>0 1 2</triangles></TriangleMesh>)",
      "3 positions in its first step and 1 in another");
  std::string many = "<TriangleMesh><animated_positions>";
  for (int i = 0; i < 130; ++i) many += "<positions>0 0 0</positions>";
  expect_refused(many + "</animated_positions><triangles>0 0 0</triangles></TriangleMesh>",
                 "more than 129 steps");
}

TEST_F(EmbreeXmlRefusal, BinaryFiles) {
  const auto mesh = [](const std::string& where) {
    return "<TriangleMesh><positions " + where + "/><triangles>0 1 2</triangles></TriangleMesh>";
  };
  expect_refused(mesh(R"(ofs="0" size="3")"), "there is neither");
  write("s.bin", std::string(36, '\0'));
  expect_refused(mesh(R"(ofs="0" size="4")"), "has only 36 bytes");
  expect_refused(mesh(R"(ofs="1" size="3")"), "has only 36 bytes");
  expect_refused(mesh(R"(ofs="37" size="1")"), "has only 36 bytes");
  expect_refused(mesh(R"(ofs="0" size="1537228672809129302")"), "has only 36 bytes");
  expect_refused(mesh(R"(ofs="18446744073709551615" size="18446744073709551615")"), "has only 36 bytes");
  expect_refused(mesh(R"(ofs="-1" size="3")"), "not a number");
  expect_refused(mesh(R"(ofs="0" size="3x")"), "not a number");
  expect_refused(mesh(R"(ofs="0")"), "not a number");
  write("s.bin", std::string(36, '\xff'));
  expect_refused(mesh(R"(ofs="0" size="3")"), "nothing in it can be shown");
  EXPECT_TRUE(warned_of("s.xml: 1 triangle is left out, with vertices that are not finite"));
  const std::string first_bytes = mesh(R"(ofs="0" size="3")");
  fs::resize_file(at("s.bin"), std::uintmax_t{100} << 30);
  expect_refused(first_bytes, "s.bin\" has 107374182400 bytes, but at most 25769803776 are read");
  fs::remove(at("s.bin"));
  fs::create_directory(at("s.bin"));
  expect_refused(first_bytes, "s.bin\" is not a regular file");
  fs::remove(at("s.bin"));
  ASSERT_EQ(mkfifo(at("s.bin").c_str(), 0600), 0);
  expect_refused(first_bytes, "s.bin\" is not a regular file");
  fs::remove(at("s.bin"));
  fs::create_symlink(at("s.bin"), at("s.bin"));
  expect_refused(first_bytes, "s.bin\" cannot be read: Too many levels of symbolic links");
}

TEST_F(EmbreeXmlRefusal, FilesThatCannotBeRead) {
  for (const std::string name : {"a.xml", "a.ecs"}) {
    fs::resize_file(write(name, ""), std::uintmax_t{100} << 30);
    EXPECT_NE(refusal_of(folder / name).find("it has 107374182400 bytes, but at most "), std::string::npos);
    fs::remove(folder / name);
    ASSERT_EQ(mkfifo(at(name).c_str(), 0600), 0);
    EXPECT_NE(refusal_of(folder / name).find("it is not a regular file"), std::string::npos);
    fs::remove(folder / name);
    fs::create_symlink(at(name), at(name));
    EXPECT_NE(refusal_of(folder / name).find("it cannot be read: Too many levels of symbolic links"),
              std::string::npos);
  }
}

/// Too deep for a recursion: each is refused before, or does not recurse.
TEST_F(EmbreeXmlRefusal, NestedElements) {
  constexpr std::size_t kLevels = 40'000;
  const auto nested = [](const std::string& begin, const std::string& content, const std::string& end) {
    std::string text;
    for (std::size_t i = 0; i < kLevels; ++i) text += begin;
    text += content;
    for (std::size_t i = 0; i < kLevels; ++i) text += end;
    return text;
  };
  const auto refused = [&](const std::string& begin, const std::string& end) {
    expect_refused(nested(begin, triangle(), end), ", line 3: its elements are nested more than 200 deep");
  };
  refused(R"(<assign type="scene" id="a">)", "</assign>");
  refused("<Group>", "</Group>");
  refused("<Flatten>", "</Flatten>");
  refused(R"(<TimeRange time="0 1">)", "</TimeRange>");
  refused(R"(<Transform><AffineSpace scale="1 1 1"/>)", "</Transform>");
  refused(R"(<TransformAnimation><AffineSpace scale="1 1 1"/>)", "</TransformAnimation>");
  refused("<AnimatedLight>", "</AnimatedLight>");
  refused(R"(<Group><assign type="scene" id="a">)", "</assign></Group>");
  for (const char* const name : {"material", "parameters", "code", "positions", "AffineSpace", "unknown"}) {
    const std::string tag(name);
    const std::string content = nested("<" + tag + ">", "", "</" + tag + ">");
    refusal_of(write_scene(triangle() + triangle(content) + content));
    refusal_of(write_scene(triangle() + R"(<assign type="material" id="m">)" + content + "</assign>"));
  }
}

TEST_F(EmbreeXmlRefusal, References) {
  expect_refused(R"(<ref id="a"/><assign type="scene" id="a">)" + triangle() + "</assign>",
                 "not defined before it");
  expect_refused(R"(<Group id="a">)" + triangle() + R"(<ref id="a"/></Group>)", "not defined before it");
  expect_refused(R"(<assign type="scene" id="a"><Group><ref id="b"/></Group></assign>
    <assign type="scene" id="b"><Group><ref id="a"/></Group></assign>)",
                 "\"b\", which is not defined before it");
  expect_refused(R"(<assign type="picture" id="a"/>)", "neither");
}

TEST_F(EmbreeXmlRefusal, TooMuchOfIt) {
  // Sixty generations of twins, above a triangle and above nothing.
  for (const std::string& seed : {triangle(), std::string("<Group/>")}) {
    std::string text = R"(<assign type="scene" id="g0">)" + seed + "</assign>";
    for (int i = 1; i <= 60; ++i) {
      const std::string below = "<ref id=\"g" + std::to_string(i - 1) + "\"/>";
      text += "<assign type=\"scene\" id=\"g" + std::to_string(i) + "\"><Group>" + below + below +
              "</Group></assign>";
    }
    expect_refused(text + R"(<TimeRange time="0 1"><ref id="g60"/></TimeRange>)",
                   seed == "<Group/>" ? "nothing in it" : "more than 1000000 instances");
  }
  std::string deep, end;
  for (int i = 0; i < 100000; ++i) {
    deep += "<Group>";
    end += "</Group>";
  }
  expect_refused(deep + triangle() + end, "nested more than 200 deep");
  std::string chain = R"(<assign type="scene" id="g0">)" + triangle() + "</assign>";
  for (int i = 1; i <= 2000; ++i)
    chain += "<assign type=\"scene\" id=\"g" + std::to_string(i) + "\"><Group><ref id=\"g" +
             std::to_string(i - 1) + "\"/></Group></assign>";
  expect_refused(chain, "nested more than 500 deep");
}

TEST_F(EmbreeXmlRefusal, Motion) {
  expect_refused("<TransformAnimation>" + keys(130) + triangle() + "</TransformAnimation>",
                 "more than 129 keys");
  expect_refused("<TransformAnimation>" + keys(50) + "<TransformAnimation>" + keys(4) + triangle() +
                     "</TransformAnimation></TransformAnimation>",
                 "148 common steps");
  expect_refused("<TransformAnimation>" + keys(128) + "<TransformAnimation>" + keys(128) + "<TriangleMesh>" +
                     kMoving + "</TriangleMesh></TransformAnimation></TransformAnimation>" + "<Transform/>",
                 "does not begin with an <AffineSpace>");
  expect_refused(R"(<TimeRange time="0 0.5"><TransformAnimation>)" + keys(2) + "<TriangleMesh>" + kMoving +
                     "</TriangleMesh></TransformAnimation></TimeRange>",
                 "another time range");
  expect_refused(R"(<TransformAnimation>)" + keys(2) + R"(<TimeRange time="0 0.5"><TransformAnimation>)" +
                     keys(2) + triangle() + "</TransformAnimation></TimeRange></TransformAnimation>",
                 "another time range");
  for (const char* const time : {"1 0", "0 0", "0", "nan 1", "0 inf", ""})
    expect_refused("<TimeRange time=\"" + std::string(time) + "\">" + triangle() + "</TimeRange>",
                   "<TimeRange>");
  expect_refused("<Transform>" + triangle() + "</Transform>", "does not begin with an <AffineSpace>");
  expect_refused("<Transform><AffineSpace>1 2 3</AffineSpace>" + triangle() + "</Transform>",
                 "not a multiple of 12");
  expect_refused("<Transform><AffineSpace/>" + triangle() + "</Transform>", "has 0 numbers");
  expect_refused(R"(<Transform><AffineSpace axis="0 0 0" angle="1"/>)" + triangle() + "</Transform>",
                 "without length");
  expect_refused(R"(<Transform><AffineSpace scale="1e30 1 1"/><Transform><AffineSpace scale="1e30 1 1"/>)" +
                     triangle() + "</Transform></Transform>",
                 "nothing in it can be shown");
  EXPECT_TRUE(warned_of("too far away"));
}

TEST_F(EmbreeXmlRefusal, LightsAndCameras) {
  expect_refused("<AmbientLight/>" + triangle(), "needs three numbers");
  expect_refused("<AmbientLight><L>1 nan 1</L></AmbientLight>" + triangle(), "needs three numbers");
  expect_refused("<AmbientLight><L>1 -1 1</L></AmbientLight>" + triangle(), "needs three numbers");
  expect_refused(
      "<DirectionalLight><AffineSpace>1 0 0 0 0 1 0 0 0 0 0 0</AffineSpace><E>1 1 1</E></DirectionalLight>" +
          triangle(),
      "no direction");
  expect_refused(
      R"(<DistantLight><AffineSpace scale="1 1 1"/><L>1 1 1</L><halfAngle>0</halfAngle></DistantLight>)" +
          triangle(),
      "halfAngle");
  expect_refused(R"(<PerspectiveCamera from="0 0 1" to="0 0 0" up="0 1 0" fov="180"/>)" + triangle(),
                 "180 degrees");
  expect_refused(R"(<PerspectiveCamera from="0 0" to="0 0 0" up="0 1 0" fov="18"/>)" + triangle(),
                 "not 3 numbers");
  expect_refused(R"(<PerspectiveCamera from="0 0 0" to="0 0 0" fov="18"/>)" + triangle(), "up");
  expect_refused(R"(<PerspectiveCamera from="0 0 2e18" to="0 0 0" up="0 1 0" fov="18"/>)" + triangle(),
                 "the from of a <PerspectiveCamera> is too far away");
  expect_refused(R"(<PerspectiveCamera from="0 0 5" to="0 0 0" up="0 0 1" fov="18"/>)" + triangle(),
                 "its camera has no up, or one along its view");
  expect_refused(R"(<PerspectiveCamera from="0 0 5" to="0 0 0" up="0 0 0" fov="18"/>)" + triangle(),
                 "its camera has no up, or one along its view");
  expect_refused(R"(<PerspectiveCamera from="0 0 5" to="0 0 5" up="0 1 0" fov="18"/>)" + triangle(),
                 "its camera does not look anywhere");
  expect_refused(R"(<Transform><AffineSpace translate="1e30 0 0"/>
      <PerspectiveCamera from="0 0 1" to="0 0 0" up="0 1 0" fov="18"/></Transform>)" +
                     triangle(),
                 "moves a camera too far away");
  expect_refused("<QuadLight><AffineSpace translate=\"0 2e18 0\"/><L>1 1 1</L></QuadLight>" + triangle(),
                 "a <QuadLight> is too far away");
}

TEST_F(EmbreeXmlRefusal, CommandLists) {
  write_scene(triangle());
  EXPECT_NE(refusal_of(write("l.ecs", "")).find("names no scene file"), std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i none.xml")).find("it does not exist"), std::string::npos)
      << "of another file";
  EXPECT_NE(refusal_of(write("l.ecs", "-i none.obj")).find("there is no such file"), std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i s.ply")).find("neither an .xml nor an .obj file"),
            std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i l.ecs")).find("neither an .xml nor an .obj file"),
            std::string::npos);
  const std::string wide("\xFF\xFE-\0i\0 \0", 8);
  EXPECT_NE(refusal_of(write("l.ecs", wide)).find("it is UTF-16 text, not UTF-8"), std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i s.xml -vp 1e30 0 0")).find("-vp is too far away"),
            std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i")).find("lacks its argument"), std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i s.xml -vp 1 2")).find("-vp lacks"), std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i s.xml -vp 1 2 nan")).find("-vp lacks"), std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i s.xml -fov 200")).find("-fov"), std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "-i s.xml --camera none")).find("no camera named"), std::string::npos);
  EXPECT_NE(refusal_of(write("l.ecs", "s.xml")).find("where an option should"), std::string::npos);
}

/// Cut off anywhere, a file is refused or a smaller scene: nothing else happens. Likewise with a byte
/// changed.
TEST_F(EmbreeXmlRefusal, NoBytesCrash) {
  const std::string whole = R"(<?xml version="1.0"?>
<scene><PerspectiveCamera name="a" from="0 0 8" to="0 0 0" up="0 1 0" fov="45"/><AmbientLight><L>1 1 1</L></AmbientLight>
<DistantLight><AffineSpace>1 0 0 0 0 1 0 0 0 0 1 0</AffineSpace><L>1 2 4</L><halfAngle>30</halfAngle></DistantLight>
<assign type="scene" id="a"><TriangleMesh name="m"><material id="1"><code>"OBJ"</code><parameters><float3 name="Kd">1 0 0</float3>
</parameters></material>)" + kMoving +
                            R"(</TriangleMesh></assign><TimeRange time="0 0.5"><Flatten><TransformAnimation>
<AffineSpace rotate_x="3"/><AffineSpace scale="1 2 3"/><Group><ref id="a"/><QuadLight><AffineSpace translate="1 2 3"/><L>1 2 3</L></QuadLight>
</Group></TransformAnimation></Flatten></TimeRange><QuadMesh><positions ofs="0" size="4"/><indices ofs="48" size="1"/></QuadMesh>
<MultiTransform><AffineSpace3f ofs="0" size="1"/><ref id="a"/></MultiTransform></scene>)";
  const std::string binary =
      bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) + bytes_of<std::uint32_t>({0, 1, 2, 3});
  write("s.bin", binary);
  EXPECT_EQ(load_file(write("s.xml", whole)).meshes.size(), 4u);
  const auto try_file = [&] { return refusal_of(folder / "s.xml").empty(); };
  std::size_t refused = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    write("s.xml", whole.substr(0, whole.size() * i / 200));
    refused += try_file() ? 0u : 1u;
  }
  EXPECT_EQ(refused, 200u);  // the root element is never closed
  constexpr char kOthers[] = {'\0', ' ', '<', '>', '"', '-', '9', 'e', '/', '\xff'};
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string changed = whole;
    changed[at] = kOthers[(at * 7) % sizeof(kOthers)];
    write("s.xml", changed);
    refused += try_file() ? 0u : 1u;
  }
  EXPECT_GT(refused, 400u);
  write("s.xml", whole);
  for (std::size_t size = 0; size < binary.size(); ++size) {
    write("s.bin", binary.substr(0, size));
    EXPECT_FALSE(try_file()) << size;
  }
  for (std::size_t bit = 0; bit < 8 * binary.size(); ++bit) {
    std::string changed = binary;
    changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
    write("s.bin", changed);
    try_file();
  }
}

}  // namespace
}  // namespace stbvh::harness
