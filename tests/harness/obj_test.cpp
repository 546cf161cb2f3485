/// OBJ files and sequences: what they mean, and how those that mean nothing are refused.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "harness/scenes/moving_triangle.h"
#include "harness/scenes/obj/mtl_file.h"
#include "harness/scenes/obj/obj.h"
#include "harness/scenes/obj/obj_file.h"
#include "harness/scenes/obj/obj_sequence.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

using Indices = std::vector<std::uint32_t>;
using Sentences = std::vector<std::string>;

constexpr std::string_view kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

class ObjTest : public TemporaryFolderTest {
 protected:
  ObjFile parse(std::string_view text) const { return read_obj_file(write("file.obj", text)); }

  /// A triangle at height z.
  void write_step(const std::string& name, int z) const {
    const std::string h = std::to_string(z);
    write(name, "v 0 0 " + h + "\nv 1 0 " + h + "\nv 0 1 " + h + "\nf 1 2 3\n");
  }
};

/// What is said; empty if nothing is wrong. One line.
std::string refusal(const std::function<void()>& read) {
  try {
    read();
  } catch (const SceneFileError& error) {
    EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos) << error.what();
    return error.what();
  }
  return {};
}

TEST_F(ObjTest, PositionsAndFacesInAllTheirForms) {
  const ObjFile file = parse(
      "# a comment v 9 9 9\r\nmtllib x.mtl\r\no thing\r\n"
      "v 0.1 -1e-3 +16777216\r\n\tv\t1 2 3 0.5   # weight\r\nv 4 5 6 1 0 0\r\nv 7 8 9\r\nv -.5 1. 2\r\n"
      "vt 0 0\nvn 0 0 1\ng group\ns off\nusemtl red\n"
      "f 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 4//1\nf 1/1/1 2/1/1 5/1/1\n"
      "f -5 -4 -1\nf 1 2 \\\n  3 \\  # go on\r\n 4\nf 1 2 3 4 5\n f 6 1 2\nv 3 3 3");
  ASSERT_EQ(file.positions.size(), 6u);
  EXPECT_EQ(file.positions[0].x, 0.1f);
  EXPECT_EQ(file.positions[0].y, -1e-3f);
  EXPECT_EQ(file.positions[0].z, 16777216.f);
  EXPECT_EQ(file.positions[1].z, 3.f);
  EXPECT_EQ(file.positions[2].y, 5.f);
  EXPECT_EQ(file.positions[4].x, -0.5f);
  EXPECT_EQ(file.positions[5].x, 3.f);
  EXPECT_EQ(file.face_sizes, (Indices{3, 3, 3, 3, 3, 4, 5, 3}));
  EXPECT_EQ(file.corners, (Indices{0, 1, 2, 0, 1, 2, 0, 1, 3, 0, 1, 4, 0, 1, 4,  //
                                   0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 0, 1}));
  ASSERT_EQ(file.material_runs.size(), 1u);
  EXPECT_EQ(file.material_runs[0].name, "red");
  EXPECT_EQ(file.material_runs[0].first_face, 0u);
  EXPECT_EQ(file.material_libraries, std::vector<std::string>{"x.mtl"});
}

TEST_F(ObjTest, BrokenLinesAreRefusedWithTheirNumber) {
  const std::string good(kTriangle);
  const std::vector<std::pair<std::string, std::string>> cases{
      {"v a b c\n" + good, "line 1: \"a\" is not a number"},
      {good + "v 1 2\n", "line 5: a vertex has 2 numbers"},
      {good + "v 1 2 3 4 5 6 7 8\n", "line 5: a vertex has more than 7"},
      {good + "v 1,5 0 0\n", "\"1,5\" is not a number"},
      {good + "v 0 0 +\n", "\"+\" is not a number"},
      {good + "f 1 2\n", "line 5: a face has 2 corners"},
      {good + "f 1 2 0\n", "line 5: \"0\" is not a corner"},
      {good + "f 1 2 x\n", "\"x\" is not a corner"},
      {good + "f 1 2 3.5\n", "\"3.5\" is not a corner"},
      {good + "f 1 2 3/x\n", "\"3/x\" is not a corner"},
      {good + "f 1 2 /3\n", "\"/3\" is not a corner"},
      {good + "f 1///// 2 3\n", "\"1/////\" is not a corner"},
      {good + "f 1/- 2 3\n", "\"1/-\" is not a corner"},
      {good + "f 1/1/1/1 2 3\n", "\"1/1/1/1\" is not a corner"},
      {good + "f 1/1.5 2 3\n", "\"1/1.5\" is not a corner"},
      {good + "v +-1 0 0\n", "\"+-1\" is not a number"},
      {good + "v 0 0 1#z\n", "\"1#z\" is not a number"},
      {good + "f 1 2 99999999999999999999\n", "is not a corner"},
      {good + "f 1 2 9999999999\n", "there is no vertex 9999999999"},
      {good + "f 1 2 -4\n", "vertex -4 is meant, but there are only 3 so far"},
      {good + "f 1 \\\n2 \\\n4\nf 1 2 3\n", "line 5: vertex 4 is meant, but there are only 3"},
      {"f 1 1 1\n", "line 1: vertex 1 is meant, but there are only 0"},
      {"v 0 0 0\n", "it has no faces"},
      {"v 0 0 0\nl 1 1\np 1\nl 1 1 1\n", "it has no faces, only 2 \"l\", 1 \"p\""},
      {"", "it has no faces"},
      {"\\", "it has no faces"},
      {std::string("\x01\xFF\\\n\\"), "it has no faces"},
      {good + '\0', "it has bytes of 0, as UTF-16 and binary files do: it is not UTF-8 text"}};
  for (const auto& [text, because] : cases) {
    const std::string said = refusal([&] { parse(text); });
    EXPECT_NE(said.find(because), std::string::npos) << "said: " << said << "\nshould say: " << because;
    EXPECT_TRUE(said.starts_with(at("file.obj") + ": ")) << said;
  }
  EXPECT_NE(refusal([&] { read_obj_file(folder); }).find("not a regular file"), std::string::npos);
  EXPECT_NE(refusal([&] { read_obj_file(folder / "none.obj"); }).find("it does not exist"),
            std::string::npos);
}

TEST_F(ObjTest, LinesMayEndInCarriageReturns) {
  std::string text = "# a comment\nv 0 0 0\nv 1 0 0 # another\nv 0 1 \\\n2\nf 1 2 3\n";
  std::replace(text.begin(), text.end(), '\n', '\r');
  const ObjFile file = parse(text);
  ASSERT_EQ(file.positions.size(), 3u);
  EXPECT_EQ(file.positions[2].z, 2);
  EXPECT_EQ(file.corners, (Indices{0, 1, 2}));
  const auto said = refusal([&] { parse(text + "f 1 2 x\r"); });
  EXPECT_EQ(said, at("file.obj") + ": line 7: \"x\" is not a corner of a face");
}

TEST_F(ObjTest, NamesKeepTheirHashes) {
  const ObjFile file = parse(
      "mtllib Library #1.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl Material #25 \t\r\nf 1 2 3 # a face\n"
      "usemtl\tM#26\nf 1 2 3\nusemtl  a \\\n #b\nf 1 2 3\n");
  ASSERT_EQ(file.material_runs.size(), 3u);
  EXPECT_EQ(file.material_runs[0].name, "Material #25");
  EXPECT_EQ(file.material_runs[1].name, "M#26");
  EXPECT_EQ(file.material_runs[2].name, "a   #b");
  EXPECT_EQ(file.material_libraries, std::vector<std::string>{"Library #1.mtl"});
}

TEST_F(ObjTest, TruncatedFilesNeverCrash) {
  const std::string text = "v 0.25 0 -1e-3\nv 1 0 0\nv 0 1 0 # c\nf 1/1/1 \\\n -2//1 3\nf 1 2 3 -1\n";
  std::size_t read = 0;
  for (std::size_t size = 0; size <= text.size(); ++size) {
    const std::string cut = text.substr(0, size);
    read += refusal([&] { parse(cut); }).empty() ? 1u : 0u;
  }
  EXPECT_GT(read, 5u);
  EXPECT_LT(read, text.size() / 2);
}

void expect_refused(const std::string& name, const std::string& because, std::size_t number_step = 1) {
  const std::string said = refusal([&] { load_obj(name, {}, number_step); });
  EXPECT_NE(said.find(because), std::string::npos) << "said: " << said << "\nshould say: " << because;
}

std::vector<float> heights(const Scene& scene) {
  std::vector<float> z;
  for (const VertexBuffer& step : scene.meshes.at(0).steps) z.push_back(step[0].z);
  return z;
}

TEST_F(ObjTest, SequencesAreSortedByTheirNumbers) {
  for (const int number : {8, 9, 10, 11}) {
    write_step("plain/walk_" + std::to_string(number) + ".obj", number);
    write_step("padded/run." + std::string(number < 10 ? "000" : "00") + std::to_string(number) + ".OBJ",
               number);
  }
  write_step("plain/walk_8.obj.bak", 77);
  write_step("plain/walk_x.obj", 77);
  const Scene plain = load_obj(at("plain/walk_%d.obj"));
  EXPECT_EQ(heights(plain), (std::vector<float>{8, 9, 10, 11}));
  EXPECT_EQ(plain.name, "walk");
  EXPECT_EQ(plain.meshes[0].indices, (Indices{0, 1, 2}));
  for (const char* const pattern :
       {"walk_%04d.obj", "walk_####.obj", "walk_#.obj", "walk_$F.obj", "walk_$F4.obj"}) {
    const Scene same = load_obj(at("plain/") + pattern);
    EXPECT_EQ(heights(same), (std::vector<float>{8, 9, 10, 11})) << pattern;
    EXPECT_EQ(same.name, "walk");
  }
  const Scene padded = load_obj(at("padded/"));
  EXPECT_EQ(heights(padded), (std::vector<float>{8, 9, 10, 11}));
  EXPECT_EQ(padded.name, "padded");
  EXPECT_EQ(heights(load_obj(at("padded/run.%04d.OBJ"))), (std::vector<float>{8, 9, 10, 11}));
  EXPECT_EQ(heights(load_obj(at("padded/run.0009.OBJ"))), (std::vector<float>{9}));
  write_step("alone/still.obj", 5);
  EXPECT_TRUE(load_obj(at("alone")).meshes[0].is_static());
}

TEST_F(ObjTest, NumbersMayBeNegative) {
  for (const int number : {-2, -1, 0, 1}) {
    write_step("a/w_" + std::to_string(number) + ".obj", number);
    write_step("b/w." + std::string(number < 0 ? "-00" : "000") + std::to_string(std::abs(number)) + ".obj",
               number);
  }
  for (const char* const name : {"a", "a/w_%d.obj", "a/w_#.obj", "b", "b/w.%04d.obj", "b/w.$F4.obj"})
    EXPECT_EQ(heights(load_obj(at(name))), (std::vector<float>{-2, -1, 0, 1})) << name;
  write_step("dash/w-1.obj", 1);
  write_step("dash/w-2.obj", 2);
  EXPECT_EQ(heights(load_obj(at("dash"))), (std::vector<float>{1, 2}));
}

TEST_F(ObjTest, SequencesOnTwos) {
  for (const int number : {-1, 1, 3}) write_step(std::string("w") + std::to_string(number) + ".obj", number);
  EXPECT_EQ(heights(load_obj(at("w%d.obj"), {}, 2)), (std::vector<float>{-1, 1, 3}));
  expect_refused(at("w%d.obj"),
                 "number 0 of the sequence is missing, between w-1.obj and w1.obj (with --step 2");
  expect_refused(at("w%d.obj"), "w1.obj: its number is only 2 more than that of w-1.obj, not 4", 4);
  write_step("w2.obj", 2);
  expect_refused(at("w%d.obj"), "w2.obj: its number is only 1 more than that of w1.obj, not 2", 2);
}

TEST_F(ObjTest, PatternsMayHaveSignsThatAreNoNumber) {
  for (const int number : {1, 2}) {
    for (const char* const before : {"a/50%_", "b/a#1_", "c/$Fx", "d/100%d_", "e/#", "e/50%%_"})
      write_step(before + std::to_string(number) + ".obj", number);
  }
  for (const auto& [pattern, name] :
       {std::pair{"a/50%_%d.obj", "50%"}, std::pair{"a/50%%_%03d.obj", "50%"},
        std::pair{"a/50%_#.obj", "50%"}, std::pair{"a/50%%_$F4.obj", "50%"}, std::pair{"b/a#1_%d.obj", "a#1"},
        std::pair{"c/$Fx%d.obj", "$Fx"}, std::pair{"d/100%%d_%d.obj", "100%d"}, std::pair{"e/#%d.obj", "#"},
        std::pair{"e/50%%%%_%d.obj", "50%%"}}) {
    const Scene scene = load_obj(at(pattern));
    EXPECT_EQ(heights(scene), (std::vector<float>{1, 2})) << pattern;
    EXPECT_EQ(scene.name, name) << pattern;
  }
  for (const char* const name : {"w_%d.obj", "a#1.obj", "50%%.obj"}) {  // of files that are there
    write_step(std::string("literal/") + name, 5);
    const Scene scene = load_obj(at(std::string("literal/") + name));
    EXPECT_EQ(heights(scene), (std::vector<float>{5})) << name;
    EXPECT_EQ(scene.name + ".obj", name);
  }
}

TEST_F(ObjTest, NothingIsLeftOutSilently) {
  write_step("hidden/w1.obj", 1);
  write_step("hidden/w2.obj", 2);
  write("hidden/._w1.obj", "macOS");
  write("hidden/.w3.obj", "v");
  std::vector<std::string> said;
  const Scene scene = load_obj(at("hidden"), [&](const std::string& sentence) { said.push_back(sentence); });
  EXPECT_EQ(heights(scene), (std::vector<float>{1, 2}));
  EXPECT_EQ(said, std::vector<std::string>{at("hidden") + ": hidden files are left out: ._w1.obj, .w3.obj"});
  expect_refused(at("hidden/.w1.obj"), "no such file");
  write_step("all_hidden/.w1.obj", 1);
  write_step("all_hidden/._w2.obj", 1);
  expect_refused(at("all_hidden"),
                 "the folder has no .obj files but hidden ones, which are left out: ._w2.obj, .w1.obj");
  write_step("case/w1.obj", 1);
  write_step("case/w2.OBJ", 2);
  EXPECT_EQ(heights(load_obj(at("case/w%d.obj"))), (std::vector<float>{1, 2}));
  write_step("case/w02.obj", 2);
  expect_refused(at("case/w%d.obj"), "w02.obj and " + at("case/w2.OBJ") + " have the same number");
  fs::remove(at("case/w02.obj"));
  for (const char* const odd : {"w1.5.obj", "w2b.obj", "w+3.obj", "w99999999999999999999.obj"}) {
    write_step(std::string("case/") + odd, 3);
    expect_refused(at("case/w%d.obj"), std::string(odd) + ": \"");
    fs::remove(folder / "case" / odd);
  }
  write_step("odd/a#1.obj", 5);
  EXPECT_EQ(heights(load_obj(at("odd/a#1.obj"))), (std::vector<float>{5}));
}

TEST_F(ObjTest, SequencesThatAreNoneAreRefused) {
  for (const int number : {1, 2, 4}) write_step("gap/w" + std::to_string(number) + ".obj", number);
  expect_refused(at("gap/w%d.obj"), "number 3 of the sequence is missing, between w2.obj and w4.obj");
  expect_refused(at("gap"), "number 3 of the sequence is missing");
  write_step("twice/w1.obj", 1);
  write_step("twice/w01.obj", 1);
  expect_refused(at("twice"), "have the same number");
  write_step("mixed/a1.obj", 1);
  write_step("mixed/b2.obj", 1);
  expect_refused(at("mixed"), "belongs to another sequence");
  write_step("named/a.obj", 1);
  write_step("named/b2.obj", 1);
  expect_refused(at("named"), "there is no number in its name");
  for (std::size_t i = 0; i < kMaxSceneSteps + 1; ++i) write_step("long/w" + std::to_string(i) + ".obj", 1);
  expect_refused(at("long"), "130 files, but at most 129 steps");
  expect_refused(at("long/w%d.obj"), "130 files, but at most 129 steps");
  fs::remove(at("long/w129.obj"));
  EXPECT_EQ(load_obj(at("long")).meshes[0].steps.size(), kMaxSceneSteps);
  fs::create_directories(folder / "empty");
  expect_refused(at("empty"), "has no .obj files");
  expect_refused(at("gap/v%d.obj"), "there is no such file");
  expect_refused(at("none/w%d.obj"), "the folder cannot be read");
  expect_refused(at("none.obj"), "there is no such file");
  for (const char* name : {"w%s.obj", "w%d_%d.obj", "w%d_%d#.obj", "w#_$F.obj", "w%%d.obj", "w%.obj",
                           "w%99999d.obj", "100%.obj"})
    expect_refused(at(name), "one number in its name");
}

TEST_F(ObjTest, ByteOrderMarks) {
  const std::string good(kTriangle);
  const ObjFile file = parse("\xEF\xBB\xBF" + good);
  EXPECT_EQ(file.positions.size(), 3u);
  EXPECT_EQ(file.corners, (Indices{0, 1, 2}));
  const auto refusal_of_wide = [&](std::string text, bool is_little_endian) {
    for (const char c : good) {
      if (!is_little_endian) text.push_back('\0');
      text.push_back(c);
      if (is_little_endian) text.push_back('\0');
    }
    return refusal([&] { parse(text); });
  };
  const std::string because = at("file.obj") + ": it is UTF-16 text, not UTF-8";
  EXPECT_EQ(refusal_of_wide("\xFF\xFE", true), because);
  EXPECT_EQ(refusal_of_wide("\xFE\xFF", false), because);
}

TEST_F(ObjTest, FilesThatCannotBeReadAreRefused) {
  fs::resize_file(write("large.obj", ""), std::uintmax_t{100} << 30);
  expect_refused(at("large.obj"), "large.obj: it has 107374182400 bytes, but at most 4294967296 are read");
  ASSERT_EQ(mkfifo(at("pipe.obj").c_str(), 0600), 0);
  expect_refused(at("pipe.obj"), "pipe.obj: it is not a regular file");
  fs::create_symlink(folder / "b.obj", folder / "a.obj");
  fs::create_symlink(folder / "a.obj", folder / "b.obj");
  expect_refused(at("a.obj"), "a.obj: it cannot be read: Too many levels of symbolic links");
}

class ObjScene : public ObjTest {
 protected:
  Scene load(std::string_view text) {
    said.clear();
    return load_obj(write("file.obj", text), [&](const std::string& sentence) { said.push_back(sentence); });
  }
  std::vector<std::string> said;
};

TEST_F(ObjScene, TrianglesThatAreNotFiniteAreLeftOutAndCounted) {
  for (const char* const bad :
       {"nan", "-inf", "1e39", "-1e999", "2e18", "1.#INF", "-1.#IND", "1.#QNAN", "-nan(ind)"}) {
    const Scene scene = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 " + std::string(bad) + "\nf 1 2 3\nf 2 4 3\n");
    ASSERT_EQ(scene.meshes.size(), 1u) << bad;
    EXPECT_EQ(scene.meshes[0].indices, (Indices{0, 1, 2})) << bad;
    EXPECT_EQ(scene.meshes[0].faces, (Indices{0})) << bad;
    EXPECT_LT(scene.bounds().upper.z, 1) << bad;
    ASSERT_EQ(said.size(), 1u) << bad;
    EXPECT_TRUE(said[0].starts_with(at("file.obj"))) << said[0];
    EXPECT_NE(said[0].find("1 of 2 in \"file\""), std::string::npos) << said[0];
  }
  expect_refused(write("all.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "nothing in it can be shown");
  EXPECT_EQ(load("v 1e-999 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").meshes[0].steps[0][0].x, 0);
}

TEST_F(ObjScene, FacesThatAreNotFiniteInTheFirstFileAreLeftOutWhole) {
  const std::string others = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
  const std::string faces = "f 2 3 4 5 6 7 1\nf 1 2 4 6\n";
  const auto load_sequence = [&](const char* first, const char* second) {
    said.clear();
    write("s1.obj", others + "v " + first + " 0.5 0\n" + faces);
    write("s2.obj", others + "v " + second + " 0.5 0\n" + faces);
    return load_obj(at("s%d.obj"), [&](const std::string& sentence) { said.push_back(sentence); });
  };
  const Scene scene = load_sequence("nan", "0");
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("5 of 7 in \"s\""), std::string::npos) << said[0];
  EXPECT_EQ(scene.meshes[0].faces, (Indices{1, 1}));
  ASSERT_EQ(scene.meshes[0].steps.size(), 2u);
  // One that is bad later is known in shape: the triangles that have its corner are left out.
  const Scene later = load_sequence("0", "nan");
  ASSERT_EQ(said.size(), 1u);
  ASSERT_GT(later.triangle_count(), 2u);
  for (std::size_t t = 0; t + 2 < later.triangle_count(); ++t) {
    const auto p = triangle_at(later.meshes[0], t, {});
    EXPECT_GE(cross(p[1] - p[0], p[2] - p[0]).z, 0) << t;
  }
}

TEST_F(ObjScene, ConcaveFacesAreCoveredOnce) {
  const Scene scene =
      load("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 2 3 4 5 6 1\nf 5 6 1 2 3 4\n");
  EXPECT_TRUE(said.empty());
  ASSERT_EQ(scene.triangle_count(), 8u);
  double area = 0;
  for (std::size_t t = 0; t < 8; ++t) {
    const auto p = triangle_at(scene.meshes[0], t, {});
    const double doubled = cross(p[1] - p[0], p[2] - p[0]).z;
    EXPECT_GT(doubled, 0);
    area += doubled / 2;
  }
  EXPECT_EQ(area, 6);
  EXPECT_EQ(scene.meshes[0].faces, (Indices{0, 0, 0, 0, 1, 1, 1, 1}));
}

TEST_F(ObjScene, FacesOfMoreThanOneMeaningAreTold) {
  load("v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\nf 1 2 3 4\nf 1 2 3 4\nf 1 2 3\n");
  ASSERT_EQ(said.size(), 1u);
  EXPECT_TRUE(said[0].starts_with(at("file.obj") + ": faces that are not flat: 2;")) << said[0];
  load("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n");
  ASSERT_EQ(said.size(), 1u);
  EXPECT_TRUE(said[0].starts_with(at("file.obj") + ": faces that cross themselves: 1;")) << said[0];
  load("v 0 0 0\nv 1 1 0\nv 2 2 0\nv 2 0 0\nv 0 3 0\nf 1 2 3 4 2 5\nf 1 4 3 1 4 3 5\nf 1 4 3 5\n");
  ASSERT_EQ(said.size(), 1u);
  EXPECT_TRUE(said[0].starts_with(at("file.obj") + ": faces that cross themselves: 2;")) << said[0];
}

TEST_F(ObjScene, FacesAreCutAsInTheFirstFile) {
  const std::string faces = "v 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n";
  write("s1.obj", "v 1.5 1.5 0\n" + faces);
  write("s2.obj", "v 0 0 0\n" + faces);
  const Scene scene = load_obj(at("s%d.obj"));
  ASSERT_EQ(scene.meshes[0].steps.size(), 2u);
  EXPECT_EQ(scene.meshes[0].indices, load_obj(at("s1.obj")).meshes[0].indices);
  write("t1.obj", "v 0 0 0\nv 2 0 0\nv 1.5 1.5 0\nv 0 2 0\nf 2 3 4 1\n");
  write("t2.obj", "v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nf 2 3 4 1\n");
  EXPECT_EQ(load_obj(at("t%d.obj")).meshes[0].indices, (Indices{1, 2, 3, 1, 3, 0}));
  EXPECT_NE(load_obj(at("t2.obj")).meshes[0].indices, (Indices{1, 2, 3, 1, 3, 0}));
}

TEST_F(ObjScene, MaterialsOfLibraries) {
  write("a b.mtl",
        "\xEF\xBB\xBFnewmtl red wall\nKa 20 20 20\nKd 1 0 0\nKs 0 0 0\n\nnewmtl lamp\nKd 0.5\nKe 3 2 "
        "1\nmap_Kd x.png\n"
        "newmtl coat\nKd 0 1 0\nKs 0.04 0.04 0.04\nNs 100\nd 0.5\n");
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  const Scene scene = load("mtllib a b.mtl\n" + vertices +
                           "usemtl red wall\nf 2 3 4\nusemtl lamp\nf 1 2 3\nusemtl red wall\nf 1 2 4\n"
                           "usemtl coat\nf 1 3 4\nusemtl none\nf 3 2 1\n");
  ASSERT_EQ(scene.meshes.size(), 4u);
  const Mesh &red = scene.meshes[0], &lamp = scene.meshes[1], &coat = scene.meshes[2];
  EXPECT_EQ(red.name, "red wall");
  EXPECT_EQ(red.indices, (Indices{0, 1, 2, 3, 0, 2}));
  EXPECT_EQ(red.steps[0].size(), 4u);
  EXPECT_EQ(red.steps[0][1].y, 1);
  EXPECT_EQ(red.material.color.x, 1);
  EXPECT_EQ(red.material.color.y, 0);
  EXPECT_EQ(red.material.emission.x, 0);
  EXPECT_EQ(lamp.steps[0].size(), 3u);
  EXPECT_EQ(lamp.material.color.z, 0.5f);
  EXPECT_EQ(lamp.material.emission.y, 2);
  EXPECT_EQ(coat.material.kind, Material::Kind::kGlossy);
  EXPECT_NEAR(coat.material.index_of_refraction, 1.5f, 1e-6f);
  EXPECT_EQ(scene.meshes[3].material.color.x, Material{}.color.x);
  EXPECT_EQ(said.size(), 3u);  // textures, opaque, not defined
  const Scene plain = load("mtllib none.mtl\n" + vertices + "usemtl red\nf 1 2 3\n");
  EXPECT_EQ(plain.meshes[0].steps[0].size(), 4u);
  EXPECT_EQ(said, Sentences{at("file.obj") + ": materials of 1 library are read as diffuse grey: " +
                            at("none.mtl") + ": it does not exist"});
}

TEST_F(ObjScene, LibrariesWithHashesInNames) {
  const auto text = "newmtl Material #25\rKd 1 0 0\rnewmtl Material #26\rKd 0 1 0\r";
  write("Lib #1.mtl", text);
  write("my lib.mtl", text);
  for (const char* const library : {"Lib #1.mtl", "my lib.mtl # a comment"}) {
    const Scene scene = load("mtllib " + std::string(library) +
                             "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl Material #25\nf 1 2 3\n"
                             "usemtl Material #26\nf 1 3 2\n");
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.meshes[0].material.color.x, 1);
    EXPECT_EQ(scene.meshes[1].material.color.y, 1);
    EXPECT_EQ(said, Sentences{});
  }
}

TEST_F(ObjScene, OddValuesCostOnlyThemselves) {
  const std::string faces = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 2\n";
  const auto load_with = [&](const std::string& line) {
    write("m.mtl", "newmtl a\nKd 1 0.5 0.25\n" + line + "\nnewmtl b\nKd 0 1 0\n");
    Scene scene = load(faces);
    EXPECT_EQ(scene.meshes.at(0).material.color.y, 0.5f) << line;
    EXPECT_EQ(scene.meshes.at(1).material.color.y, 1) << line;
    return scene.meshes[0].material;
  };
  for (const char* const line : {"d -halo 1", "d 1", "Tr 0", "Ke 1e-46 0 0", "Ks 1e-999", "illum 3"}) {
    EXPECT_EQ(load_with(line).kind, Material::Kind::kDiffuse) << line;
    EXPECT_EQ(said, Sentences{}) << line;
  }
  EXPECT_EQ(load_with("Ks +0.5 +.5 0.5").kind, Material::Kind::kGlossy);
  EXPECT_EQ(said, Sentences{});
  for (const char* const line : {"d -halo 0.66", "d 0", "Tr 0.1"}) {
    load_with(line);
    EXPECT_EQ(said, Sentences{kReadAsOpaque}) << line;
  }
  for (const char* const line :
       {"map_Kd x.png", "map_Bump x", "bump x.png", "disp x.png", "decal a.png", "refl r", "norm n.png"}) {
    load_with(line);
    EXPECT_EQ(said, Sentences{kTexturesLeftOut}) << line;
  }
  for (const char* const line :
       {"Kd spectral f.rfl 1", "Kd xyz 0.3 0.3 0.3", "Kd nan", "Kd 1 0.5 1.#INF", "Kd 1 x 0", "Kd 1 0",
        "Kd 0,5", "Ke -nan(ind)", "Ns 1e400", "Ns", "d", "d -halo", "Tr"}) {
    EXPECT_EQ(load_with(line).emission.x, 0);
    EXPECT_EQ(said,
              Sentences{at("m.mtl") + ": left out, as they are not finite numbers, or no RGB: 1 value: \"" +
                        line + "\" in line 3"});
  }
  load_with("d\nNs x\nTr\n\nd\nd\nd\nd");
  EXPECT_EQ(said,
            Sentences{at("m.mtl") + ": left out, as they are not finite numbers, or no RGB: 7 values: "
                                    "\"d\" in line 3, \"Ns x\" in line 4, \"Tr\" in line 5, \"d\" in line 7, "
                                    "\"d\" in line 8 and 2 more"});
}

TEST_F(ObjScene, ShapesThatAreNoFacesAreCounted) {
  const Scene scene = load(std::string(kTriangle) +
                           "l 1 2\np 1\ndeg 3\ncstype bezier\nsurf 0 1 0 1 1 2 3 1\nend\nbzp 1 2 3\n"
                           "call other.obj\nfo 1 3 2\nl 2 3\n");
  EXPECT_EQ(scene.meshes.at(0).indices, (Indices{0, 1, 2, 0, 2, 1}));
  EXPECT_EQ(said, Sentences{at("file.obj") + ": left out, as only faces are read: 1 \"bzp\", 1 \"call\", "
                                             "2 \"l\", 1 \"p\", 1 \"surf\""});
}

TEST_F(ObjScene, WhatIsMissingTakesOneLine) {
  write("m.mtl", "newmtl a\nd\n");
  std::string text = "mtllib m.mtl\nmtllib m1.mtl m.mtl m1.mtl\n";  // each is read once
  for (const char c : std::string_view("123456")) text += std::string("mtllib m") + c + ".mtl\n";
  text += "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char c : std::string_view("1234567")) text += std::string("usemtl c") + c + "\nf 1 2 3\n";
  EXPECT_EQ(load(text).meshes.size(), 7u);
  ASSERT_EQ(said.size(), 3u);
  EXPECT_TRUE(said[0].starts_with(at("m.mtl") + ": left out")) << said[0];
  EXPECT_TRUE(said[1].starts_with(at("file.obj") + ": materials of 6 libraries are read as diffuse grey: " +
                                  at("m1.mtl") + ": it does not exist, "))
      << said[1];
  EXPECT_TRUE(said[1].ends_with(at("m5.mtl") + ": it does not exist and 1 more")) << said[1];
  EXPECT_EQ(said[2], at("file.obj") +
                         ": 7 materials are not defined, and read as diffuse grey: "
                         "\"c1\", \"c2\", \"c3\", \"c4\", \"c5\" and 2 more");
}

TEST_F(ObjTest, StepsWithOtherTopologyAreRefused) {
  const std::string good(kTriangle);
  const std::vector<std::pair<std::string, std::string>> cases{
      {good + "v 2 2 2\n", "s2.obj: it has 4 vertices, but"},
      {good + "f 1 2 3\n", "s2.obj: it has 2 faces, but"},
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 3 2\n", "s2.obj: its face 0 has other corners than in"},
      {"v 0 0 0\nv 1 0 0\nv 0 1\nf 1 2 3\n", "s2.obj: line 3: a vertex has 2 numbers"}};
  write("s1.obj", good);
  for (const auto& [text, because] : cases) {
    write("s2.obj", text);
    expect_refused(at("s%d.obj"), because);
  }
}

}  // namespace
}  // namespace stbvh::harness
