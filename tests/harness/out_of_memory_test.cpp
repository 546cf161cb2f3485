// Memory that runs out in one allocation while a file is read, for each: it is said, or what is read is the
// same as else.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>
#include <new>
#include <string>

#include "harness/images/exr_file.h"
#include "harness/preview/preview_script.h"
#include "harness/report/machine.h"
#include "harness/report/read_records.h"
#include "harness/scenes/embree_xml/embree_xml.h"
#include "harness/scenes/gltf/gltf.h"
#include "harness/scenes/obj/obj.h"
#include "harness/structures/memory_estimate.h"
#include "tests/failing_allocations.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {
namespace {

using test::FailingAllocations;

std::string in_words(const Scene& scene) {
  std::string words = fmt::format("camera {}, lights {}\n", scene.camera.position.x,
                                  scene.directional_lights.size() + scene.point_lights.size());
  for (const Mesh& mesh : scene.meshes) {
    words += fmt::format("{} {} {}\n", mesh.name, mesh.material.color.x, bytes_of(mesh.indices));
    for (const VertexBuffer& step : mesh.steps)
      words += bytes_of(std::vector(step.span().begin(), step.span().end()));
  }
  return words;
}

std::string in_words(const LayeredImage& image) {
  std::string words = fmt::format("{} x {}\n", image.width, image.height);
  for (const auto& channel : image.channels) words += channel.name + bytes_of(channel.values);
  for (const auto& channel : image.id_channels) words += channel.name + bytes_of(channel.values);
  for (const auto& [name, text] : image.metadata) words += name + text;
  return words;
}

std::string in_words(const Report& report) {
  std::string words;
  for (const SpeedResult& speed : report.speeds)
    words += fmt::format("{} {}\n", speed.scene, speed.structure);
  for (const HardResult& hard : report.hards) words += fmt::format("{} {}\n", hard.family, hard.structure);
  return words;
}

std::string in_words(const std::vector<ScriptCommand>& commands) {
  std::string words;
  for (const ScriptCommand& command : commands) {
    words += command.name;
    for (const std::string& word : command.words) words += " " + word;
    words += "\n";
  }
  return words;
}

/// What is read, in words.
using Read = std::function<std::string(const SceneWarning& warn)>;

/// What was read, or why nothing.
std::string answer_of(const Read& read) {
  std::string warnings;
  try {
    const std::string words = read([&](const std::string& sentence) { warnings += sentence; });
    return words + warnings;
  } catch (const UserError& e) {
    return e.what() + warnings;
  }
}

/// How an attempt ends; kNoMemory also where that ends the process (harness/program/program.h).
enum Attempt { kRight, kNoMemory, kNothingFailed, kWrong };

Attempt attempt(const Read& read, const std::string& expected, long number) {
  std::string answer;
  bool have_failed = false;
  try {
    const FailingAllocations failing(number, FailingAllocations::Which::kOne);
    answer = answer_of(read);
    have_failed = failing.have_failed();
  } catch (const std::bad_alloc&) {
    return kNoMemory;
  }
  if (have_failed && answer.find("there is not enough memory for it") != std::string::npos) return kNoMemory;
  if (answer == expected) return have_failed ? kRight : kNothingFailed;
  fmt::print("{}\ninstead of: {}\n", answer, expected);
  std::fflush(stdout);
  return kWrong;
}

/// Runs `work` in a process of its own, with an exit code; -1 where a signal ends it.
int in_a_process(const std::function<int()>& work) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

class OutOfMemory : public TemporaryFolderTest {
 protected:
  OutOfMemory() {
    write("scene.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("scene.xml",
          "<scene><PerspectiveCamera name=\"c\" from=\"0 0 5\" to=\"0 0 0\" up=\"0 1 0\" fov=\"40\"/>"
          "<TriangleMesh><positions>0 0 0 1 0 0 0 1 0</positions><triangles>0 1 2</triangles>"
          "</TriangleMesh></scene>");
  }

  void expect_right_or_no_memory(const Read& read) {
    in_a_process([&] {  // this one stays without threads
      write("expected", answer_of(read));
      return 0;
    });
    const std::string expected = read_file(folder / "expected");
    int ended = kRight;
    for (long number = 0; ended != kNothingFailed; ++number) {
      ended = in_a_process([&] { return attempt(read, expected, number); });
      ASSERT_TRUE(ended == kRight || ended == kNoMemory || ended == kNothingFailed)
          << "allocation " << number << ": " << ended;
    }
  }

  /// Each input of a fuzz target, in a file of that name.
  template <class Reader>
  void expect_right_inputs(const std::string& target, const std::string& name, const Reader& reader) {
    for (const auto& input : fs::directory_iterator(STBVH_SOURCE_DIR "/tests/fuzz/corpus/" + target)) {
      SCOPED_TRACE(input.path().filename().string());
      const std::string bytes = read_file(input);
      const std::size_t end = target == "xml" ? std::min(bytes.find('\0'), bytes.size()) : bytes.size();
      const fs::path file = write(name + input.path().extension().string(), bytes.substr(0, end));
      if (end < bytes.size()) write("input.bin", bytes.substr(end + 1));
      ASSERT_NO_FATAL_FAILURE(
          expect_right_or_no_memory([&](const SceneWarning& warn) { return in_words(reader(file, warn)); }));
    }
  }
};

TEST_F(OutOfMemory, Gltf) {
  expect_right_inputs("gltf", "input", [](const fs::path& file, const SceneWarning& warn) {
    GltfOptions options;
    options.steps = 3;
    return load_gltf(file, options, warn);
  });
}

TEST_F(OutOfMemory, EmbreeXml) {
  expect_right_inputs("xml", "input.xml", load_embree_xml);
}

TEST_F(OutOfMemory, OptionsOfEmbreesTools) {
  expect_right_inputs("ecs", "input.ecs", load_embree_xml);
}

TEST_F(OutOfMemory, Obj) {
  expect_right_inputs("obj", "input.obj", [](const fs::path& file, const SceneWarning& warn) {
    return load_obj(file.string(), warn);
  });
}

TEST_F(OutOfMemory, ObjSequences) {
  for (const char* name : {"walk/w_-1.obj", "walk/w_0.obj"})
    write(name, "mtllib a.mtl b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n");
  write("walk/a.mtl", "newmtl red\nKd 1 0 0\nmap_Kd red.png\n");
  write("walk/.w_1.obj", "");
  for (const char* name : {"walk", "walk/w_%d.obj"})
    expect_right_or_no_memory([&](const SceneWarning& warn) { return in_words(load_obj(at(name), warn)); });
}

TEST_F(OutOfMemory, Exr) {
  expect_right_inputs("exr", "input.exr",
                      [](const fs::path& file, const SceneWarning&) { return read_exr(file); });
}

TEST_F(OutOfMemory, Records) {
  expect_right_inputs("records", "input.json",
                      [](const fs::path& file, const SceneWarning&) { return read_speeds_and_hards(file); });
}

TEST_F(OutOfMemory, Scripts) {
  const fs::path file = write("script", "scrub 0.5 # and some more words behind it\n\nscreenshot a.png\n");
  expect_right_or_no_memory([&](const SceneWarning&) { return in_words(read_script(file)); });
}

TEST_F(OutOfMemory, Machine) {
  expect_right_or_no_memory([](const SceneWarning&) {
    const Machine machine = this_machine();
    return machine.cpu + machine.instruction_set + machine.embree;
  });
  expect_right_or_no_memory([](const SceneWarning&) {
    return available_memory_bytes() == std::numeric_limits<std::size_t>::max() ? "unknown" : "known";
  });
}

}  // namespace
}  // namespace stbvh::harness
