// USD and Alembic files, through the libraries that read them: skipped where their Python cannot be made.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "harness/images/exr_file.h"
#include "harness/program/shot_reader.h"
#include "harness/scenes/shots/shot.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

const std::string kSource = STBVH_SOURCE_DIR;
const std::string kScripts = kSource + "/harness/scenes/shots";

std::string in_quotes(const fs::path& path) {
  return "'" + path.string() + "'";
}

/// Interpreter of the shots, made if need be; empty where that cannot be.
std::string shots_python() {
  const Outcome run = run_command(
      fmt::format("/usr/bin/python3 -B -c 'import sys; sys.path.insert(0, \"{}\"); import shot_environment; "
                  "print(shot_environment.ensure())' 2>/dev/null",
                  kScripts));
  return run.exit_code == 0 ? run.out.substr(0, run.out.find('\n')) : "";
}

class ShotsTest : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    if (python_.empty()) GTEST_SKIP() << "the Python environment that reads shots cannot be made";
  }

  static fs::path data(const std::string& name) { return fs::path(kSource) / "data" / name; }

  /// Writes down what the library is told in Python, for files that are not text.
  void run_python(const std::string& script) const {
    const Outcome run =
        run_command(in_quotes(python_) + " -B " + in_quotes(write("script.py", script)) + " 2>&1");
    ASSERT_EQ(run.exit_code, 0) << run.out;
  }

  Scene load(const fs::path& file, const ShotOptions& options = {}) {
    return read_shot(file.string(), options, [this](const std::string& line) { warnings.push_back(line); });
  }

  bool is_warned_of(const std::string& words) const {
    return std::ranges::any_of(
        warnings, [&](const std::string& line) { return line.find(words) != std::string::npos; });
  }

  std::vector<std::string> warnings;
  const std::string python_ = shots_python();
};

const Mesh* find_mesh(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.meshes, name, &Mesh::name);
  return found == scene.meshes.end() ? nullptr : &*found;
}

/// Of the files that others made: next to the repository, as it stands in the sources' folder or in a
/// worktree of it.
fs::path shared_shots() {
  for (const char* folder : {"/../shared/assets/shots", "/../../shared/assets/shots"}) {
    if (fs::exists(kSource + folder)) return kSource + folder;
  }
  return {};
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (is_shot_name(entry.path().string())) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

/// A refusal, behind what the program says that it is doing.
void expect_one_line(Outcome run, const std::string& file) {
  if (run.out.starts_with("[")) run.out.erase(0, run.out.find('\n') + 1);
  expect_refusal(run, file);
}

/// Positions at 50 times, against usd-core's own evaluation.
void expect_true_positions(const std::string& python, const fs::path& folder, const fs::path& file) {
  const Outcome run = run_command(fmt::format(
      "exec 7>{0}/handover && {1} -B {2}/read_shot.py -- {3} 7 && {4} -B {5}/tests/harness/shot_truth.py "
      "{3} {0}/handover 2>&1 | tail -1",
      folder.string(), "/usr/bin/python3", kScripts, in_quotes(file), python, kSource));
  double share = 1;
  int meshes = 0;
  ASSERT_EQ(std::sscanf(run.out.c_str(), "%lf %d", &share, &meshes), 2) << file << ": " << run.out;
  EXPECT_LT(share, 2e-6) << file;
  EXPECT_GT(meshes, 0) << file;
}

TEST_F(ShotsTest, PositionsAreThoseOfUsdCore) {
  for (const char* name : {"turning_bar", "nested_instances", "blend_shape", "velocities"})
    expect_true_positions(python_, folder, data(fmt::format("{}.usda", name)));
}

TEST_F(ShotsTest, PositionsOfOthersFilesAreThoseOfTheLibraries) {
  const fs::path shots = shared_shots();
  if (shots.empty()) GTEST_SKIP() << "../shared is not there";
  for (const fs::path& file : files_in(shots)) expect_true_positions(python_, folder, file);
}

TEST_F(ShotsTest, StepsAreTheFilesOwnAndUneven) {
  const Scene scene = load(data("velocities.usda"));
  const Mesh* const thrown = find_mesh(scene, "/Thrown");
  ASSERT_NE(thrown, nullptr);
  EXPECT_TRUE(thrown->has_step_times());
  EXPECT_EQ(thrown->motion_range().begin, 0);
  EXPECT_EQ(thrown->motion_range().end, 1);
  // Of each sample a mesh with its own faces.
  EXPECT_EQ(std::ranges::count(scene.meshes, "/Splash", &Mesh::name), 3);
  EXPECT_EQ(std::ranges::count(scene.meshes, "/Crumble", &Mesh::name), 2);
  EXPECT_TRUE(is_warned_of("no velocities: /Crumble")) << warnings.size();
  EXPECT_TRUE(is_warned_of("corners do not add up: /Broken"));
  EXPECT_EQ(warnings.size(), 2u);
}

TEST_F(ShotsTest, VelocitiesReplaceInterpolation) {
  const Scene scene = load(data("velocities.usda"));
  const Mesh* const splash = find_mesh(scene, "/Splash");
  ASSERT_NE(splash, nullptr);
  ASSERT_EQ(splash->steps.size(), 2u);
  EXPECT_EQ(splash->steps[0][0].z, 0);
  EXPECT_NEAR(splash->steps[1][0].z, 0.01 * 6 / 24, 1e-8);  // a frame later; USD is in centimeters
}

TEST_F(ShotsTest, FacesKeepTheirNumbers) {
  const Scene scene = load(data("turning_bar.usda"));
  const Mesh* const bar = find_mesh(scene, "/Axle/Bar");
  ASSERT_NE(bar, nullptr);
  const std::vector<std::uint32_t> expected{0, 0, 0, 1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6};
  EXPECT_EQ(bar->faces, expected);
  EXPECT_EQ(std::ranges::count(scene.meshes, "/Axle/Plate", &Mesh::name), 2);  // it is hidden in between
  EXPECT_EQ(scene.camera_steps.size(), 129u);
  EXPECT_EQ(bar->material.color.x, 0.8f);
}

TEST_F(ShotsTest, PicturesHaveTheFilesFaces) {
  const Outcome run =
      stbvh_ab(fmt::format("render --scenes {} --structures stbvh-direct --size 64x36 --spp 1 -o {}",
                           data("turning_bar.usda").string(), at("bar.exr")));
  ASSERT_EQ(run.exit_code, 0) << run.out;
  const Scene scene = load(data("turning_bar.usda"));
  const LayeredImage image = read_exr(at("bar.exr"));
  ASSERT_EQ(image.id_channels.size(), 3u);
  const auto values = [&](const std::string& name) {
    return std::ranges::find(image.id_channels, name, &IdChannel::name)->values;
  };
  const auto meshes = values("mesh.id"), triangles = values("primitive.id"), faces = values("face.id");
  std::size_t others = 0;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const bool is_hit = meshes[i] < scene.meshes.size();
    EXPECT_EQ(faces[i], is_hit ? scene.meshes[meshes[i]].face_of(triangles[i]) : triangles[i]);
    others += faces[i] != triangles[i] ? 1u : 0u;
  }
  EXPECT_GT(others, 0u);
}

/// What a closed mesh encloses, above 0 where its faces are wound counterclockwise seen from outside.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto [a, b, c] = std::array{mesh.steps[0][mesh.indices[i]], mesh.steps[0][mesh.indices[i + 1]],
                                      mesh.steps[0][mesh.indices[i + 2]]};
    sum += double{a.x} * (double{b.y} * c.z - double{b.z} * c.y) +
           double{a.y} * (double{b.z} * c.x - double{b.x} * c.z) +
           double{a.z} * (double{b.x} * c.y - double{b.y} * c.x);
  }
  return sum / 6;
}

TEST_F(ShotsTest, FacesAreWoundCounterclockwise) {
  // Left-handed and mirrored: both or neither.
  EXPECT_GT(volume(*find_mesh(load(data("turning_bar.usda")), "/Axle/Bar")), 0);
  const Scene stones = load(data("nested_instances.usda"));
  EXPECT_GT(volume(*find_mesh(stones, "/Cart/Stones[0]/Cart/Stones/Kinds/Small")), 0);
  if (shared_shots().empty()) GTEST_SKIP() << "../shared is not there";
  EXPECT_GT(volume(load(shared_shots() / "rotatingCube.abc").meshes[0]), 0);  // Alembic winds clockwise
}

TEST_F(ShotsTest, UnitsAndUpAxisAreHonoured) {
  const Scene scene = load(data("turning_bar.usda"));
  const Mesh& plate = *find_mesh(scene, "/Axle/Plate");
  EXPECT_NEAR(plate.steps[0][0].y, 0.04, 1e-6);  // z = 10 - 6 centimeters
}

TEST_F(ShotsTest, InstancesAndLoopSurfaces) {
  const Scene scene = load(data("nested_instances.usda"));
  EXPECT_EQ(scene.meshes.size(), 4u);  // one of the three stones is invisible
  const Mesh* const large = find_mesh(scene, "/Cart/Stones[1]/Cart/Stones/Kinds/Large");
  ASSERT_NE(large, nullptr);
  EXPECT_EQ(large->triangle_count(), 4u * 64);
  EXPECT_EQ(large->faces.back(), 3u);
}

TEST_F(ShotsTest, AShutterIsAPartOfTheFile) {
  // Frames 1 to 3, of 24 a second.
  const Scene scene = load(data("velocities.usda"), {.shutter = {{1.0 / 24, 3.0 / 24}}});
  EXPECT_EQ(std::ranges::count(scene.meshes, "/Splash", &Mesh::name), 2);
}

TEST_F(ShotsTest, FramesAreTimeCodesOfAUsdFile) {
  const auto places = [this](const FilePart& part, const fs::path& file) {
    std::vector<std::string> steps;
    for (const VertexBuffer& step : load(file, {.shutter = part}).meshes.at(0).steps)
      for (std::size_t vertex = 0; vertex < step.size(); ++vertex)
        steps.push_back(fmt::format("{} {} {}", step[vertex].x, step[vertex].y, step[vertex].z));
    return steps;
  };
  const fs::path bar = data("turning_bar.usda");  // 24 time codes a second
  EXPECT_EQ(places({1, 2, true}, bar), places({1.0 / 24, 2.0 / 24}, bar));
  EXPECT_EQ(places({1, 2, true, 12}, bar), places({2, 4, true}, bar));
  EXPECT_NE(places({1, 2, true}, bar), places({2, 4, true}, bar));
  if (shared_shots().empty()) GTEST_SKIP() << "../shared is not there";
  const fs::path cube = shared_shots() / "animatedCube.abc";
  EXPECT_EQ(places({3, 6, true, 12}, cube), places({0.25, 0.5}, cube));
  EXPECT_EQ(places({6, 12, true}, cube), places({0.25, 0.5}, cube));
}

TEST_F(ShotsTest, OursAreRightOverAllOfThem) {
  std::string files;
  for (const fs::path& file : files_in(fs::path(kSource) / "data")) files += "," + file.string();
  if (const fs::path shots = shared_shots(); !shots.empty()) {
    for (const fs::path& file : files_in(shots)) files += "," + file.string();
  }
  const Outcome run =
      stbvh_ab("error --scenes " + files.substr(1) + " --structures stbvh,stbvh-direct --count 2000");
  EXPECT_EQ(run.exit_code, 0) << run.out;
}

TEST_F(ShotsTest, MalformedFilesAreOneLine) {
  const fs::path shots = shared_shots();
  if (shots.empty()) GTEST_SKIP() << "../shared is not there";
  for (const fs::path& file : files_in(shots / "malformed"))
    expect_one_line(stbvh_ab("convert " + file.string() + " -o " + at("out.xml")), file.filename().string());
  const std::string whole = read_file(shots / "animatedCube.abc");
  for (const std::size_t bytes : {0ul, 5ul, 16ul, 1000ul, whole.size() / 2, whole.size() - 100}) {
    const fs::path cut = write("cut.abc", whole.substr(0, bytes));
    expect_one_line(stbvh_ab("convert " + cut.string() + " -o " + at("out.xml")), "cut.abc");
  }
}

TEST_F(ShotsTest, CutUsdIsOneLine) {
  run_python(fmt::format("from pxr import Usd\nUsd.Stage.Open('{}').Export('{}')\n",
                         data("turning_bar.usda").string(), at("whole.usdc")));
  const std::string whole = read_file(at("whole.usdc"));
  EXPECT_GT(load(at("whole.usdc")).meshes.size(), 0u);
  for (const std::size_t bytes : {0ul, 5ul, 88ul, whole.size() / 2, whole.size() - 100})
    expect_one_line(
        stbvh_ab("convert " + write("cut.usdc", whole.substr(0, bytes)).string() + " -o " + at("out.xml")),
        "cut.usdc");
  const std::string text = read_file(data("turning_bar.usda"));
  expect_one_line(
      stbvh_ab("convert " + write("cut.usda", text.substr(0, 1000)).string() + " -o " + at("out.xml")),
      "cut.usda");
}

TEST_F(ShotsTest, ReferencesThatCannotBeFollowedLoseNothingElse) {
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
  EXPECT_TRUE(is_warned_of("nowhere.usd"));
  EXPECT_TRUE(is_warned_of("Cycle"));
}

TEST_F(ShotsTest, MoreSamplesThanAMeshHasSteps) {
  run_python(fmt::format(R"(from pxr import Usd, UsdGeom, Vt
stage = Usd.Stage.CreateNew('{}')
mesh = UsdGeom.Mesh.Define(stage, '/Many')
mesh.CreateFaceVertexCountsAttr([3])
mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
op = mesh.AddTranslateOp()
for time in range(10000):
    op.Set((time * 1e-4, (time % 7) * 0.01, 0), time)
stage.Save()
)",
                         at("many.usdc")));
  const Scene scene = load(at("many.usdc"));
  EXPECT_LE(scene.meshes.at(0).steps.size(), kMaxSteps);
  EXPECT_TRUE(is_warned_of("of the diagonal from its motion"));
}

TEST_F(ShotsTest, WithoutNetworkOneSentenceAndNothingLeft) {
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

TEST_F(ShotsTest, AReaderThatCrashesLosesNothingThatWasRead) {
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
