#include "harness/scenes/gltf/gltf_file.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
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

/// The first `most` bytes of a file, or all where it has less.
Bytes read_bytes(const std::filesystem::path& file, std::string_view what,
                 std::size_t most = std::numeric_limits<std::size_t>::max()) {
  try {
    const InputFile input(file, std::numeric_limits<std::uint32_t>::max());
    Bytes bytes(std::min(input.size(), most));
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

/// Whether meshopt compression says that it has no bytes of its own.
bool is_compressed_alone(const JsonObject& buffer) {
  return std::ranges::any_of(kMeshopt, [&](std::string_view name) {
    const auto compression = buffer.extension(name.data());
    return compression && compression->flag("fallback").value_or(false);
  });
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

/// Reads what buffers consist of: files, data URIs, and the binary chunk. What several buffers name is read
/// once, and of each no more than the longest of them needs.
class BufferReader {
 public:
  BufferReader(const Container& container, const std::filesystem::path& folder)
      : container_(container), folder_(folder) {}

  /// Says what will be read. Throws Problem.
  void announce(const JsonObject& buffer, std::size_t number) {
    const std::size_t length = buffer.required_whole_number("byteLength");
    Source& source = sources_[name_of(buffer, number)];
    if (length <= source.length) return;
    bytes_ += static_cast<double>(length - source.length);
    source.length = length;
  }

  /// Throws Problem where all that will be read is too long.
  void check_length() const {
    if (bytes_ > double{kMaxSceneFileBytes})
      fail("its buffers have more than {} GB", kMaxSceneFileBytes >> 30);
  }

  /// Throws Problem where there are fewer bytes than the buffer says.
  void read(const JsonObject& buffer, std::size_t number, Model& model) {
    Source& source = sources_[name_of(buffer, number)];
    if (!source.bytes) {
      source.bytes = std::make_shared<const Bytes>(read_source(buffer, number, source.length));
      model.bytes += source.bytes->size();
    }
    const std::size_t length = buffer.required_whole_number("byteLength");
    if (length > source.bytes->size())
      fail("buffer {} should have {} bytes, but only {} are there", number, length, source.bytes->size());
    model.buffers[number].source = source.bytes;
    model.buffers[number].bytes = std::span(*source.bytes).first(length);
  }

 private:
  struct Source {
    std::size_t length = 0;  ///< bytes that are needed of it
    std::shared_ptr<const Bytes> bytes;
  };

  std::filesystem::path file_of(const std::string& uri) const {
    const std::string name = percent_decoded(uri);
    return folder_ / std::filesystem::path(std::u8string(name.begin(), name.end()));
  }

  /// The same for all buffers that consist of the same.
  std::string name_of(const JsonObject& buffer, std::size_t number) const {
    if (!buffer.has("uri")) {
      if (is_compressed_alone(buffer))
        fail("buffer {} is there only with meshopt compression, which is not supported", number);
      if (number != 0 || !container_.binary_chunk) fail("buffer {} has no data", number);
      return {};
    }
    const std::string uri = buffer.text("uri");
    if (is_data_uri(uri)) return uri;
    if (has_scheme(uri))
      fail("buffer {} refers to '{}', but only files beside it and data URIs are read", number, uri);
    if (percent_decoded(uri).find('\0') != std::string::npos)
      fail("the URI of buffer {} has a zero byte", number);
    std::error_code is_nowhere;
    const std::filesystem::path file = file_of(uri), found = weakly_canonical(file, is_nowhere);
    return (is_nowhere ? file : found).string();
  }

  Bytes read_source(const JsonObject& buffer, std::size_t number, std::size_t length) const {
    if (!buffer.has("uri")) {
      const auto chunk = container_.binary_chunk->first(std::min(length, container_.binary_chunk->size()));
      return {chunk.begin(), chunk.end()};
    }
    const std::string uri = buffer.text("uri");
    if (!is_data_uri(uri)) {
      const std::string what = fmt::format("'{}', to which buffer {} refers,", percent_decoded(uri), number);
      return read_bytes(file_of(uri), what, length);
    }
    std::optional<Bytes> bytes = decode_data_uri(uri);
    if (!bytes) fail("the data URI of buffer {} cannot be decoded", number);
    return std::move(*bytes);
  }

  const Container& container_;
  const std::filesystem::path& folder_;
  std::map<std::string, Source> sources_;
  double bytes_ = 0;
};

void read_buffers(const JsonObject& document, const Container& container, const std::filesystem::path& folder,
                  Model& model) {
  const std::vector<JsonObject> sources = document.objects("buffers");
  const std::vector<bool> used = used_buffers(model, sources.size());
  model.buffers.resize(sources.size());
  BufferReader reader(container, folder);
  // What is wrong with one is of concern only where it is used.
  const auto for_used = [&](const auto& body) {
    for (std::size_t i = 0; i < sources.size(); ++i) {
      if (!used[i] || !model.buffers[i].problem.empty()) continue;
      check_cancelled();
      try {
        body(i);
      } catch (const Problem& problem) {
        model.buffers[i].problem = problem.what();
      }
    }
  };
  for (const JsonObject& source : sources) source.whole_number("byteLength");  // has the right type
  for_used([&](std::size_t i) { reader.announce(sources[i], i); });
  reader.check_length();
  for_used([&](std::size_t i) { reader.read(sources[i], i, model); });
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
