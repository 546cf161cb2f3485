/// What the tests of load_embree_xml() share: files made on the fly, and how a file is refused.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "harness/scenes/embree_xml/embree_xml.h"
#include "tests/harness/temporary_folder.h"

namespace stbvh::harness {

/// A triangle mesh of one triangle, with what else stands in its element.
inline std::string triangle(const std::string& more = "",
                            const std::string& positions = "0 0 0  1 0 0  0 1 0") {
  return "<TriangleMesh>" + more + "<positions>" + positions +
         "</positions><triangles>0 1 2</triangles></TriangleMesh>";
}

class EmbreeXmlTest : public TemporaryFolderTest {
 protected:
  /// A file with `content` in its <scene>.
  fs::path write_scene(const std::string& content) const {
    return write("s.xml", "<?xml version=\"1.0\"?>\n<scene>\n" + content + "\n</scene>\n");
  }

  Scene load_file(const fs::path& file) {
    warnings.clear();
    return load_embree_xml(file, [&](const std::string& sentence) { warnings.push_back(sentence); });
  }

  Scene load(const std::string& content) { return load_file(write_scene(content)); }

  /// The message with which a file is refused, without its name; empty if it loads. It is one line.
  std::string refusal_of(const fs::path& file) {
    try {
      load_file(file);
    } catch (const SceneFileError& error) {
      const std::string message = error.what();
      EXPECT_TRUE(message.starts_with(folder.string())) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      return message.substr(std::min(message.size(), file.string().size()));
    }
    return {};
  }

  void expect_refused(const std::string& content, const std::string& because) {
    const std::string message = refusal_of(write_scene(content));
    EXPECT_NE(message.find(because), std::string::npos)
        << "\"" << message << "\" for " << content.substr(0, 300);
  }

  bool warned_of(const std::string& word) const {
    return std::any_of(warnings.begin(), warnings.end(),
                       [&](const std::string& w) { return w.find(word) != std::string::npos; });
  }

  std::vector<std::string> warnings;
};

inline void expect_at(const Vec3f& p, float x, float y, float z) {
  EXPECT_FLOAT_EQ(p.x, x);
  EXPECT_FLOAT_EQ(p.y, y);
  EXPECT_FLOAT_EQ(p.z, z);
}

inline bool same_bits(const VertexBuffer& a, const VertexBuffer& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3f)) == 0;
}

}  // namespace stbvh::harness
