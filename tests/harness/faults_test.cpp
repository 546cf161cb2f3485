/// What happens where there is no memory, no room, no permission, or where a signal ends the program: a file
/// is complete or not there, and what went wrong is one line.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <functional>
#include <sstream>
#include <string>
#include <thread>

#include "harness/images/exr_file.h"
#include "harness/report/json.h"
#include "plugin/files/open_file.h"
#include "plugin/files/output_file.h"
#include "tests/harness/run_stbvh_ab.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kIsSanitized = true;  // their shadow memory needs terabytes of addresses
#else
constexpr bool kIsSanitized = false;
#endif

void expect_one_line_of_failure(const Outcome& run) {
  EXPECT_GT(run.exit_code, 0) << run.out;  // -1: a signal
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 1) << run.out;
}

// --- memory ---

class Memory : public TemporaryFolderTest {
 protected:
  /// All but those of progress, and the empty line that libgomp puts before its own.
  static std::size_t lines_of_failure(const std::string& text) {
    std::istringstream lines(text);
    std::size_t count = 0;
    for (std::string line; std::getline(lines, line);)
      count += line.empty() || line.starts_with('[') ? 0u : 1u;
    return count;
  }

  /// Whatever the limit is, from nothing beyond the loaded program to enough: it works, or fails with one
  /// line.
  void expect_no_signal(const std::string& command) const {
    std::size_t failures = 0;
    for (std::size_t kib = 0; kib < 340000; kib += std::max<std::size_t>(25, kib / 16)) {
      const Outcome run = run_command("LD_PRELOAD=" MEMORY_LIMIT " MEMORY_LIMIT_KIB=" + std::to_string(kib) +
                                      " exec " + command + " 2>&1 >" + at("out"));
      ASSERT_LT(run.exit_code, 128) << kib << " KiB: " << run.out;
      ASSERT_NE(run.exit_code, -1) << kib << " KiB: " << run.out;
      if (run.exit_code == 0) continue;
      ++failures;
      ASSERT_EQ(lines_of_failure(run.out), 1u) << kib << " KiB: " << run.out;
    }
    EXPECT_GT(failures, 0u);
  }
};

TEST_F(Memory, ThatDoesNotSufficeForTheStartIsOneLine) {
  if (kIsSanitized) GTEST_SKIP() << "sanitizers need addresses without limit";
  expect_no_signal(std::string(STBVH_AB) + " list");
  expect_no_signal(std::string(STBVH_PREVIEW) + " --help");
}

TEST_F(Memory, ThatDoesNotSufficeForTheOracleIsOneLine) {
  if (kIsSanitized) GTEST_SKIP() << "sanitizers need addresses without limit";
  expect_no_signal(std::string(STBVH_AB) +
                   " hard --families slivers-1e4 --structures stbvh-direct --count 200 --threads 1");
}

// --- files ---

/// Commands that write files; each with what it writes.
struct Writer {
  const char* name;
  std::string arguments;
  std::vector<std::string> files;  ///< of which none may be there in part
};

class Writing : public TemporaryFolderTest {
 protected:
  void SetUp() override {
    Report report;
    for (std::size_t value : {1u, 2u}) {
      const BuildResult build{
          .scene = "a", .structure = "embree", .triangles = 10, .build_s = {}, .structure_bytes = 200};
      report.scalings.push_back({.over = "steps", .value = value, .build = build});
    }
    write("scaling.json", to_json(report, Machine{}, "abc"));
    fs::create_directory(folder / "to");
    LayeredImage image{.width = 64, .height = 64, .channels = {}, .id_channels = {}, .metadata = {}};
    std::vector<float> noise(64 * 64);
    for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<float>(i * 2654435761u % 65521);
    for (const char* name : {"R", "G", "B"}) image.channels.push_back({name, noise});
    write_exr(image, folder / "a.exr");
    for (float& value : image.channels[0].values) value += 1;
    write_exr(image, folder / "b.exr");
  }

  std::vector<Writer> writers(const fs::path& to) const {
    const std::string scene = " --scenes wheels --scale 0.01 ", file = (to / "out").string();
    return {
        {"pictures",
         "render" + scene + "--size 64x64 --spp 1 --png --structures embree -o " + file + ".exr",
         {"out.exr", "out.png"}},
        {"difference", "compare " + at("a.exr") + " " + at("b.exr") + " --png " + file + ".png", {"out.png"}},
        {"records",
         "bench" + scene +
             "--structures embree --rays primary,bounce,shadow,uniform --count 50 --repeats 1 --build-budget "
             "0 --json " +
             file + ".json",
         {"out.json"}},
        {"XML", "convert wheels --scale 0.01 -o " + file + ".xml", {"out.bin"}},
        {"charts", "charts " + at("scaling.json") + " -o " + to.string(), {"scaling-steps-a.svg"}}};
  }

  /// Whether a file is as it was, or not there.
  void expect_untouched(const fs::path& to, const Writer& writer, const std::string& before) const {
    for (const std::string& name : writer.files) {
      if (before.empty()) {
        EXPECT_FALSE(fs::exists(to / name)) << writer.name << " " << name;
      } else {
        EXPECT_EQ(read_file(to / name), before) << writer.name << " " << name;
      }
    }
    for (const auto& entry : fs::directory_iterator(to))
      EXPECT_NE(entry.path().extension(), ".partial") << writer.name << " " << entry.path();
  }

  static void expect_failure(const Outcome& run, const Writer& writer) {
    EXPECT_GT(run.exit_code, 0) << writer.name << run.out;
    EXPECT_LT(run.exit_code, 128) << writer.name << run.out;
    const std::size_t line = run.out.rfind("stbvh-ab: ");  // the last; tables may stand before it
    ASSERT_NE(line, std::string::npos) << writer.name << run.out;
    EXPECT_EQ(std::count(run.out.begin() + static_cast<std::ptrdiff_t>(line), run.out.end(), '\n'), 1)
        << run.out;
    EXPECT_NE(run.out.find("Cannot write to", line), std::string::npos) << writer.name << run.out;
  }
};

TEST_F(Writing, BeyondTheLargestFileLeavesNothing) {
  const fs::path to = folder / "to";
  for (const std::string before : {"", "as it was"}) {
    for (const Writer& writer : writers(to)) {
      for (const std::string& name : writer.files) {
        fs::remove(to / name);
        if (!before.empty()) write("to/" + name, before);
      }
      if (std::string_view(writer.name) == "XML" && !before.empty()) write("to/out.xml", before);
      expect_failure(run_command("ulimit -f 1; exec " STBVH_AB " " + writer.arguments + " 2>&1"), writer);
      expect_untouched(to, writer, before);
    }
  }
}

TEST_F(Writing, OnAFullDiskLeavesNothing) {
  const fs::path to = folder / "disk";
  fs::create_directory(to);
  if (mount("stbvh", to.c_str(), "tmpfs", 0, "size=64k") != 0) GTEST_SKIP() << "no right to mount a disk";
  EXPECT_THROW(write_file(to / "none", std::string(1 << 20, 'x')), OutputFileError);
  std::ofstream(to / "rest") << std::string(1 << 20, 'x');  // as much as there is room for
  for (const Writer& writer : writers(to)) {
    expect_failure(stbvh_ab(writer.arguments), writer);
    expect_untouched(to, writer, "");
  }
  umount(to.c_str());
}

TEST_F(Writing, WithoutPermissionIsRefusedBeforeAnythingIsDone) {
  const fs::path to = folder / "to";
  fs::permissions(folder, fs::perms::all);
  fs::permissions(
      to, fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read | fs::perms::others_exec);
  const std::string as_nobody = geteuid() == 0 ? "setpriv --reuid=65534 --regid=65534 --clear-groups " : "";
  if (run_command(as_nobody + STBVH_AB + " --version 2>&1").exit_code != 0)
    GTEST_SKIP() << "nobody cannot run the program";
  for (const Writer& writer : writers(to)) {
    const Outcome run = run_command(as_nobody + STBVH_AB + " " + writer.arguments + " 2>&1");
    expect_failure(run, writer);
    EXPECT_NE(run.out.find("Permission denied"), std::string::npos) << run.out;
    EXPECT_TRUE(fs::is_empty(to)) << writer.name;
  }
}

// --- the standard streams ---

TEST_F(Writing, OfTablesToAFullDiskOrAClosedStreamIsAFailure) {
  const std::string ab = STBVH_AB;
  for (const std::string& command : {ab + " list", ab + " --help", ab + " hard --help", ab + " --help-all",
                                     ab + " --version", std::string(STBVH_PREVIEW) + " --version"}) {
    for (const auto& [stream, reason] :
         {std::pair{">/dev/full", "No space left"}, std::pair{">&-", "Bad file descriptor"}}) {
      const Outcome run = run_command(command + " 2>&1 " + stream);
      expect_one_line_of_failure(run);
      EXPECT_NE(run.out.find(std::string("Cannot write to standard output: ") + reason), std::string::npos)
          << command << stream << run.out;
    }
  }
}

TEST_F(Writing, OfLinesThatWereLostLongBeforeTheEndIsAFailure) {
  const std::string scene = "--scenes wheels --scale 0.01 --size 8x8 --spp 1 ";
  for (const std::string& command : {"render " + scene + "--structures stbvh -o " + at("a.exr"),
                                     "truth " + scene + "--frozen-times 2 -o " + at("truth")}) {
    const Outcome run = run_command(STBVH_AB " " + command + " 2>&1 >/dev/full");
    EXPECT_EQ(run.exit_code, 1) << run.out;
    EXPECT_NE(run.out.find("stbvh-ab: Cannot write to standard output"), std::string::npos) << run.out;
  }
}

TEST_F(Writing, AStderrThatCannotBeWrittenToChangesNothingElse) {
  const std::string ab = STBVH_AB;
  for (const std::string stream : {" 2>/dev/full", " 2>&-"}) {
    const Outcome hard =
        run_command(ab + " hard --families slivers-1e4 --structures stbvh-direct --count 20" + stream);
    EXPECT_EQ(hard.exit_code, 0) << stream;
    EXPECT_NE(hard.out.find("slivers-1e4"), std::string::npos) << hard.out;
    EXPECT_EQ(run_command(ab + " error --no-such-option" + stream).exit_code, 2) << stream;
    EXPECT_EQ(run_command(std::string(STBVH_PREVIEW) + " --no-such-option" + stream).exit_code, 2) << stream;
    write("a.obj", "usemtl no_such_material\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");  // a warning
    EXPECT_EQ(run_command(ab + " convert " + at("a.obj") + " -o " + at("a.xml") + stream).exit_code, 0);
  }
}

// --- more files ---

TEST_F(Writing, AndReadingALoopOfLinksIsOneLine) {
  for (const char* extension : {"", ".exr", ".json", ".png", ".xml", ".glb", ".obj", ".ecs"}) {
    fs::create_symlink(std::string("back") + extension, at(std::string("loop") + extension));
    fs::create_symlink(std::string("loop") + extension, at(std::string("back") + extension));
  }
  const std::string loop = at("loop"), scene = "--scenes wheels --scale 0.01 ";
  for (const std::string& command :
       {"compare " + loop + ".exr " + at("a.exr"),
        "compare " + at("a.exr") + " " + at("a.exr") + " --png " + loop + ".png",
        "report --from " + loop + " -o " + at("to"), "report -o " + loop,
        "charts " + loop + ".json -o " + at("to"), "charts " + at("scaling.json") + " -o " + loop,
        "convert wheels -o " + loop + ".xml", "convert " + loop + ".glb -o a.xml",
        "error --scenes " + loop + ".xml", "error --scenes " + loop + ".obj",
        "error --scenes " + loop + ".ecs", "error --scenes " + loop + ".glb",
        "render " + scene + "-o " + loop + ".exr", "bench " + scene + "--json " + loop + ".json",
        "render " + scene + "--environment " + loop + ".exr -o " + at("c.exr"), "truth -o " + loop}) {
    const Outcome run = stbvh_ab(command);
    expect_one_line_of_failure(run);
    EXPECT_TRUE(run.out.find("loop") != std::string::npos &&
                run.out.find("filesystem error") == std::string::npos)
        << command << ": " << run.out;
  }
  EXPECT_TRUE(fs::is_symlink(loop + ".json") && fs::is_symlink(loop + ".png") &&
              fs::is_symlink(loop + ".xml"));
  fs::create_directory(folder / "from");
  fs::create_symlink(loop + ".json", folder / "from" / "bench.json");
  expect_refusal(stbvh_ab("report --from " + at("from") + " -o " + at("to")),
                 "Too many levels of symbolic links");
}

// --- signals ---

/// Ends `writer`, a program that makes and replaces `file` again and again, at many moments, by each of three
/// signals. `others` say what may be left beside it.
void expect_whole(const fs::path& file, const std::function<void()>& writer,
                  const std::function<bool(const std::string&)>& is_whole,
                  const std::function<bool(const std::string&)>& may_be_left) {
  std::size_t seen = 0;
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    for (int i = 0; i < 12; ++i) {
      fs::remove(file);
      const pid_t child = fork();
      if (child == 0) {
        writer();
        _exit(0);
      }
      while (!fs::exists(file)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      std::this_thread::sleep_for(std::chrono::microseconds(1700 * i));
      kill(child, signal);
      int status = 0;
      waitpid(child, &status, 0);
      EXPECT_TRUE(WIFSIGNALED(status)) << status;
      const std::string content = read_file(file);
      EXPECT_TRUE(is_whole(content)) << content.size() << " bytes";
      for (const auto& entry : fs::directory_iterator(file.parent_path())) {
        const std::string left = read_file(entry.path());
        EXPECT_TRUE(entry.path() == file || may_be_left(left)) << entry.path() << left.size() << " bytes";
        if (entry.path() != file) fs::remove(entry.path());
      }
      ++seen;
    }
  }
  EXPECT_EQ(seen, 36u);
}

bool is_one_letter(const std::string& content) {
  return content.size() == std::size_t{4} << 20 &&
         content.find_first_not_of(content.front()) == std::string::npos;
}

TEST_F(Writing, IsWholeWhateverSignalEndsTheProgram) {
  const fs::path file = folder / "to" / "out.json";
  const bool has_nameless_files = OpenFile(folder / "to", O_WRONLY | O_TMPFILE).is_open();
  expect_whole(
      file,
      [&] {
        for (char letter = 'a';; letter = letter == 'z' ? 'a' : static_cast<char>(letter + 1))
          write_file(file, std::string(std::size_t{4} << 20, letter));
      },
      is_one_letter, [&](const std::string& left) { return !has_nameless_files || is_one_letter(left); });
}

TEST_F(Writing, OfScriptsIsWholeWhateverSignalEndsThem) {
  const fs::path file = folder / "to" / "out.svg";
  const std::string code = "import itertools, sys; sys.path.insert(0, '" STBVH_SOURCE_DIR
                           "/harness/report'); from record_files import write_whole\n"
                           "for letter in itertools.cycle(b'abc'): write_whole('" +
                           file.string() + "', bytes([letter]) * (4 << 20))";
  expect_whole(
      file, [&] { execl("/usr/bin/python3", "python3", "-B", "-c", code.c_str(), nullptr); }, is_one_letter,
      [](const std::string&) { return true; });
}

}  // namespace
}  // namespace stbvh::harness
