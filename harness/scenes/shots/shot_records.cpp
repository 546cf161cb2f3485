#include "harness/scenes/shots/shot_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <string_view>

#include "harness/scenes/scene_file.h"

namespace stbvh::harness::shots {
namespace {

static_assert(std::endian::native == std::endian::little, "records are read as they stand");

constexpr std::string_view kMagic = "STBVSHT1";
/// What the records of meshes may be larger than their positions.
constexpr std::size_t kMostBytes = kMaxSceneFileBytes + kMaxSceneTextBytes;
constexpr std::size_t kMostTextBytes = 1 << 20;
/// Ray times below this are 0: floats from here on are as far apart as steps must be (MeshView).
constexpr float kLeastTime = 0x1p-100f;

void check_times(const std::vector<float>& times) {
  float last = -1;
  for (const float time : times) {
    const bool is_ray_time = time == 0 || (time >= kLeastTime && time <= 1);
    if (!is_ray_time || !(time > last)) throw BadRecord("steps at times that do not go up from 0 to 1");
    last = time;
  }
}

void check_faces(const SubdivisionCage& cage) {
  std::size_t corners = 0;
  for (const std::uint32_t size : cage.face_sizes) corners += size;
  const std::size_t vertices = cage.steps.front().size();
  const bool are_there =
      std::ranges::all_of(cage.face_vertices, [=](std::uint32_t vertex) { return vertex < vertices; });
  if (corners != cage.face_vertices.size() || !are_there)
    throw BadRecord("faces with corners that are not there");
}

SubdivisionCage::Boundary boundary(std::uint32_t number) {
  if (number > 2) throw BadRecord("a boundary of another kind");
  using Boundary = SubdivisionCage::Boundary;
  return std::array{Boundary::kNone, Boundary::kEdgeOnly, Boundary::kEdgeAndCorner}[number];
}

}  // namespace

RecordFile::RecordFile(const std::filesystem::path& path) : file_(path, kMostBytes) {
  std::array<char, kMagic.size()> magic{};
  if (file_.size() < magic.size()) throw BadRecord("nothing");
  file_.read(0, magic);
  if (std::string_view(magic.data(), magic.size()) != kMagic) throw BadRecord("another kind of file");
  at_ = end_ = magic.size();
}

bool RecordFile::next() {
  struct Head {
    std::uint32_t tag, zeros;
    std::uint64_t bytes;
  } head;
  at_ = end_;
  if (file_.size() - at_ < sizeof head) return false;
  file_.read(at_, {reinterpret_cast<char*>(&head), sizeof head});
  if (head.bytes > file_.size() - at_ - sizeof head) return false;
  at_ += sizeof head;
  end_ = at_ + head.bytes;
  tag_ = Tag{head.tag};
  return true;
}

void RecordFile::read(void* to, std::size_t bytes) {
  if (bytes > left()) throw BadRecord("a record that ends early");
  file_.read(at_, {static_cast<char*>(to), bytes});
  at_ += bytes;
}

template <class T>
T RecordFile::number() {
  T value;
  read(&value, sizeof value);
  return value;
}

std::size_t RecordFile::checked_count(std::uint64_t count, std::size_t bytes_each) const {
  if (count > left() / bytes_each) throw BadRecord("a record that ends early");
  return count;
}

template <class T>
std::vector<T> RecordFile::numbers(std::uint64_t count) {
  std::vector<T> values(checked_count(count, sizeof(T)));
  read(values.data(), values.size() * sizeof(T));
  return values;
}

Vec3f RecordFile::vector() {
  return number<Vec3f>();
}

std::string RecordFile::name(std::uint32_t bytes) {
  std::string text(checked_count(bytes, 1), '\0');
  read(text.data(), text.size());
  return text;
}

MeshRecord RecordFile::mesh() {
  MeshRecord mesh;
  const auto name_bytes = number<std::uint32_t>(), scheme = number<std::uint32_t>();
  mesh.is_cage = scheme != 0;
  SubdivisionCage& cage = mesh.cage;
  cage.scheme = scheme == 2 ? SubdivisionCage::Scheme::kLoop : SubdivisionCage::Scheme::kCatmullClark;
  cage.boundary = boundary(number<std::uint32_t>());
  number<std::uint32_t>();  // zeros
  struct Counts {
    std::uint64_t vertices, faces, corners, steps, creases, sharp_vertices, holes;
  };
  const auto counts = number<Counts>();
  mesh.material.color = vector();
  mesh.material.emission = vector();
  mesh.name = name(name_bytes);
  cage.face_sizes = numbers<std::uint32_t>(counts.faces);
  cage.face_vertices = numbers<std::uint32_t>(counts.corners);
  const auto edges = numbers<std::array<std::uint32_t, 2>>(counts.creases);
  const auto edge_sharpness = numbers<float>(counts.creases);
  for (std::size_t i = 0; i < edges.size(); ++i)
    cage.edge_creases.push_back({edges[i][0], edges[i][1], edge_sharpness[i]});
  const auto vertices = numbers<std::uint32_t>(counts.sharp_vertices);
  const auto vertex_sharpness = numbers<float>(counts.sharp_vertices);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    cage.vertex_creases.push_back({vertices[i], vertex_sharpness[i]});
  cage.holes = numbers<std::uint32_t>(counts.holes);
  if (counts.steps < 1 || counts.steps > kMaxSteps) throw BadRecord(fmt::format("{} steps", counts.steps));
  if (counts.steps > 1) mesh.step_times = numbers<float>(counts.steps);
  check_times(mesh.step_times);
  for (std::uint64_t step = 0; step < counts.steps; ++step) {
    VertexBuffer& positions = cage.steps.emplace_back(checked_count(counts.vertices, sizeof(Vec3f)));
    read(positions.data(), positions.size() * sizeof(Vec3f));
  }
  check_faces(cage);
  return mesh;
}

std::vector<Camera> RecordFile::camera() {
  struct Step {
    Vec3f position, target, up;
    float fov;
  };
  std::vector<Camera> cameras;
  for (const Step& step : numbers<Step>(left() / sizeof(Step)))
    cameras.push_back({step.position, step.target, step.up, step.fov});
  return cameras;
}

DirectionalLight RecordFile::sun() {
  const Vec3f direction = vector(), irradiance = vector();
  return {direction, irradiance, number<float>()};
}

Vec3f RecordFile::sky() {
  return vector();
}

std::string RecordFile::text() {
  return name(static_cast<std::uint32_t>(std::min(left(), kMostTextBytes)));
}

}  // namespace stbvh::harness::shots
