/// Mesh descriptions out of the fuzzer's bytes: mostly sound, sometimes broken in every way a caller could.
#pragma once

#include <cstddef>
#include <vector>

#include "byte_reader.h"

namespace stbvh::fuzz {

/// A description and its buffers. They are of exactly the size that the description says, so that the address
/// sanitizer sees whatever is read beside them.
struct FuzzMesh {
  std::vector<std::byte> indices;
  std::vector<std::vector<std::byte>> positions;  ///< of each step
  std::vector<VertexBufferView> steps;
  std::vector<float> step_times;
  MeshView view;
};

FuzzMesh take_mesh(ByteReader& in);

}  // namespace stbvh::fuzz
