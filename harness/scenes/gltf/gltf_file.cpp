#include "harness/scenes/gltf/gltf_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "harness/scenes/gltf/problem.h"

namespace stbvh::harness::gltf {
namespace {

using nlohmann::json;
using Bytes = std::vector<unsigned char>;

constexpr int kMaxJsonDepth = 100;  ///< tinygltf descends into extras and extensions by recursion
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
  std::error_code error;
  if (!std::filesystem::exists(file, error)) fail("{} does not exist", what);
  if (!std::filesystem::is_regular_file(file, error)) fail("{} is not a regular file", what);
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size > std::numeric_limits<std::uint32_t>::max()) fail("{} is larger than 4 GB", what);
  std::ifstream stream(file, std::ios::binary);
  Bytes bytes(static_cast<std::size_t>(size));
  if (!stream || !stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
    fail("{} cannot be read", what);
  }
  return bytes;
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

json parse_json(std::string_view text) {
  const auto limit_depth = [](int depth, json::parse_event_t, json&) {
    if (depth > kMaxJsonDepth) fail("its JSON is nested more than {} levels deep", kMaxJsonDepth);
    return true;
  };
  try {
    json document = json::parse(text.begin(), text.end(), limit_depth);
    if (!document.is_object()) fail("its JSON is not an object");
    return document;
  } catch (const json::parse_error& error) {
    fail("its JSON is broken at byte {}", error.byte);
  } catch (const json::exception&) {
    fail("its JSON has a number out of range");
  }
}

/// The array of that name, empty if there is none.
const json& array_in(const json& object, const char* name) {
  static const json kEmpty = json::array();
  const auto found = object.find(name);
  if (found == object.end()) return kEmpty;
  if (!found->is_array()) fail("its \"{}\" is not an array", name);
  return *found;
}

void check_version(const json& document) {
  const auto asset = document.find("asset");
  if (asset == document.end() || !asset->is_object() || !asset->contains("version") ||
      !(*asset)["version"].is_string()) {
    fail("it is not a glTF file: its JSON has no asset.version");
  }
  const std::string version = (*asset)["version"].get<std::string>();
  if (!version.starts_with("2.")) fail("it is glTF version {}, only version 2 is supported", version);
}

/// Extensions that change only how surfaces look, or that the readers of accessors understand anyway.
bool keeps_geometry(std::string_view extension) {
  constexpr std::array<std::string_view, 8> kHarmlessPrefixes = {
      "KHR_mesh_quantization", "KHR_materials_", "KHR_texture_transform", "KHR_lights_",
      "EXT_texture_",          "EXT_lights_",    "MSFT_texture_dds",      "KHR_xmp"};
  return std::any_of(kHarmlessPrefixes.begin(), kHarmlessPrefixes.end(),
                     [&](std::string_view prefix) { return extension.starts_with(prefix); });
}

void check_required_extensions(const json& document) {
  for (const json& entry : array_in(document, "extensionsRequired")) {
    const std::string name = entry.is_string() ? entry.get<std::string>() : entry.dump();
    if (keeps_geometry(name)) continue;
    if (name == "KHR_draco_mesh_compression") {
      fail("it requires Draco mesh compression ({}), which is not supported", name);
    }
    if (name == "EXT_meshopt_compression" || name == "KHR_meshopt_compression") {
      fail("it requires meshopt compression ({}), which is not supported", name);
    }
    if (name == "KHR_texture_basisu") fail("it requires KTX textures ({}), which are not supported", name);
    fail("it requires the extension {}, which is not supported", name);
  }
}

std::string percent_decoded(std::string_view uri) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
  };
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      decoded.push_back(static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2])));
      i += 2;
    } else {
      decoded.push_back(uri[i]);
    }
  }
  return decoded;
}

Bytes bytes_behind_uri(const std::string& uri, std::size_t buffer, const std::filesystem::path& folder) {
  if (uri.starts_with("data:")) {
    Bytes bytes;
    std::string mime_type;
    if (!tinygltf::IsDataURI(uri) || !tinygltf::DecodeDataURI(&bytes, mime_type, uri, 0, false)) {
      fail("the data URI of buffer {} cannot be decoded", buffer);
    }
    return bytes;
  }
  const std::string name = percent_decoded(uri);
  return read_bytes(folder / std::filesystem::path(std::u8string(name.begin(), name.end())),
                    fmt::format("'{}', to which buffer {} refers,", name, buffer));
}

/// The first byteLength bytes of what holds the buffer: a file, a data URI, or the binary chunk.
Bytes read_buffer(const json& buffer, std::size_t number, const Container& container,
                  const std::filesystem::path& folder) {
  const auto length = buffer.is_object() ? buffer.find("byteLength") : buffer.end();
  if (length == buffer.end() || !length->is_number_unsigned()) fail("buffer {} has no byteLength", number);
  const std::uint64_t byte_length = length->get<std::uint64_t>();
  Bytes bytes;
  if (const auto uri = buffer.find("uri"); uri != buffer.end()) {
    if (!uri->is_string()) fail("the uri of buffer {} is not text", number);
    bytes = bytes_behind_uri(uri->get<std::string>(), number, folder);
  } else if (number == 0 && container.binary_chunk) {
    bytes.assign(container.binary_chunk->begin(), container.binary_chunk->end());
  } else {
    fail("buffer {} has no data", number);
  }
  if (byte_length > bytes.size()) {
    fail("buffer {} should have {} bytes, but only {} are there", number, byte_length, bytes.size());
  }
  bytes.resize(static_cast<std::size_t>(byte_length));
  return bytes;
}

tinygltf::Model parse_model(const json& document) {
  tinygltf::Model model;
  tinygltf::TinyGLTF parser;
  const std::string text = document.dump();
  if (text.size() > std::numeric_limits<unsigned>::max()) fail("its JSON is larger than 4 GB");
  std::string error, warning;
  bool parsed = false;
  try {
    parsed = parser.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                        static_cast<unsigned>(text.size()), "");
  } catch (const std::exception& thrown) {
    error = thrown.what();
  }
  if (!parsed) fail("it is not valid glTF: {}", error.substr(0, error.find('\n')));
  return model;
}

/// tinygltf drops primitives that it cannot read; a scene with holes would go unnoticed.
void check_nothing_dropped(const json& document, const tinygltf::Model& model) {
  const json& meshes = array_in(document, "meshes");
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    if (model.meshes[i].primitives.size() != array_in(meshes[i], "primitives").size()) {
      fail("mesh {} has a primitive without valid attributes", i);
    }
  }
}

}  // namespace

tinygltf::Model read_gltf_file(const std::filesystem::path& file) {
  const Bytes bytes = read_bytes(file, "the file");
  const Container container = split(bytes);
  json document = parse_json(container.json);
  check_version(document);
  check_required_extensions(document);

  std::vector<tinygltf::Buffer> buffers;
  for (const json& entry : array_in(document, "buffers")) {
    Bytes bytes_of_buffer = read_buffer(entry, buffers.size(), container, file.parent_path());
    buffers.emplace_back().data = std::move(bytes_of_buffer);
  }
  for (const char* part : {"buffers", "images", "textures", "samplers", "cameras", "extras", "extensions"}) {
    document.erase(part);
  }
  tinygltf::Model model = parse_model(document);
  check_nothing_dropped(document, model);
  model.buffers = std::move(buffers);
  return model;
}

}  // namespace stbvh::harness::gltf
