#include "harness/scenes/gltf/accessor.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>

#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

/// Most elements of an accessor that no bytes of the file stand behind (all zero, but for sparse values).
constexpr std::size_t kMaxElementsWithoutData = std::size_t{1} << 24;

/// Where to read: `stride` bytes from element to element.
struct Elements {
  const unsigned char* first = nullptr;
  std::size_t stride = 0;
};

std::size_t component_size(int component_type, int accessor, std::string_view use) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      fail("accessor {} ({}) has the unknown component type {}", accessor, use, component_type);
  }
}

/// Checks that `count` elements lie inside the view, and the view inside its buffer.
Elements locate(const tinygltf::Model& model, int view_index, std::size_t offset, std::size_t count,
                std::size_t element_size, int accessor, std::string_view use) {
  if (view_index < 0 || static_cast<std::size_t>(view_index) >= model.bufferViews.size()) {
    fail("accessor {} ({}) refers to the missing buffer view {}", accessor, use, view_index);
  }
  const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(view_index)];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size()) {
    fail("buffer view {} refers to the missing buffer {}", view_index, view.buffer);
  }
  const std::vector<unsigned char>& buffer = model.buffers[static_cast<std::size_t>(view.buffer)].data;
  if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset) {
    fail("buffer view {} reaches beyond the {} bytes of buffer {}", view_index, buffer.size(), view.buffer);
  }
  const std::size_t stride = view.byteStride == 0 ? element_size : view.byteStride;
  if (stride < element_size) {
    fail("buffer view {} has a stride of {} bytes, but accessor {} ({}) has elements of {} bytes", view_index,
         stride, accessor, use, element_size);
  }
  const bool fits = count == 0 || (offset <= view.byteLength && element_size <= view.byteLength - offset &&
                                   (view.byteLength - offset - element_size) / stride >= count - 1);
  if (!fits) fail("accessor {} ({}) reaches beyond its buffer view {}", accessor, use, view_index);
  return {count == 0 ? nullptr : buffer.data() + view.byteOffset + offset, stride};
}

template <class T>
T load(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

std::uint32_t load_integer(const unsigned char* bytes, int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return load<std::uint8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<std::uint16_t>(bytes);
    default:
      return load<std::uint32_t>(bytes);
  }
}

template <class T>
double load_number(const unsigned char* bytes, bool normalized) {
  const auto value = static_cast<double>(load<T>(bytes));
  return normalized ? std::max(value / static_cast<double>(std::numeric_limits<T>::max()), -1.0) : value;
}

double load_number(const unsigned char* bytes, int component_type, bool normalized) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return load_number<std::int8_t>(bytes, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return load_number<std::uint8_t>(bytes, normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return load_number<std::int16_t>(bytes, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load_number<std::uint16_t>(bytes, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return load_number<std::uint32_t>(bytes, normalized);
    default:
      return static_cast<double>(load<float>(bytes));
  }
}

bool is_unsigned_integer(int component_type) {
  return component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

const tinygltf::Accessor& accessor_at(const tinygltf::Model& model, int index, int type,
                                      std::string_view use) {
  if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size()) {
    fail("accessor {} ({}) is missing", index, use);
  }
  const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(index)];
  if (accessor.type != type) {
    fail("accessor {} ({}) has elements of {} components instead of {}", index, use,
         tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)),
         tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type)));
  }
  return accessor;
}

/// Replaces the elements that the sparse part of an accessor names.
template <class T, class Load>
void apply_sparse(const tinygltf::Model& model, int index, std::size_t components, std::size_t size,
                  std::string_view use, const Load& load_component, std::vector<T>& values) {
  const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(index)];
  const auto& sparse = accessor.sparse;
  if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > accessor.count ||
      sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0) {
    fail("accessor {} ({}) has an invalid sparse part", index, use);
  }
  const int index_type = sparse.indices.componentType;
  if (!is_unsigned_integer(index_type))
    fail("the sparse indices of accessor {} ({}) are not unsigned", index, use);
  const auto count = static_cast<std::size_t>(sparse.count);
  const Elements places =
      locate(model, sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset), count,
             component_size(index_type, index, use), index, use);
  const Elements replacements =
      locate(model, sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset), count,
             size * components, index, use);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t place = load_integer(places.first + i * places.stride, index_type);
    if (place >= accessor.count) {
      fail("accessor {} ({}) has a sparse value for element {} of {}", index, use, place, accessor.count);
    }
    for (std::size_t c = 0; c < components; ++c) {
      values[place * components + c] =
          load_component(replacements.first + i * replacements.stride + c * size);
    }
  }
}

template <class T, class Load>
std::vector<T> read(const tinygltf::Model& model, int index, std::string_view use,
                    const Load& load_component) {
  const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(index)];
  const auto components =
      static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
  const std::size_t size = component_size(accessor.componentType, index, use);
  Elements elements;
  if (accessor.bufferView != -1) {
    elements = locate(model, accessor.bufferView, accessor.byteOffset, accessor.count, size * components,
                      index, use);
  } else if (accessor.count > kMaxElementsWithoutData) {
    fail("accessor {} ({}) has {} elements, but no data", index, use, accessor.count);
  }
  std::vector<T> values(accessor.count * components, T{0});
  if (elements.first != nullptr) {
    for (std::size_t i = 0; i < accessor.count; ++i) {
      for (std::size_t c = 0; c < components; ++c) {
        values[i * components + c] = load_component(elements.first + i * elements.stride + c * size);
      }
    }
  }
  if (accessor.sparse.isSparse) apply_sparse(model, index, components, size, use, load_component, values);
  return values;
}

}  // namespace

std::vector<double> read_numbers(const tinygltf::Model& model, int accessor, int type, std::string_view use) {
  const tinygltf::Accessor& a = accessor_at(model, accessor, type, use);
  return read<double>(model, accessor, use, [&](const unsigned char* bytes) {
    return load_number(bytes, a.componentType, a.normalized);
  });
}

std::vector<std::uint32_t> read_integers(const tinygltf::Model& model, int accessor, int type,
                                         std::string_view use) {
  const tinygltf::Accessor& a = accessor_at(model, accessor, type, use);
  if (!is_unsigned_integer(a.componentType)) {
    fail("accessor {} ({}) does not hold unsigned integers", accessor, use);
  }
  return read<std::uint32_t>(
      model, accessor, use, [&](const unsigned char* bytes) { return load_integer(bytes, a.componentType); });
}

}  // namespace stbvh::harness::gltf
