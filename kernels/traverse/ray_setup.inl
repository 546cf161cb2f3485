// What a traversal precomputes for a ray. Part of the traversal sources; see traverse_scalar.cpp.

/// Directions are divided by their largest component, so that neither their length nor a vanishing component
/// overflows: boxes are met at s = t * |direction[kz]|.
struct TraversalRay {
  float origin[3];
  float near_origin[3];  ///< moved outwards for the near planes, see ray_slack()
  float far_origin[3];
  float inverse[3];           ///< 1 / (direction[i] / |direction[kz]|), finite
  std::size_t near_plane[3];  ///< index of the near plane of each axis
  std::size_t far_plane[3];
  int kx, ky, kz;  ///< kz: the axis of the largest direction component (Woop, Benthin, Wald 2013)
  float shear_x, shear_y;
  double direction_z;  ///< direction[kz]
  float time;
  float tnear, tfar;    ///< of the query, tfar that of the closest hit so far
  float s_near, s_far;  ///< the same for boxes
  float s_scale;        ///< |direction[kz]|
  std::uint32_t mask;
};

inline bool is_finite(float x) {
  return std::fabs(x) <= 3.402823466e38f;
}

inline float largest_distance(const Box3f& box, const float (&o)[3]) {
  const float lower[3] = {box.lower.x, box.lower.y, box.lower.z};
  const float upper[3] = {box.upper.x, box.upper.y, box.upper.z};
  float d = 0.0f;
  for (int i = 0; i < 3; ++i) {
    const float a = std::fabs(lower[i] - o[i]);
    const float b = std::fabs(upper[i] - o[i]);
    d = d > a ? d : a;
    d = d > b ? d : b;
  }
  return d;
}

/// How far the triangle test may see a vertex from where it is: its translation, interpolation and shear each
/// round, relative to the distance of the vertex, which is at most that of the farthest corner of the scene.
/// Adds up to 10 * 2^-24; rounding of the slab distances takes 4 more (docs/algorithm.md).
inline float ray_slack(const StructureView& structure, const float (&o)[3]) {
  return 0x1p-20f * largest_distance(structure.bounds, o);
}

inline void update_s_far(TraversalRay& r) {
  r.s_far = r.tfar * r.s_scale * (1.0f + 0x1p-21f);
}

/// False for a ray that hits nothing: not finite, of zero direction, or at a time outside the structure's.
inline bool setup_ray(const StructureView& structure, const Ray& ray, TraversalRay& r) {
  const float o[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
  const float d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  // Zero unless something is infinite or not a number.
  const float none = o[0] * 0.0f + o[1] * 0.0f + o[2] * 0.0f + d[0] * 0.0f + d[1] * 0.0f + d[2] * 0.0f;
  if (!(none == 0.0f)) return false;
  if (!(ray.time >= structure.time_begin && ray.time <= structure.time_last)) return false;
  if (!(ray.tnear <= ray.tfar)) return false;  // also where either is NaN

  // Selected without branches, which random directions would mispredict.
  const float x = std::fabs(d[0]), y = std::fabs(d[1]), z = std::fabs(d[2]);
  const float larger = x > y ? x : y;
  const int kz = z >= larger ? 2 : static_cast<int>(x <= y);
  const float scale = z >= larger ? z : larger;
  if (!(scale > 0.0f)) return false;
  constexpr int kNext[] = {1, 2, 0, 1};
  r.kx = kNext[kz];
  r.ky = kNext[kz + 1];
  r.kz = kz;
  r.direction_z = d[kz];
  r.shear_x = d[r.kx] / d[kz];
  r.shear_y = d[r.ky] / d[kz];

  const float slack = ray_slack(structure, o);
  // A power of two keeps ratios of tiny directions from underflowing.
  const float unit = scale < 0x1p-40f ? 0x1p80f : 1.0f;
  const float least =
      scale * unit * 1e-18f;  // keeps the inverse finite: the slack covers the ray's deviation
  for (int i = 0; i < 3; ++i) {
    r.origin[i] = o[i];
    const float component = std::fabs(d[i]) * unit;
    const float magnitude = component > least ? component : least;
    r.inverse[i] = std::copysign(unit * scale / magnitude, d[i]);
    const float slack_i = slack + 0x1p-22f * std::fabs(o[i]);  // survives the rounding of the sum
    r.near_origin[i] = o[i] + std::copysign(slack_i, d[i]);
    r.far_origin[i] = o[i] - std::copysign(slack_i, d[i]);
    const auto axis = static_cast<std::size_t>(i);
    const std::size_t upper = std::signbit(d[i]) ? 3 : 0;
    r.near_plane[i] = axis + upper;
    r.far_plane[i] = axis + 3 - upper;
  }
  r.time = ray.time;
  r.mask = ray.mask;
  r.tnear = ray.tnear;
  r.tfar = ray.tfar;
  r.s_scale = scale;
  r.s_near = ray.tnear * scale * (1.0f - 0x1p-21f);
  if (ray.tnear < 0.0f) r.s_near = ray.tnear * scale * (1.0f + 0x1p-21f);
  update_s_far(r);
  return true;
}
