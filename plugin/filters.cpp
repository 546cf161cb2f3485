#include "plugin/filters.h"

#include <algorithm>

namespace stbvh::plugin {
namespace {

/// The arguments of a filter: one valid lane, the hit in all lanes (as Embree's own packet kernels do), the
/// rays the application's.
class FilterCall {
 public:
  FilterCall(const Lane& lane, const Hit& candidate) : lane_(lane) {
    std::fill_n(valid_, lane.size(), 0);
    valid_[lane.index] = -1;
    const unsigned geom_id = geom_id_of(lane.packet, candidate);
    for (unsigned i = 0; i < lane.size(); ++i)
      store_hit(hits(), lane.size(), i, candidate, geom_id, lane.packet.context);
  }

  /// Runs the mesh's filter and then the query's, those that are not null; false if one rejects.
  bool accepts(RTCFilterFunctionN mesh_filter, const PublishedMesh& mesh) {
    const QueryFilter& of_query = lane_.packet.query_filter;
    const bool takes_query_filter = of_query.on_all_meshes || mesh.takes_query_filters;
    const RTCFilterFunctionN query_filter = takes_query_filter ? of_query.function : nullptr;
    if (mesh_filter == nullptr && query_filter == nullptr) return true;
    RTCFilterFunctionNArguments arguments;
    arguments.valid = valid_;
    const auto translate = lane_.packet.published->filter_user_ptr;
    arguments.geometryUserPtr = translate == nullptr ? mesh.user_ptr : translate(mesh.user_ptr);
    arguments.context = lane_.packet.context;
    arguments.ray = lane_.rays;
    arguments.hit = hits();
    arguments.N = lane_.size();
    for (const RTCFilterFunctionN filter : {mesh_filter, query_filter}) {
      if (filter == nullptr) continue;
      filter(&arguments);
      if (valid_[lane_.index] == 0) return false;
    }
    return true;
  }

  /// Copies the hit, with what the filters made of it, to the lane.
  void store() {
    float* const to = reinterpret_cast<float*>(lane_.hits());
    for (unsigned member = 0; member < kHitMembers; ++member) {
      const unsigned entry = member * lane_.size() + lane_.index;
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

/// Runs the filters on a candidate with the lane's tfar at its distance, put back if it is rejected.
bool passes(FilterCall& call, const Lane& lane, const Hit& candidate, RTCFilterFunctionN mesh_filter) {
  const float old_tfar = lane.tfar();
  lane.tfar() = candidate.t;
  const bool accepted = call.accepts(mesh_filter, lane.packet.published->meshes[candidate.mesh]);
  if (!accepted) lane.tfar() = old_tfar;
  return accepted;
}

}  // namespace

// A filter may leave another tfar than the candidate's, to go on collecting hits beyond it, say. The kernels
// then keep theirs (the candidate counts as rejected), and what lies beyond the lane's tfar is turned away
// here.
bool accept_closest_hit(void* packet, const Ray& ray, const Hit& candidate) {
  const Lane lane = lane_of(*static_cast<const Packet*>(packet), ray);
  if (candidate.t > lane.tfar()) return false;
  FilterCall call(lane, candidate);
  if (!passes(call, lane, candidate, lane.packet.published->meshes[candidate.mesh].intersect_filter))
    return false;
  call.store();
  return lane.tfar() <= candidate.t;
}

bool accept_any_hit(void* packet, const Ray& ray, const Hit& candidate) {
  const Lane lane = lane_of(*static_cast<const Packet*>(packet), ray);
  FilterCall call(lane, candidate);
  return passes(call, lane, candidate, lane.packet.published->meshes[candidate.mesh].occluded_filter);
}

}  // namespace stbvh::plugin
