#include "harness/program/scene_options.h"

namespace stbvh::harness {

void add_scale_option(CLI::App& app, Arguments& a) {
  app.add_option(
      "--scale", a.scale,
      "Size of the built-in scenes; 1 has as many triangles as the paper's. Default: each scene's own "
      "(see list)");
}

void add_making_options(CLI::App& app, Arguments& a) {
  add_scale_option(app, a);
  app.add_option("--seed", a.options.seed, "Seed of scenes and rays")->capture_default_str();
  app.add_option("--clip", a.options.gltf.clip, "glTF: name or number of the animation. Default: the first");
  app.add_option("--gltf-scene", a.options.gltf.scene,
                 "glTF: name or number of the scene. Default: the file's own, or the first with a mesh");
  app.add_option("--shutter", a.shutter, "glTF: A,B, the part of the clip in seconds. Default: all of it");
  app.add_option("--shutter-mode", a.shutter_mode,
                 "glTF: where the shutter is longer than the clip: clamp (its ends are held) or loop (it is "
                 "played again)")
      ->capture_default_str();
  app.add_option("--steps", a.steps,
                 "glTF: steps of each moving mesh; or auto:E, for each mesh as few as keep it within E times "
                 "the diagonal of its true motion, as in auto:1e-3")
      ->capture_default_str();
  app.add_option(
         "--step", a.options.obj_step,
         "OBJ: by how much the numbers of a sequence go up from file to file, as in 2 for one on twos")
      ->capture_default_str();
}

std::string shell_word(const std::string& word) {
  const bool is_plain =
      !word.empty() &&
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%") ==
          std::string::npos;
  if (is_plain) return word;
  std::string quoted = "'";
  for (char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace stbvh::harness
