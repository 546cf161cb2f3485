// What is wrong with USD and Alembic files: one line each, and nothing lost that could be read.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "harness/files/input_file.h"
#include "harness/scenes/shots/shot.h"
#include "harness/scenes/shots/usd_depth.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/shot_files.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

using ShotRefusals = ShotsTest;

/// A refusal, behind what the program says that it is doing.
void expect_one_line(Outcome run, const std::string& file) {
  if (run.out.starts_with("[")) run.out.erase(0, run.out.find('\n') + 1);
  expect_refusal(run, file);
}

/// Of a file's beginning: in its head, all over it, and all but its end.
std::vector<std::size_t> cut_lengths(std::size_t whole) {
  std::vector<std::size_t> lengths{0, 5, 16, 88, whole - 100, whole - 8, whole - 1};
  for (std::size_t i = 1; i < 16; ++i) lengths.push_back(whole * i / 16);
  return lengths;
}

TEST_F(ShotRefusals, MalformedFilesAreOneLine) {
  const fs::path shots = shared_shots();
  if (shots.empty()) GTEST_SKIP() << "../shared is not there";
  for (const fs::path& file : files_in(shots / "malformed"))
    expect_one_line(stbvh_ab("convert " + file.string() + " -o " + at("out.xml")), file.filename().string());
}

TEST_F(ShotRefusals, CutAlembicIsOneLine) {
  const fs::path shots = shared_shots();
  if (shots.empty()) GTEST_SKIP() << "../shared is not there";
  const std::string whole = read_file(shots / "animatedCube.abc");
  for (const std::size_t bytes : cut_lengths(whole.size())) {
    const fs::path cut = write("cut.abc", whole.substr(0, bytes));
    expect_one_line(stbvh_ab("convert " + cut.string() + " -o " + at("out.xml")), "cut.abc");
  }
}

TEST_F(ShotRefusals, CutUsdIsOneLine) {
  run_python(fmt::format("from pxr import Usd\nUsd.Stage.Open('{}').Export('{}')\n",
                         data("turning_bar.usda").string(), at("whole.usdc")));
  const std::string whole = read_file(at("whole.usdc"));
  EXPECT_GT(load(at("whole.usdc")).meshes.size(), 0u);
  for (const std::size_t bytes : cut_lengths(whole.size()))
    expect_one_line(
        stbvh_ab("convert " + write("cut.usdc", whole.substr(0, bytes)).string() + " -o " + at("out.xml")),
        "cut.usdc");
  const std::string text = read_file(data("turning_bar.usda"));
  expect_one_line(
      stbvh_ab("convert " + write("cut.usda", text.substr(0, 1000)).string() + " -o " + at("out.xml")),
      "cut.usda");
}

TEST_F(ShotRefusals, ReferencesThatCannotBeFollowedLoseNothingElse) {
  const fs::path file = write("shot.usda", R"(#usda 1.0
def "One" (references = </Two>)
{
}
def "Two" (references = </One>)
{
}
def "Missing" (references = @nowhere.usd@)
{
}
def Mesh "Shown"
{
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
}
)");
  EXPECT_EQ(load(file).meshes.size(), 1u);
  EXPECT_EQ(warnings.size(), 3u);  // one for each reference
  EXPECT_TRUE(is_warned_of("nowhere.usd"));
  EXPECT_TRUE(is_warned_of("Cycle"));
}

TEST_F(ShotRefusals, AMillionSamplesAreAsManyStepsAsAMeshHas) {
  run_python(fmt::format(R"(from pxr import Gf, Sdf, Usd, UsdGeom
stage = Usd.Stage.CreateNew('{}')
mesh = UsdGeom.Mesh.Define(stage, '/Many')
mesh.CreateFaceVertexCountsAttr([3])
mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
path = mesh.AddTranslateOp().GetAttr().GetPath()
with Sdf.ChangeBlock():
    for time in range(1_000_000):
        stage.GetRootLayer().SetTimeSample(path, time, Gf.Vec3d(time * 1e-6, (time % 7) * 0.01, 0))
stage.Save()
)",
                         at("many.usdc")));
  const Scene scene = load(at("many.usdc"));
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_LE(scene.meshes[0].steps.size(), kMaxSteps);
  EXPECT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(is_warned_of("of the diagonal from its motion"));
}

TEST_F(ShotRefusals, WithoutNetworkOneSentenceAndNothingLeft) {
  fs::copy(kScripts, folder / "shots");
  const Outcome run = run_command(fmt::format(
      "cd {0} && exec 7>handover && PIP_INDEX_URL=http://127.0.0.1:9/simple PIP_CONFIG_FILE=/dev/null "
      "XDG_CACHE_HOME={0}/cache /usr/bin/python3 -B shots/read_shot.py -- {1} 7 2>/dev/null && strings "
      "handover",
      folder.string(), in_quotes(data("turning_bar.usda"))));
  EXPECT_NE(run.out.find("is there a network?"), std::string::npos) << run.out;
  for (const auto& entry : fs::directory_iterator(folder / "cache/stbvh"))
    EXPECT_EQ(entry.path().extension(), ".lock") << entry.path();
}

TEST_F(ShotRefusals, AReaderThatCrashesLosesNothingThatWasRead) {
  const Outcome run =
      run_command(fmt::format("exec 7>{}/handover && /usr/bin/python3 -B {}/read_shot.py -- {} 7",
                              folder.string(), kScripts, in_quotes(data("velocities.usda"))));
  ASSERT_EQ(run.exit_code, 0);
  const std::string whole = read_file(folder / "handover");
  const fs::path part = write("part", whole.substr(0, whole.size() - 200));
  const auto warn = [this](const std::string& line) { warnings.push_back(line); };
  EXPECT_GT(load_shot(part, "shot.abc", "crashes the library that reads it", warn).meshes.size(), 0u);
  EXPECT_TRUE(is_warned_of("it crashes the library that reads it; what was read before is shown"));
  const fs::path nothing = write("nothing", "");
  EXPECT_THROW(load_shot(nothing, "shot.abc", "crashes the library that reads it", warn), SceneFileError);
}

TEST_F(ShotRefusals, NamesThatAreNotUtf8AreOneLine) {
  fs::copy(data("turning_bar.usda"), folder / "\xFF.usda");
  expect_one_line(stbvh_ab("convert " + at("\xFF.usda") + " -o " + at("out.xml")),
                  "it has a name that is not UTF-8");
}

TEST_F(ShotRefusals, WithoutMemoryForTheLibrariesTheReaderSaysSo) {
  const Outcome run =
      run_command(fmt::format("exec 7>{}/handover && ulimit -v 600000 && '{}' -B {}/read_shot.py -- {} 7",
                              folder.string(), python_, kScripts, in_quotes(data("velocities.usda"))));
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(read_file(folder / "handover").find("needs more memory than there is"), std::string::npos);
}

class ShotFiles : public TemporaryFolderTest {
 protected:
  void expect_refused(const std::string& name, const std::string& reason, const std::string& before = "") {
    expect_one_line(run_command(fmt::format("{} timeout -s KILL 300 {} convert {} -o {} 2>&1", before,
                                            STBVH_AB, at(name), at("out.xml"))),
                    reason);
  }
};

TEST_F(ShotFiles, ThatLibrariesWouldWaitForAreRefused) {
  for (const std::string name : {"a.usda", "a.usdc", "a.usdz", "a.usd", "a.abc"}) {
    ASSERT_EQ(mkfifo(at(name).c_str(), 0600), 0);
    expect_refused(name, "it is not a regular file");
    fs::remove(folder / name);
    fs::resize_file(write(name, ""), std::uintmax_t{100} << 30);
    expect_refused(name, "it has 107374182400 bytes, but at most 25769803776 are read");
  }
}

TEST_F(ShotFiles, NeedAFolderForTemporaryFiles) {
  write("a.usda", "#usda 1.0\n");
  expect_refused("a.usda", "none\" (TMPDIR): No such file or directory", "TMPDIR=" + at("none"));
}

TEST_F(ShotFiles, NestedTooDeeplyAreRefused) {
  const auto nested = [&](const std::string& open, const std::string& close, int depth) {
    std::string text = "#usda 1.0\n";
    for (int i = 0; i < depth; ++i) text += open;
    for (int i = 0; i < depth; ++i) text += close;
    return is_nested_too_deeply(InputFile(write("deep.usda", text), kMaxSceneFileBytes));
  };
  const std::string hiding = R"('it\'s (' """a "(" \"""" '' @a'(.usd@ @@@b@(.usd@@@ /* ( */ )"
                             "'''\n'('''# (\n// (\n(";
  for (const auto& [open, close] :
       {std::pair<std::string, std::string>{"(", ")"}, {"[", "]"}, {"def \"a\" {\n", "}\n"}, {hiding, ")"}}) {
    EXPECT_FALSE(nested(open, close, kMaxUsdDepth)) << open;
    EXPECT_TRUE(nested(open, close, kMaxUsdDepth + 1)) << open;
    EXPECT_TRUE(nested(open, close, 20'000)) << open;
  }
  // Over several blocks.
  for (const std::string hidden :
       {"\"(\"", "'('", "\"\"\"\n\"(\"\n\"\"\"", "@(@", "#(\n", "//(\n", "/*(*/", "()"})
    EXPECT_FALSE(nested(hidden, "", 20'000)) << hidden;
  for (const std::string open : {"\"\"\"", "'''", "@@@", "/*"})
    EXPECT_FALSE(nested("", open + std::string(300, '('), 1)) << open;
  write("deep.usda", "PXR-USDC" + std::string(1000, '('));
  EXPECT_FALSE(is_nested_too_deeply(InputFile(folder / "deep.usda", kMaxSceneFileBytes)));
  nested("(", ")", 20'000);
  expect_refused("deep.usda", "deep.usda: it is nested more than 200 levels deep");
}

/// Each byte of a mesh's head, changed: refused or read, whatever it says.
TEST(ShotRecords, CountsAreHeldAgainstTheSize) {
  const TemporaryFolder owner;
  std::string record("STBVSHT1");
  const auto number = [&](std::uint64_t value, std::size_t bytes) {
    record.append(reinterpret_cast<const char*>(&value), bytes);
  };
  const std::string positions(36, '\0'), floats(24, '\0');
  number(1, 8);                                                    // a mesh
  number(16 + 7 * 8 + 24 + 1 + 4 + 12 + 36, 8);                    // bytes
  for (const unsigned value : {1u, 0u, 0u, 0u}) number(value, 4);  // name, scheme, boundary
  for (const unsigned value : {3u, 1u, 3u, 1u, 0u, 0u, 0u}) number(value, 8);
  record += floats + "m";
  for (const unsigned value : {3u, 0u, 1u, 2u}) number(value, 4);
  record += positions;
  number(0, 8);
  number(0, 8);
  const fs::path file = owner.path() / "handover";
  std::size_t read = 0;
  for (std::size_t i = 8; i < record.size(); ++i) {
    for (const char bits : {'\x01', '\x80', '\xFF'}) {
      std::string changed = record;
      changed[i] = static_cast<char>(changed[i] ^ bits);
      std::ofstream(file, std::ios::binary) << changed;
      try {
        read += load_shot(file, "m", "", {}).meshes.size();
      } catch (const SceneFileError&) {
      }
    }
  }
  EXPECT_GT(read, 0u);
}

}  // namespace
}  // namespace stbvh::harness
