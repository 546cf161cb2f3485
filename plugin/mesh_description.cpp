#include "plugin/mesh_description.h"

#include <cmath>
#include <cstdint>

namespace stbvh::plugin {
namespace {

[[noreturn]] void refuse(const std::string& message) {
  throw ApiError(RTC_ERROR_INVALID_ARGUMENT, message);
}

void check_alignment(const void* pointer, std::size_t alignment, const std::string& name) {
  if (reinterpret_cast<std::uintptr_t>(pointer) % alignment == 0) return;
  refuse(name + " must be aligned to " + std::to_string(alignment) + " bytes");
}

void check_stride(std::size_t stride, const std::string& name) {
  if (stride >= 12 && stride <= PTRDIFF_MAX && stride % 4 == 0) return;
  refuse(name + " must be a multiple of 4 from 12 to " + std::to_string(PTRDIFF_MAX) + ", not " +
         std::to_string(stride));
}

void check_indices(const StbvhMeshArguments& arguments) {
  check_stride(arguments.indexByteStride, "indexByteStride");
  if (arguments.triangleCount > 0 && arguments.indices == nullptr) {
    refuse("indices is null, but triangleCount is " + std::to_string(arguments.triangleCount));
  }
  check_alignment(arguments.indices, 4, "indices");
  if (arguments.triangleCount > UINT32_MAX) refuse("triangleCount must fit into 32 bits");
}

void check_time_range(const StbvhMeshArguments& arguments) {
  if (!std::isfinite(arguments.startTime) || !std::isfinite(arguments.endTime)) {
    refuse("startTime and endTime must be finite");
  }
  if (!(arguments.startTime < arguments.endTime)) refuse("startTime must be smaller than endTime");
  if (!std::isfinite(arguments.endTime - arguments.startTime)) {
    refuse("the time range is too long for a float");
  }
}

void check_steps(const StbvhMeshArguments& arguments) {
  if (arguments.stepCount < 1 || arguments.stepCount > STBVH_MAX_STEP_COUNT) {
    refuse("stepCount must be 1 to " + std::to_string(STBVH_MAX_STEP_COUNT) + ", not " +
           std::to_string(arguments.stepCount));
  }
  check_alignment(arguments.stepTimes, alignof(float), "stepTimes");
  if (arguments.stepTimes == nullptr) check_time_range(arguments);
  if (arguments.vertexCount > UINT32_MAX) refuse("vertexCount must fit into 32 bits");
  if (arguments.vertices == nullptr && arguments.vertexCount > 0) refuse("vertices is null");
  check_alignment(arguments.vertices, alignof(void*), "vertices");
  check_alignment(arguments.vertexByteStrides, alignof(std::size_t), "vertexByteStrides");
}

}  // namespace

MeshDescription::MeshDescription(const StbvhMeshArguments& arguments) : arguments_(arguments) {
  check_indices(arguments);
  check_steps(arguments);
  for (unsigned step = 0; step < arguments.stepCount; ++step) {
    const std::string name = '[' + std::to_string(step) + ']';
    const void* data = arguments.vertices == nullptr ? nullptr : arguments.vertices[step];
    const std::size_t stride = arguments.vertexByteStrides == nullptr ? arguments.vertexByteStride
                                                                      : arguments.vertexByteStrides[step];
    check_stride(stride,
                 arguments.vertexByteStrides == nullptr ? "vertexByteStride" : "vertexByteStrides" + name);
    if (data == nullptr && arguments.vertexCount > 0) refuse("vertices" + name + " is null");
    check_alignment(data, 4, "vertices" + name);
    vertices_.push_back(data);
    strides_.push_back(stride);
    steps_.push_back({data, arguments.vertexCount, stride});
  }
  if (arguments.stepTimes != nullptr)
    step_times_.assign(arguments.stepTimes, arguments.stepTimes + arguments.stepCount);
  // What the commit would refuse: here it is still known which mesh it is, and the others stay.
  if (const char* const problem = problem_of(view())) refuse(std::string("the mesh ") + problem);
}

StbvhMeshArguments MeshDescription::arguments() const {
  StbvhMeshArguments result = arguments_;
  result.vertices = vertices_.data();
  result.vertexByteStrides = strides_.data();
  result.stepTimes = step_times_.empty() ? nullptr : step_times_.data();
  return result;
}

MeshView MeshDescription::view() const {
  MeshView view;
  view.indices = arguments_.indices;
  view.triangle_count = arguments_.triangleCount;
  view.index_stride = arguments_.indexByteStride;
  view.steps = steps_;
  view.time_range = {arguments_.startTime, arguments_.endTime};
  if (!step_times_.empty()) {
    view.time_range = {step_times_.front(), step_times_.back()};
    view.step_times = step_times_;
  }
  view.mask = arguments_.mask;
  return view;
}

}  // namespace stbvh::plugin
