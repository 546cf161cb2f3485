/// Materials of OBJ files.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "harness/scenes/name_list.h"
#include "harness/scenes/scene.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness {

/// Within [0, 1], as reflectances and transmittances are in our materials.
Vec3f clamped_reflectance(Vec3f color);

/// The nearest of our materials to one of such files: diffuse, or glossy where there is a specular part; the
/// coat reflects as much straight ahead, and is as rough as Blinn's exponent says.
Material obj_material(Vec3f diffuse, Vec3f specular, float exponent);

inline constexpr const char* kTexturesLeftOut =
    "Textures are left out: materials have the same color everywhere.";
inline constexpr const char* kReadAsOpaque = "OBJ materials with d below 1 are read as opaque.";

/// Tells `warn` of materials that `file` names, but does not define, if there are any.
void warn_of_undefined(const NameList& materials, const std::filesystem::path& file,
                       const SceneWarning& warn);

/// The materials of a library (.mtl) by name: Kd, Ks, Ns and Ke. Tells `warn` what else it would show, and
/// which values are left out, as they are no finite numbers. Throws SceneFileError for a file that cannot be
/// read.
std::map<std::string, Material> read_mtl_file(const std::filesystem::path& file, const SceneWarning& warn);

}  // namespace stbvh::harness
