#include "harness/scenes/gltf/accessor.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>
#include <span>

#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

/// Where to read: `stride` bytes from element to element.
struct Elements {
  const unsigned char* first = nullptr;
  std::size_t stride = 0;
};

std::size_t component_size(std::size_t component_type, std::size_t accessor, std::string_view use) {
  switch (component_type) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      fail("accessor {} ({}) has the unknown component type {}", accessor, use, component_type);
  }
}

/// Checks that `count` elements lie inside the view, and the view inside its buffer.
Elements locate(const Model& model, std::size_t view_index, std::size_t offset, std::size_t count,
                std::size_t element_size, std::size_t accessor, std::string_view use) {
  if (view_index >= model.views.size())
    fail("accessor {} ({}) refers to the missing buffer view {}", accessor, use, view_index);
  const Model::BufferView& view = model.views[view_index];
  if (view.buffer >= model.buffers.size())
    fail("buffer view {} refers to the missing buffer {}", view_index, view.buffer);
  if (const std::string& problem = model.buffers[view.buffer].problem; !problem.empty())
    throw Problem(problem);
  const std::span<const unsigned char> buffer = model.buffers[view.buffer].bytes;
  if (view.offset > buffer.size() || view.length > buffer.size() - view.offset)
    fail("buffer view {} reaches beyond the {} bytes of buffer {}", view_index, buffer.size(), view.buffer);
  const std::size_t stride = view.stride == 0 ? element_size : view.stride;
  if (stride < element_size) {
    fail("buffer view {} has a stride of {} bytes, but accessor {} ({}) has elements of {} bytes", view_index,
         stride, accessor, use, element_size);
  }
  const bool fits = count == 0 || (offset <= view.length && element_size <= view.length - offset &&
                                   (view.length - offset - element_size) / stride >= count - 1);
  if (!fits) fail("accessor {} ({}) reaches beyond its buffer view {}", accessor, use, view_index);
  return {count == 0 ? nullptr : buffer.data() + view.offset + offset, stride};
}

template <class T>
T load(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

std::uint32_t load_integer(const unsigned char* bytes, std::size_t component_type) {
  switch (component_type) {
    case kUnsignedByte:
      return load<std::uint8_t>(bytes);
    case kUnsignedShort:
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

double load_number(const unsigned char* bytes, std::size_t component_type, bool normalized) {
  switch (component_type) {
    case kByte:
      return load_number<std::int8_t>(bytes, normalized);
    case kUnsignedByte:
      return load_number<std::uint8_t>(bytes, normalized);
    case kShort:
      return load_number<std::int16_t>(bytes, normalized);
    case kUnsignedShort:
      return load_number<std::uint16_t>(bytes, normalized);
    case kUnsignedInt:
      return load_number<std::uint32_t>(bytes, normalized);
    default:
      return static_cast<double>(load<float>(bytes));
  }
}

bool is_unsigned_integer(std::size_t component_type) {
  return component_type == kUnsignedByte || component_type == kUnsignedShort ||
         component_type == kUnsignedInt;
}

const Model::Accessor& accessor_of_type(const Model& model, std::size_t index, ElementType type,
                                        std::string_view use) {
  const Model::Accessor& accessor = accessor_at(model, index, use);
  if (accessor.type != type) {
    fail("accessor {} ({}) has elements of {} components instead of {}", index, use,
         component_count(accessor.type), component_count(type));
  }
  return accessor;
}

/// The data of an accessor; no first element where it has none.
Elements locate_elements(const Model& model, std::size_t index, std::string_view use) {
  const Model::Accessor& accessor = model.accessors[index];
  const std::size_t element_size =
      component_size(accessor.component_type, index, use) * component_count(accessor.type);
  if (!accessor.view) return {};
  return locate(model, *accessor.view, accessor.offset, accessor.count, element_size, index, use);
}

/// What the sparse part of an accessor puts in the place of elements.
struct Replacements {
  Elements places, values;
};

Replacements locate_replacements(const Model& model, std::size_t index, std::string_view use) {
  const Model::Accessor& accessor = model.accessors[index];
  const Model::Sparse& sparse = *accessor.sparse;
  if (sparse.count > accessor.count) {
    fail("accessor {} ({}) has {} sparse values, but only {} elements", index, use, sparse.count,
         accessor.count);
  }
  if (!is_unsigned_integer(sparse.indices_type))
    fail("the sparse indices of accessor {} ({}) are not unsigned", index, use);
  const std::size_t element_size =
      component_size(accessor.component_type, index, use) * component_count(accessor.type);
  return {locate(model, sparse.indices_view, sparse.indices_offset, sparse.count,
                 component_size(sparse.indices_type, index, use), index, use),
          locate(model, sparse.values_view, sparse.values_offset, sparse.count, element_size, index, use)};
}

template <class T, class Load>
void apply_sparse(const Model& model, std::size_t index, std::string_view use, const Load& load_component,
                  std::vector<T>& values) {
  const Model::Accessor& accessor = model.accessors[index];
  const std::size_t components = component_count(accessor.type);
  const std::size_t size = component_size(accessor.component_type, index, use);
  const auto [places, replacements] = locate_replacements(model, index, use);
  for (std::size_t i = 0; i < accessor.sparse->count; ++i) {
    const std::size_t place = load_integer(places.first + i * places.stride, accessor.sparse->indices_type);
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
std::vector<T> read(const Model& model, std::size_t index, std::string_view use, const Load& load_component) {
  const Model::Accessor& accessor = model.accessors[index];
  const std::size_t components = component_count(accessor.type);
  const std::size_t size = component_size(accessor.component_type, index, use);
  const Elements elements = locate_elements(model, index, use);
  std::vector<T> values(accessor.count * components, T{0});
  if (elements.first != nullptr) {
    for (std::size_t i = 0; i < accessor.count; ++i) {
      for (std::size_t c = 0; c < components; ++c) {
        values[i * components + c] = load_component(elements.first + i * elements.stride + c * size);
      }
    }
  }
  if (accessor.sparse) apply_sparse(model, index, use, load_component, values);
  return values;
}

}  // namespace

const Model::Accessor& accessor_at(const Model& model, std::size_t index, std::string_view use) {
  if (index >= model.accessors.size()) fail("accessor {} ({}) is missing", index, use);
  return model.accessors[index];
}

std::size_t checked_count(const Model& model, std::size_t accessor, std::string_view use) {
  const Model::Accessor& a = accessor_at(model, accessor, use);
  locate_elements(model, accessor, use);
  if (a.sparse) locate_replacements(model, accessor, use);
  return a.count;
}

std::vector<double> read_numbers(const Model& model, std::size_t accessor, ElementType type,
                                 std::string_view use) {
  const Model::Accessor& a = accessor_of_type(model, accessor, type, use);
  return read<double>(model, accessor, use, [&](const unsigned char* bytes) {
    return load_number(bytes, a.component_type, a.normalized);
  });
}

std::vector<std::uint32_t> read_integers(const Model& model, std::size_t accessor, ElementType type,
                                         std::string_view use) {
  const Model::Accessor& a = accessor_of_type(model, accessor, type, use);
  if (!is_unsigned_integer(a.component_type))
    fail("accessor {} ({}) does not hold unsigned integers", accessor, use);
  return read<std::uint32_t>(model, accessor, use, [&](const unsigned char* bytes) {
    return load_integer(bytes, a.component_type);
  });
}

}  // namespace stbvh::harness::gltf
