#include "plugin/callbacks.h"

#include <cstddef>
#include <limits>

#include "plugin/filters.h"

namespace stbvh::plugin {
namespace {

static_assert(offsetof(Ray, tnear) == offsetof(RTCRay, tnear) &&
              offsetof(Ray, direction) == offsetof(RTCRay, dir_x) &&
              offsetof(Ray, time) == offsetof(RTCRay, time) &&
              offsetof(Ray, tfar) == offsetof(RTCRay, tfar) && offsetof(Ray, mask) == offsetof(RTCRay, mask));

/// What a query asks for: its answer goes to the rays where they stand.
struct ClosestHit {
  static RTCRayN* rays(const RTCIntersectFunctionNArguments* arguments) {
    return RTCRayHitN_RayN(arguments->rayhit, arguments->N);
  }
  static bool is_filtered(const Packet& packet) {
    return packet.published->has_intersect_filters || has_query_filter(packet);
  }
  static constexpr auto accept = accept_closest_hit;

  static bool ask(const Structure& structure, const Ray& ray, Hit& hit, const HitFilter* filter) {
    return structure.intersect(ray, hit, filter);
  }
  static void ask(const Structure& structure, const RayBatch& batch) { structure.intersect(batch); }

  static void store(const Lane& lane, const Hit& hit) {
    lane.tfar() = hit.t;
    store_hit(lane.hits(), lane.size(), lane.index, hit, geom_id_of(lane.packet, hit), lane.packet.context);
  }
  static void store_filtered(const Lane&) {}  // accept has
};

struct AnyHit {
  static RTCRayN* rays(const RTCOccludedFunctionNArguments* arguments) { return arguments->ray; }
  static bool is_filtered(const Packet& packet) {
    return packet.published->has_occluded_filters || has_query_filter(packet);
  }
  static constexpr auto accept = accept_any_hit;

  static bool ask(const Structure& structure, const Ray& ray, Hit&, const HitFilter* filter) {
    return structure.occluded(ray, filter);
  }
  static void ask(const Structure& structure, const RayBatch& batch) { structure.occluded(batch); }

  static void store(const Lane& lane, const Hit&) { store_filtered(lane); }
  static void store_filtered(const Lane& lane) { lane.tfar() = -std::numeric_limits<float>::infinity(); }
};

template <typename Query>
inline void trace_one(const Packet& packet, const Ray& ray) {
  Hit hit;
  const Structure& structure = *packet.published->structure;
  if (Query::is_filtered(packet)) {
    const HitFilter filter{Query::accept, const_cast<Packet*>(&packet)};
    if (Query::ask(structure, ray, hit, &filter)) Query::store_filtered(lane_of(packet, ray));
  } else if (Query::ask(structure, ray, hit, nullptr)) {
    Query::store(lane_of(packet, ray), hit);
  }
}

template <typename Query>
void trace_many(Packet& packet, const void* rays, std::size_t stride, std::size_t count) {
  const HitFilter filter{Query::accept, &packet};
  const bool is_filtered = Query::is_filtered(packet);
  constexpr auto store = [](void* user, const Ray& ray, const Hit& hit) {
    Query::store(lane_of(*static_cast<const Packet*>(user), ray), hit);
  };
  constexpr auto store_filtered = [](void* user, const Ray& ray, const Hit&) {
    Query::store_filtered(lane_of(*static_cast<const Packet*>(user), ray));
  };
  Query::ask(*packet.published->structure, {.rays = rays,
                                            .stride = stride,
                                            .count = count,
                                            .report = is_filtered ? +store_filtered : +store,
                                            .user = &packet,
                                            .filter = is_filtered ? &filter : nullptr});
}

inline Ray ray_in(RTCRayN* rays, unsigned size, unsigned i) {
  return {
      .origin = {RTCRayN_org_x(rays, size, i), RTCRayN_org_y(rays, size, i), RTCRayN_org_z(rays, size, i)},
      .tnear = RTCRayN_tnear(rays, size, i),
      .direction = {RTCRayN_dir_x(rays, size, i), RTCRayN_dir_y(rays, size, i), RTCRayN_dir_z(rays, size, i)},
      .time = RTCRayN_time(rays, size, i),
      .tfar = RTCRayN_tfar(rays, size, i),
      .mask = RTCRayN_mask(rays, size, i)};
}

/// Apart from single rays, which need none of its room.
template <typename Query>
[[gnu::noinline]] void trace_packet(Packet packet, const int* valid) {
  Ray copies[kMaxPacket];
  unsigned indices[kMaxPacket];
  packet.copies = copies;
  packet.indices = indices;
  unsigned i = 0;
  while (i < packet.size) {  // once, unless a program makes up larger packets than Embree
    unsigned count = 0;
    for (; i < packet.size && count < kMaxPacket; ++i) {
      if (valid[i] == 0) continue;
      copies[count] = ray_in(packet.rays, packet.size, i);
      indices[count++] = i;
    }
    trace_many<Query>(packet, copies, sizeof *copies, count);
  }
}

template <typename Query, typename Arguments>
inline void answer(const Arguments* arguments) {
  const auto* const published = static_cast<const Published*>(arguments->geometryUserPtr);
  if (published->structure == nullptr) return;
  Packet packet{.published = published,
                .context = arguments->context,
                .query_filter = published->runs_query_filters ? filter_of_query(arguments) : QueryFilter{},
                .geom_id = arguments->geomID};
  RTCRayN* const rays = Query::rays(arguments);
  if (arguments->N == 1) {  // most rays: a copy would cost as much as a node
    if (arguments->valid[0] != 0) trace_one<Query>(packet, *reinterpret_cast<const Ray*>(rays));
    return;
  }
  packet.rays = rays;
  packet.size = arguments->N;
  trace_packet<Query>(packet, arguments->valid);
}

template <typename Query, typename Rays>
void answer(const Published& published, unsigned geom_id, QueryContext* context, QueryFilter filter,
            const Rays& rays) {
  Packet packet{.published = &published, .context = context, .query_filter = filter, .geom_id = geom_id};
  if (rays.count == 1) return trace_one<Query>(packet, *reinterpret_cast<const Ray*>(rays.first));
  trace_many<Query>(packet, rays.first, rays.stride, rays.count);
}

}  // namespace

void bounds_callback(const RTCBoundsFunctionArguments* arguments) {
  const auto& steps = static_cast<const Published*>(arguments->geometryUserPtr)->grid.steps;
  // A scene may hold more steps than an emptied geometry has boxes: it is empty at each of them.
  const Box3f& box = arguments->timeStep < steps.size() ? steps[arguments->timeStep] : steps.back();
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = box.lower.x;
  bounds.lower_y = box.lower.y;
  bounds.lower_z = box.lower.z;
  bounds.upper_x = box.upper.x;
  bounds.upper_y = box.upper.y;
  bounds.upper_z = box.upper.z;
}

void intersect_callback(const RTCIntersectFunctionNArguments* arguments) {
  answer<ClosestHit>(arguments);
}

void occluded_callback(const RTCOccludedFunctionNArguments* arguments) {
  answer<AnyHit>(arguments);
}

void intersect(const Published& published, unsigned geom_id, QueryContext* context, QueryFilter filter,
               Rays<RTCRayHit> rays) {
  answer<ClosestHit>(published, geom_id, context, filter, rays);
}

void occluded(const Published& published, unsigned geom_id, QueryContext* context, QueryFilter filter,
              Rays<RTCRay> rays) {
  answer<AnyHit>(published, geom_id, context, filter, rays);
}

}  // namespace stbvh::plugin
