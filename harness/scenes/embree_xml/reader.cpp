#include "harness/scenes/embree_xml/reader.h"

#include <algorithm>
#include <map>
#include <new>
#include <string_view>

#include "harness/files/input_file.h"
#include "harness/scenes/cancellation.h"
#include "harness/scenes/embree_xml/disc_light.h"
#include "harness/scenes/embree_xml/document.h"
#include "harness/scenes/embree_xml/material.h"
#include "harness/scenes/embree_xml/mesh_reader.h"
#include "harness/scenes/light_check.h"
#include "harness/scenes/reach.h"
#include "harness/scenes/scene_file.h"

namespace stbvh::harness::embree_xml {
namespace {

constexpr std::size_t kMaxDepth = 200;  // of elements inside each other

class Reader {
 public:
  Reader(const std::filesystem::path& file, Document& document, const Warn& warn)
      : file_(file), document_(document), warn_(warn), materials_(warn_) {}

  NodePtr read_scene() {
    const NodePtr scene = group_of(document_.scene());
    if (!left_out_.empty()) {
      std::string list;
      for (const auto& [name, count] : left_out_)
        list += fmt::format("{}{} <{}>", list.empty() ? "" : ", ", count, name);
      warn_(fmt::format("{}: left out, as it cannot be shown: {}.", file_.string(), list));
    }
    materials_.tell_undefined(file_);
    tell(losses_.cages, "cages without a face to show");
    tell(losses_.faces, "faces of cages with fewer than three corners, or one corner twice");
    tell(losses_.creases, "creases of cages where no edge is");
    return scene;
  }

 private:
  void tell(std::size_t count, const char* what) {
    if (count > 0) warn_(fmt::format("{}: left out: {}: {}.", file_.string(), what, count));
  }

  /// A node, or null where there is nothing to show.
  NodePtr read(pugi::xml_node element) {
    const std::string_view name = element.name();
    if (name == "ref") return referenced(element);
    if (++depth_ > kMaxDepth) fail(element, "its elements are nested more than {} deep", kMaxDepth);
    const NodePtr node = name == "assign" ? read_assignment(element) : read_named(element, name);
    --depth_;
    if (name == "assign") return node;  // its id is that of what stands in it
    if (const std::string id = element.attribute("id").value(); !id.empty()) by_id_[id] = node;
    return node;
  }

  NodePtr read_named(pugi::xml_node element, std::string_view name) {
    if (name == "Group") return group_of(element);
    if (name == "Flatten") return flattened(element);
    if (name == "TimeRange") return in_time_range(element);
    if (name == "Transform" || name == "Transform2" || name == "TransformAnimation")
      return transform(element);
    if (name == "MultiTransform") return instances(element);
    if (name == "TriangleMesh") return mesh(element, read_triangle_mesh(document_, element));
    if (name == "QuadMesh") return mesh(element, read_quad_mesh(document_, element));
    if (name == "SubdivisionMesh")
      return mesh(element, read_subdivision_mesh(document_, element, warn_, losses_));
    if (name == "QuadLight") return lamp(element, read_quad_light(document_, element));
    if (name == "TriangleLight") return lamp(element, read_triangle_light(document_, element));
    if (name == "AmbientLight") return make_leaf(AmbientLight{read_color(document_, element, "L")});
    if (name == "DirectionalLight" || name == "DistantLight") return directional_light(element, name);
    if (name == "PerspectiveCamera") return camera(element);
    if (name == "AnimatedPerspectiveCamera" || name == "AnimatedLight") return first_key(element);
    ++left_out_[std::string(name)];
    return nullptr;
  }

  NodePtr read_assignment(pugi::xml_node element) {
    const std::string type = element.attribute("type").value(), id = element.attribute("id").value();
    const pugi::xml_node child =
        element.find_child([](pugi::xml_node n) { return n.type() == pugi::node_element; });
    if (type == "material") {
      materials_.define(id, child);
    } else if (type == "scene") {
      const NodePtr node = child ? read(child) : nullptr;
      if (!id.empty()) by_id_[id] = node;
    } else {
      fail(element, "an <assign> has the type \"{}\", which is neither \"scene\" nor \"material\"", type);
    }
    return nullptr;
  }

  NodePtr referenced(pugi::xml_node element) {
    const std::string id = element.attribute("id").value();
    const auto found = by_id_.find(id);
    if (found == by_id_.end()) fail(element, "a <ref> names \"{}\", which is not defined before it", id);
    return found->second;
  }

  void add(Node& parent, const NodePtr& child, pugi::xml_node at) {
    if (!add_child(parent, child)) fail(at, "its nodes are nested more than {} deep", kMaxHeight);
  }

  /// Reads all children of `element` from `first` on.
  void add_children(Node& parent, pugi::xml_node first) {
    for (pugi::xml_node child = first; child; child = child.next_sibling()) {
      check_cancelled();
      if (child.type() == pugi::node_element) add(parent, read(child), child);
    }
  }

  NodePtr group_of(pugi::xml_node element) {
    auto node = std::make_shared<Node>();
    add_children(*node, element.first_child());
    return node;
  }

  NodePtr transform(pugi::xml_node element) {
    auto node = std::make_shared<Node>();
    Transform& keys = node->content.emplace<Transform>();
    pugi::xml_node child = element.first_child();
    for (; child; child = child.next_sibling()) {
      if (child.type() != pugi::node_element) continue;
      const std::string_view name = child.name();
      if (name == "Quaternion") {
        ++left_out_[fmt::format("{} of Quaternion", element.name())];
        return nullptr;
      }
      if (name != "AffineSpace") break;
      if (keys.keys.size() == kMaxSceneSteps)
        fail(element, "a <{}> has more than {} keys", element.name(), kMaxSceneSteps);
      keys.keys.push_back(read_affine_space(document_, child));
    }
    if (keys.keys.empty()) fail(element, "a <{}> does not begin with an <AffineSpace>", element.name());
    add_children(*node, child);
    return node;
  }

  /// The same children, once for each map of an array.
  NodePtr instances(pugi::xml_node element) {
    pugi::xml_node child =
        element.find_child([](pugi::xml_node n) { return n.type() == pugi::node_element; });
    if (std::string_view(child.name()).starts_with("Quaternion") ||
        element.attribute("time_steps").as_int(1) != 1) {
      ++left_out_["MultiTransform that moves"];
      return nullptr;
    }
    const std::vector<Affine> maps = document_.affine_columns(child);
    auto below = std::make_shared<Node>();
    add_children(*below, child.next_sibling());
    auto node = std::make_shared<Node>();
    if (below->leaves == 0) return node;
    for (const Affine& map : maps) {
      auto instance = std::make_shared<Node>();
      instance->content.emplace<Transform>().keys.push_back(map);
      add(*instance, below, element);
      add(*node, instance, element);
    }
    return node;
  }

  NodePtr flattened(pugi::xml_node element) {
    const FlatScene flat = flatten(*group_of(element));
    auto node = std::make_shared<Node>();
    for (const Mesh& mesh : flat.meshes) add(*node, make_leaf(mesh), element);
    for (const DirectionalLight& light : flat.directional_lights) add(*node, make_leaf(light), element);
    if (flat.ambient) add(*node, make_leaf(AmbientLight{*flat.ambient}), element);
    for (const NamedCamera& camera : flat.cameras) add(*node, make_leaf(camera), element);
    return node;
  }

  NodePtr in_time_range(pugi::xml_node element) {
    const std::vector<float> time = float_attribute(element, "time", 2);
    if (!(time[0] < time[1])) fail(element, "a <TimeRange> ends at {}, where it begins or before", time[1]);
    const NodePtr node = group_of(element);
    set_time_range(*node, {time[0], time[1]});
    return node;
  }

  NodePtr mesh(pugi::xml_node element, Mesh read) {
    read.material = materials_.read(element.child("material"));
    return lamp(element, std::move(read));
  }

  NodePtr lamp(pugi::xml_node element, Mesh read) {
    if (read.indices.empty()) return nullptr;
    read.name = element.attribute("name").value();
    if (read.name.empty()) read.name = fmt::format("{} {}", element.name(), ++unnamed_);
    return make_leaf(std::move(read));
  }

  NodePtr directional_light(pugi::xml_node element, std::string_view name) {
    const Affine space = read_affine_space(document_, element.child("AffineSpace"));
    DirectionalLight light;
    light.direction = {static_cast<float>(space.row[0][2]), static_cast<float>(space.row[1][2]),
                       static_cast<float>(space.row[2][2])};
    if (name == "DirectionalLight") {
      light.irradiance = read_color(document_, element, "E");
    } else {
      const std::vector<float> angle = document_.floats(element.child("halfAngle"), 1);
      if (angle.size() != 1 || !is_half_angle(angle[0]))
        fail(element, "a <DistantLight> needs a halfAngle above 0 and up to 90 degrees");
      light.irradiance = scaled(read_color(document_, element, "L"), projected_solid_angle(angle[0]));
      light.half_angle_degrees = angle[0];
    }
    if (const std::string flaw = flaw_of(light); !flaw.empty()) fail(element, "a <{}> {}", name, flaw);
    return make_leaf(light);
  }

  NodePtr camera(pugi::xml_node element) {
    const auto point = [&](const char* name) {
      const std::vector<float> values = float_attribute(element, name, 3);
      const Vec3f p{values[0], values[1], values[2]};
      if (!is_within_reach(to_double(p)))
        fail(element, "the {} of a <PerspectiveCamera> is too far away", name);
      return p;
    };
    const float fov = float_attribute(element, "fov", 1)[0];
    if (!(fov > 0 && fov < 180)) fail(element, "a <PerspectiveCamera> has a fov of {} degrees", fov);
    return make_leaf(
        NamedCamera{element.attribute("name").value(), {point("from"), point("to"), point("up"), fov}});
  }

  NodePtr first_key(pugi::xml_node element) {
    const NodePtr all = group_of(element);
    warn_(fmt::format("An <{}> stands still, at its first key.", element.name()));
    return all->children.empty() ? nullptr : all->children.front();
  }

  const std::filesystem::path& file_;
  Document& document_;
  const Warn& warn_;
  MaterialReader materials_;
  std::map<std::string, NodePtr> by_id_;
  std::map<std::string, std::size_t> left_out_;  ///< how many of each kind of element
  CageLosses losses_;
  std::size_t depth_ = 0;
  std::size_t unnamed_ = 0;
};

}  // namespace

NodePtr read_file(const std::filesystem::path& file, const Warn& warn) {
  const std::string name = file.string();
  try {
    std::optional<Document> document;
    try {
      document.emplace(file);
      return Reader(file, *document, warn).read_scene();
    } catch (const Problem& problem) {
      const std::string place = document ? document->place(problem.offset) : "";
      throw SceneFileError(fmt::format("{}{}: {}", name, place, problem.what()));
    }
  } catch (const InputFileError& problem) {
    throw SceneFileError(fmt::format("{}: it {}", name, problem.what()));
  } catch (const std::bad_alloc&) {
    throw SceneFileError(fmt::format("{}: there is not enough memory for it", name));
  }
}

}  // namespace stbvh::harness::embree_xml
