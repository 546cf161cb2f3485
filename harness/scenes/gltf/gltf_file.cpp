#include "harness/scenes/gltf/gltf_file.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "harness/files/input_file.h"
#include "harness/scenes/cancellation.h"
#include "harness/scenes/gltf/extensions.h"
#include "harness/scenes/gltf/json_object.h"
#include "harness/scenes/gltf/json_text.h"
#include "harness/scenes/gltf/model_reader.h"
#include "harness/scenes/gltf/problem.h"
#include "harness/scenes/gltf/uri.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness::gltf {
namespace {

using nlohmann::json;
using Bytes = std::vector<unsigned char>;

constexpr std::size_t kGlbHeaderSize = 12;
constexpr std::size_t kChunkHeaderSize = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

/// Parts of a file, as views of its bytes.
struct Container {
  std::string_view json;
  std::optional<std::span<const unsigned char>> binary_chunk;
};

Bytes read_bytes(const std::filesystem::path& file, std::string_view what) {
  try {
    const InputFile input(file, std::numeric_limits<std::uint32_t>::max());
    Bytes bytes(input.size());
    input.read(0, {reinterpret_cast<char*>(bytes.data()), bytes.size()});
    return bytes;
  } catch (const InputFileError& e) {
    fail("{} {}", what, e.what());
  }
}

std::uint32_t read_u32(std::span<const unsigned char> bytes, std::size_t offset) {
  return static_cast<std::uint32_t>(bytes[offset]) | static_cast<std::uint32_t>(bytes[offset + 1]) << 8 |
         static_cast<std::uint32_t>(bytes[offset + 2]) << 16 |
         static_cast<std::uint32_t>(bytes[offset + 3]) << 24;
}

std::string_view as_text(std::span<const unsigned char> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Container split_glb(std::span<const unsigned char> bytes) {
  if (bytes.size() < kGlbHeaderSize) fail("the file is truncated inside its header");
  const std::uint32_t version = read_u32(bytes, 4);
  if (version != 2) fail("it is binary glTF version {}, only version 2 is supported", version);
  const std::size_t length = read_u32(bytes, 8);
  if (length > bytes.size()) {
    fail("the file is truncated: its header says {} bytes, it has {}", length, bytes.size());
  }
  Container container;
  bool has_json = false;
  for (std::size_t at = kGlbHeaderSize; at < length;) {
    if (length - at < kChunkHeaderSize) fail("the file is truncated inside the header of a chunk");
    const std::size_t chunk_length = read_u32(bytes, at);
    const std::uint32_t chunk_type = read_u32(bytes, at + 4);
    at += kChunkHeaderSize;
    if (chunk_length > length - at) {
      fail("a chunk is said to have {} bytes, but the file has only {} left", chunk_length, length - at);
    }
    const std::span<const unsigned char> chunk = bytes.subspan(at, chunk_length);
    if (!has_json && chunk_type != kJsonChunk) fail("its first chunk is not JSON");
    if (!has_json) {
      container.json = as_text(chunk);
      has_json = true;
    } else if (chunk_type == kBinaryChunk && !container.binary_chunk) {
      container.binary_chunk = chunk;
    }
    at += chunk_length;
  }
  if (!has_json) fail("it has no JSON chunk");
  return container;
}

Container split(std::span<const unsigned char> bytes) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  std::string_view text = as_text(bytes);
  if (text.starts_with("glTF")) return split_glb(bytes);
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || text[first] != '{') fail("it is not a glTF file");
  return {text, std::nullopt};
}

json parse_json(std::string_view source) {
  const std::string text = without_what_nothing_reads(source);
  try {
    json document = json::parse(text.begin(), text.end());
    if (!document.is_object()) fail("its JSON is not an object");
    return document;
  } catch (const json::parse_error& error) {
    fail("its JSON is broken at byte {}", error.byte);
  } catch (const json::exception&) {
    fail("its JSON has a number out of range");
  }
}

Bytes bytes_behind_uri(const std::string& uri, std::size_t buffer, const std::filesystem::path& folder) {
  if (is_data_uri(uri)) {
    std::optional<Bytes> bytes = decode_data_uri(uri);
    if (!bytes) fail("the data URI of buffer {} cannot be decoded", buffer);
    return std::move(*bytes);
  }
  if (has_scheme(uri))
    fail("buffer {} refers to '{}', but only files beside it and data URIs are read", buffer, uri);
  const std::string name = percent_decoded(uri);
  if (name.find('\0') != std::string::npos) fail("the URI of buffer {} has a zero byte", buffer);
  return read_bytes(folder / std::filesystem::path(std::u8string(name.begin(), name.end())),
                    fmt::format("'{}', to which buffer {} refers,", name, buffer));
}

/// Whether meshopt compression says that it has no bytes of its own.
bool is_compressed_alone(const JsonObject& buffer) {
  return std::ranges::any_of(kMeshopt, [&](std::string_view name) {
    const auto compression = buffer.extension(name.data());
    return compression && compression->flag("fallback").value_or(false);
  });
}

/// The first byteLength bytes of what holds the buffer: a file, a data URI, or the binary chunk.
Bytes read_buffer(const JsonObject& buffer, std::size_t number, const Container& container,
                  const std::filesystem::path& folder) {
  const std::size_t byte_length = buffer.required_whole_number("byteLength");
  Bytes bytes;
  if (buffer.has("uri")) {
    bytes = bytes_behind_uri(buffer.text("uri"), number, folder);
  } else if (is_compressed_alone(buffer)) {
    fail("buffer {} is there only with meshopt compression, which is not supported", number);
  } else if (number == 0 && container.binary_chunk) {
    bytes.assign(container.binary_chunk->begin(), container.binary_chunk->end());
  } else {
    fail("buffer {} has no data", number);
  }
  if (byte_length > bytes.size()) {
    fail("buffer {} should have {} bytes, but only {} are there", number, byte_length, bytes.size());
  }
  bytes.resize(byte_length);
  return bytes;
}

/// Which buffers accessors refer to. The others may be placeholders, or hold images.
std::vector<bool> used_buffers(const Model& model, std::size_t count) {
  std::vector<bool> used(count, false);
  const auto use = [&](std::size_t view) {
    if (view < model.views.size() && model.views[view].buffer < count) used[model.views[view].buffer] = true;
  };
  for (const Model::Accessor& accessor : model.accessors) {
    if (accessor.view) use(*accessor.view);
    if (!accessor.sparse) continue;
    use(accessor.sparse->indices_view);
    use(accessor.sparse->values_view);
  }
  return used;
}

void read_buffers(const JsonObject& document, const Container& container, const std::filesystem::path& folder,
                  Model& model) {
  const std::vector<JsonObject> sources = document.objects("buffers");
  const std::vector<bool> used = used_buffers(model, sources.size());
  model.buffers.resize(sources.size());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    sources[i].whole_number("byteLength");  // has the right type, wherever the buffer is used
    if (!used[i]) continue;
    check_cancelled();
    try {
      model.buffers[i].bytes = read_buffer(sources[i], i, container, folder);
    } catch (const Problem& problem) {
      model.buffers[i].problem = problem.what();
    }
    model.bytes += model.buffers[i].bytes.size();
    if (model.bytes > kMaxSceneFileBytes) fail("its buffers have more than {} GB", kMaxSceneFileBytes >> 30);
  }
}

}  // namespace

Model read_gltf_file(const std::filesystem::path& file) {
  const Bytes bytes = read_bytes(file, "the file");
  const Container container = split(bytes);
  const json document = parse_json(container.json);
  Model model = read_model(document);
  model.bytes = bytes.size();
  read_buffers(JsonObject(document, ""), container, file.parent_path(), model);
  return model;
}

}  // namespace stbvh::harness::gltf
