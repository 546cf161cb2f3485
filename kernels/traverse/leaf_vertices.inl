// The vertices of a leaf at the time of a ray. Part of the traversal sources.

/// Vertices of a leaf relative to the ray's origin at the ray's time; each test has its own order of axes.
struct LeafVertices {
  F32x8 x, y, z;
};

/// Reads the vertices of an indexed leaf at one step from the caller's buffer.
inline void gather_step(const VertexBufferView& buffer, const std::uint32_t* vertices, StepVertices& out) {
  const char* data = static_cast<const char*>(buffer.data);
  for (std::size_t slot = 0; slot < kWidth; ++slot) {
    float p[3];
    std::memcpy(p, data + vertices[slot] * buffer.stride, sizeof p);
    out.position[0][slot] = p[0];
    out.position[1][slot] = p[1];
    out.position[2][slot] = p[2];
  }
}

template <typename Test>
inline LeafVertices load_leaf(const TraversalRay& ray, const LeafHeader& leaf, const MeshRecord& mesh) {
  const bool is_static = mesh.grid.segments == 0.0f;
  const SegmentTime at = is_static ? SegmentTime{0, 0.0f} : segment_at(mesh.grid, ray.time);
  if (leaf.indexed) {
    const auto* vertices = reinterpret_cast<const std::uint32_t*>(&leaf + 1);
    alignas(32) StepVertices steps[2];
    gather_step(mesh.steps[at.segment], vertices, steps[0]);
    if (is_static) return Test::at_rest(ray, steps[0]);
    gather_step(mesh.steps[at.segment + 1], vertices, steps[1]);
    return Test::interpolated(ray, steps[0], steps[1], at.fraction);
  }
  const auto* steps = reinterpret_cast<const StepVertices*>(&leaf + 1);
  if (is_static) return Test::at_rest(ray, steps[0]);
  const StepVertices* step = steps + (at.segment - leaf.first_segment);
  return Test::interpolated(ray, step[0], step[1], at.fraction);
}
