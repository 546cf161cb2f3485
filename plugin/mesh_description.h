/// A mesh as the application described it, checked and copied.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "stbvh/mesh_view.h"
#include "stbvh/stbvh_embree.h"

namespace stbvh::plugin {

/// What a C function returns and what stbvhGetErrorMessage then says.
class ApiError : public std::runtime_error {
 public:
  ApiError(RTCError code, const std::string& message) : std::runtime_error(message), code_(code) {}
  RTCError code() const { return code_; }

 private:
  RTCError code_;
};

/// Own copies of the arrays of StbvhMeshArguments; the buffers stay the application's.
class MeshDescription {
 public:
  /// Throws ApiError with RTC_ERROR_INVALID_ARGUMENT for arguments that cannot be read.
  explicit MeshDescription(const StbvhMeshArguments& arguments);

  /// The arguments, their arrays those of this description.
  StbvhMeshArguments arguments() const;

  /// The mesh as the kernels see it; its arrays are those of this description.
  MeshView view() const;

  unsigned geom_id() const { return arguments_.geomID; }
  /// Whether a query's filter is to run on it also where the query does not ask for that.
  bool takes_query_filters() const {
#if RTC_VERSION_MAJOR >= 4
    return arguments_.enableFilterFunctionFromArguments != 0;
#else
    return false;
#endif
  }

 private:
  StbvhMeshArguments arguments_;
  std::vector<const void*> vertices_;
  std::vector<std::size_t> strides_;
  std::vector<VertexBufferView> steps_;
  std::vector<float> step_times_;
};

}  // namespace stbvh::plugin
