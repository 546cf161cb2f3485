/// From the JSON of a glTF file to its model.
#pragma once

#include <nlohmann/json.hpp>

#include "harness/scenes/gltf/model.h"

namespace stbvh::harness::gltf {

/// All of the model but the bytes of its buffers. Every number that is read has the type and range that glTF
/// gives it, or this throws Problem with its place; also for files that require an extension without which
/// geometry or motion would be wrong.
Model read_model(const nlohmann::json& document);

}  // namespace stbvh::harness::gltf
