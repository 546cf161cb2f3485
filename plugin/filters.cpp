#include "plugin/filters.h"

#include <algorithm>

namespace stbvh::plugin {
namespace {

/// Embree calls user geometries with at most this many rays.
constexpr unsigned kMaxPacket = 16;

/// The arguments of a filter: one valid lane, the hit in all lanes (as Embree's own packet kernels do), the
/// rays the application's.
class FilterCall {
 public:
  FilterCall(const Lane& lane, const Hit& candidate) : lane_(lane) {
    std::fill_n(valid_, lane.size, 0);
    valid_[lane.index] = -1;
    const unsigned geom_id = geom_id_of(lane, candidate);
    for (unsigned i = 0; i < lane.size; ++i)
      store_hit(hits(), lane.size, i, candidate, geom_id, lane.context);
  }

  /// Runs the mesh's filter and then the query's, those that are not null; false if one rejects.
  bool accepts(RTCFilterFunctionN mesh_filter, const PublishedMesh& mesh) {
    const bool takes_query_filter = lane_.query_filter.on_all_meshes || mesh.takes_query_filters;
    const RTCFilterFunctionN query_filter = takes_query_filter ? lane_.query_filter.function : nullptr;
    if (mesh_filter == nullptr && query_filter == nullptr) return true;
    RTCFilterFunctionNArguments arguments;
    arguments.valid = valid_;
    const auto translate = lane_.published->filter_user_ptr;
    arguments.geometryUserPtr = translate == nullptr ? mesh.user_ptr : translate(mesh.user_ptr);
    arguments.context = lane_.context;
    arguments.ray = lane_.rays;
    arguments.hit = hits();
    arguments.N = lane_.size;
    for (const RTCFilterFunctionN filter : {mesh_filter, query_filter}) {
      if (filter == nullptr) continue;
      filter(&arguments);
      if (valid_[lane_.index] == 0) return false;
    }
    return true;
  }

  /// Copies the hit, with what the filters made of it, to the lane.
  void store() {
    float* const to =
        reinterpret_cast<float*>(RTCRayHitN_HitN(reinterpret_cast<RTCRayHitN*>(lane_.rays), lane_.size));
    for (unsigned member = 0; member < kHitMembers; ++member) {
      const unsigned entry = member * lane_.size + lane_.index;
      to[entry] = hits_[entry];
    }
  }

 private:
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  static constexpr unsigned kHitMembers = 7 + 2 * RTC_MAX_INSTANCE_LEVEL_COUNT;
#else
  static constexpr unsigned kHitMembers = 7 + RTC_MAX_INSTANCE_LEVEL_COUNT;
#endif

  RTCHitN* hits() {
    return reinterpret_cast<RTCHitN*>(hits_);
  }

  const Lane& lane_;
  alignas(64) int valid_[kMaxPacket];
  alignas(64) float hits_[kHitMembers * kMaxPacket];
};

float& tfar(const Lane& lane) {
  return RTCRayN_tfar(lane.rays, lane.size, lane.index);
}

/// Runs the filters on a candidate with the lane's tfar at its distance, put back if it is rejected.
bool passes(FilterCall& call, const Lane& lane, const Hit& candidate, RTCFilterFunctionN mesh_filter) {
  const float old_tfar = tfar(lane);
  tfar(lane) = candidate.t;
  const bool accepted = call.accepts(mesh_filter, lane.published->meshes[candidate.mesh]);
  if (!accepted) tfar(lane) = old_tfar;
  return accepted;
}

/// HitFilter::accept of a closest-hit query; `user` is the lane.
///
/// A filter may leave another tfar than the candidate's, to go on collecting hits beyond it, say. The kernels
/// then keep theirs (the candidate counts as rejected), and what lies beyond the lane's tfar is turned away
/// here.
bool accept_closest(void* user, const Ray&, const Hit& candidate) {
  const Lane& lane = *static_cast<const Lane*>(user);
  if (candidate.t > tfar(lane)) return false;
  FilterCall call(lane, candidate);
  if (!passes(call, lane, candidate, lane.published->meshes[candidate.mesh].intersect_filter)) return false;
  call.store();
  return tfar(lane) <= candidate.t;
}

/// HitFilter::accept of an any-hit query; `user` is the lane.
bool accept_any(void* user, const Ray&, const Hit& candidate) {
  const Lane& lane = *static_cast<const Lane*>(user);
  FilterCall call(lane, candidate);
  return passes(call, lane, candidate, lane.published->meshes[candidate.mesh].occluded_filter);
}

}  // namespace

void intersect_filtered(const Lane& lane, const Ray& ray) {
  Lane state = lane;
  const HitFilter filter{accept_closest, &state};
  Hit hit;
  lane.published->structure->intersect(ray, hit, &filter);
}

bool occluded_filtered(const Lane& lane, const Ray& ray) {
  Lane state = lane;
  const HitFilter filter{accept_any, &state};
  return lane.published->structure->occluded(ray, &filter);
}

}  // namespace stbvh::plugin
