/// OBJ files and sequences: what they mean, and how those that mean nothing are refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "harness/scenes/obj/obj_file.h"
#include "harness/scenes/obj/obj_sequence.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

using Indices = std::vector<std::uint32_t>;

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
  EXPECT_EQ(file.indices, (Indices{0, 1, 2, 0, 1, 2, 0, 1, 3, 0, 1, 4, 0, 1, 4, 0, 1,
                                   2, 0, 2, 3, 0, 1, 2, 0, 2, 3, 0, 3, 4, 5, 0, 1}));
}

TEST_F(ObjTest, BrokenLinesAreRefusedWithTheirNumber) {
  const std::string good(kTriangle);
  const std::vector<std::pair<std::string, std::string>> cases{
      {"v a b c\n" + good, "line 1: \"a\" is not a number"},
      {good + "v 1 2\n", "line 5: a vertex has 2 numbers"},
      {good + "v 1 2 3 4 5 6 7 8\n", "line 5: a vertex has more than 7"},
      {good + "v nan 0 0\n", "\"nan\" is not a number that a float can hold"},
      {good + "v 0 inf 0\n", "\"inf\" is not a number that a float can hold"},
      {good + "v 1e39 0 0\n", "\"1e39\" is not a number that a float can hold"},
      {good + "v 1e999 0 0\n", "\"1e999\" is not a number that a float can hold"},
      {good + "v 1,5 0 0\n", "\"1,5\" is not a number"},
      {good + "v 0 0 +\n", "\"+\" is not a number"},
      {good + "f 1 2\n", "line 5: a face has 2 corners"},
      {good + "f 1 2 0\n", "line 5: \"0\" is not a corner"},
      {good + "f 1 2 x\n", "\"x\" is not a corner"},
      {good + "f 1 2 3.5\n", "\"3.5\" is not a corner"},
      {good + "f 1 2 3/x\n", "\"3/x\" is not a corner"},
      {good + "f 1 2 /3\n", "\"/3\" is not a corner"},
      {good + "f 1 2 99999999999999999999\n", "is not a corner"},
      {good + "f 1 2 9999999999\n", "there is no vertex 9999999999"},
      {good + "f 1 2 -4\n", "vertex -4 is meant, but there are only 3 so far"},
      {good + "f 1 \\\n2 \\\n4\nf 1 2 3\n", "line 5: vertex 4 is meant, but there are only 3"},
      {"f 1 1 1\n", "line 1: vertex 1 is meant, but there are only 0"},
      {"v 0 0 0\n", "it has no faces"},
      {"", "it has no faces"},
      {"\\", "it has no faces"},
      {std::string("\0\x01\xFF\\\n\\", 6), "it has no faces"}};
  for (const auto& [text, because] : cases) {
    const std::string said = refusal([&] { parse(text); });
    EXPECT_NE(said.find(because), std::string::npos) << "said: " << said << "\nshould say: " << because;
    EXPECT_TRUE(said.starts_with(at("file.obj") + ": ")) << said;
  }
  EXPECT_NE(refusal([&] { read_obj_file(folder); }).find("not a regular file"), std::string::npos);
  EXPECT_NE(refusal([&] { read_obj_file(folder / "none.obj"); }).find("not a regular"), std::string::npos);
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
  write_step("plain/walk_0008.obj", 77);
  const Scene plain = load_obj(at("plain/walk_%d.obj"));
  EXPECT_EQ(heights(plain), (std::vector<float>{8, 9, 10, 11}));
  EXPECT_EQ(plain.name, "walk");
  EXPECT_EQ(plain.meshes[0].indices, (Indices{0, 1, 2}));
  EXPECT_EQ(heights(load_obj(at("plain/walk_%04d.obj"))), (std::vector<float>{77}));
  const Scene padded = load_obj(at("padded/"));
  EXPECT_EQ(heights(padded), (std::vector<float>{8, 9, 10, 11}));
  EXPECT_EQ(padded.name, "padded");
  EXPECT_EQ(heights(load_obj(at("padded/run.%04d.OBJ"))), (std::vector<float>{8, 9, 10, 11}));
  EXPECT_EQ(heights(load_obj(at("padded/run.0009.OBJ"))), (std::vector<float>{9}));
  write_step("alone/still.obj", 5);
  EXPECT_TRUE(load_obj(at("alone")).meshes[0].is_static());
}

void expect_refused(const std::string& name, const std::string& because) {
  const std::string said = refusal([&] { load_obj(name); });
  EXPECT_NE(said.find(because), std::string::npos) << "said: " << said << "\nshould say: " << because;
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
  for (std::size_t i = 0; i < kMaxSteps + 1; ++i) write_step("long/w" + std::to_string(i) + ".obj", 1);
  expect_refused(at("long"), "130 files, but at most 129 steps");
  expect_refused(at("long/w%d.obj"), "130 files, but at most 129 steps");
  fs::remove(at("long/w129.obj"));
  EXPECT_EQ(load_obj(at("long")).meshes[0].steps.size(), kMaxSteps);
  fs::create_directories(folder / "empty");
  expect_refused(at("empty"), "has no .obj files");
  expect_refused(at("gap/v%d.obj"), "there is no such file");
  expect_refused(at("none/w%d.obj"), "the folder cannot be read");
  expect_refused(at("none.obj"), "there is no such file");
  for (const char* name : {"w%s.obj", "w%d_%d.obj", "w%.obj", "w%99999d.obj", "100%.obj"})
    expect_refused(at(name), "one number in its name");
}

TEST_F(ObjTest, StepsWithOtherTopologyAreRefused) {
  const std::string good(kTriangle);
  const std::vector<std::pair<std::string, std::string>> cases{
      {good + "v 2 2 2\n", "s2.obj: it has 4 vertices, but"},
      {good + "f 1 2 3\n", "s2.obj: it has 2 triangles, but"},
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 3 2\n", "s2.obj: its triangle 0 has other vertices than in"},
      {"v 0 0 0\nv 1 0 0\nv 0 1\nf 1 2 3\n", "s2.obj: line 3: a vertex has 2 numbers"}};
  write("s1.obj", good);
  for (const auto& [text, because] : cases) {
    write("s2.obj", text);
    expect_refused(at("s%d.obj"), because);
  }
}

}  // namespace
}  // namespace stbvh::harness
