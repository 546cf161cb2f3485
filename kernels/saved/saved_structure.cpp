#include "stbvh/saved_structure.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <optional>
#include <system_error>
#include <utility>

#include "builder/build_mesh.h"
#include "content_hash.h"
#include "isolated.h"
#include "layout/time_grid.h"
#include "saved/file_format.h"
#include "saved/tables.h"
#include "saved/tree_walk.h"
#include "stored_tree.h"

namespace stbvh {

namespace {

template <typename T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

std::size_t padded(std::size_t bytes) {
  return (bytes + kHeaderBytes - 1) / kHeaderBytes * kHeaderBytes;
}

std::span<const std::byte> bytes_of(const FileHeader& header) {
  return std::as_bytes(std::span(&header, 1));
}

ContentHash hash_of_header(FileHeader header) {
  header.hash_of_header = {};
  return hash_of(bytes_of(header));
}

// Writing ---------------------------------------------------------------------------------------------------

/// Everything behind the header, hashed on its way.
class HashedBody {
 public:
  explicit HashedBody(std::size_t bytes) { hashes_.reserve(bytes / kHashedBytes + 1); }

  void add(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const std::size_t some = std::min(bytes.size(), kHashedBytes - used_);
      hasher_.add(bytes.first(some));
      used_ += some;
      bytes = bytes.subspan(some);
      if (used_ == kHashedBytes) finish();
    }
  }
  void finish() {
    if (used_ == 0) return;
    hashes_.push_back(hasher_.hash());
    hasher_ = {};
    used_ = 0;
  }
  const std::vector<ContentHash>& hashes() const { return hashes_; }

 private:
  std::vector<ContentHash> hashes_;
  ContentHasher hasher_;
  std::size_t used_ = 0;
};

std::size_t buffer_bytes(const MeshView& mesh) {
  return kElementBytes * (mesh.triangle_count + mesh.steps.size() * mesh.steps[0].count);
}

template <typename Use>
void for_each_buffer(const MeshView& mesh, const Use& use) {
  for_each_piece(mesh.indices, mesh.triangle_count, mesh.index_stride, use);
  for (const VertexBufferView& step : mesh.steps) for_each_piece(step.data, step.count, step.stride, use);
}

void add_mesh(TableWriter& table, const MeshView& mesh, const MeshFingerprint& fingerprint) {
  table.add(std::uint64_t{mesh.triangle_count});
  table.add(std::uint64_t{mesh.steps[0].count});
  table.add(std::uint64_t{mesh.steps.size()});
  table.add(mesh.time_range);
  table.add(mesh.mask);
  table.add(mesh.geom_id);
  table.add(fingerprint);
  table.add(std::uint64_t{mesh.step_times.size()});
  for (const float time : mesh.step_times) table.add(time);
}

void add_record(TableWriter& table, const MeshEntry& entry, std::uint32_t mesh) {
  table.add(std::uint32_t{entry.is_used});
  table.add(mesh);
  table.add(std::uint32_t{entry.is_part});
  table.add(entry.time_range);
  table.add(entry.bounds);
  table.add(std::uint64_t{entry.triangles});
  table.add(std::uint64_t{entry.invalid_triangles});
  table.add(std::uint64_t{entry.primitive_segments});
  table.add(entry.deviation);
  table.add(std::uint64_t{entry.kept.size()});
  for (const std::size_t step : entry.kept) table.add(static_cast<std::uint32_t>(step));
  table.add(std::uint64_t{entry.step_times.size()});
  for (const float time : entry.step_times) table.add(time);
}

}  // namespace

void save_structure(const Structure& structure, std::span<const MeshView> meshes, const SaveOptions& options,
                    const std::function<void(std::span<const std::byte>)>& write) {
  const StoredTree& tree = structure.stored();
  const OrderedBlock block = in_order(tree);
  const std::vector<MeshFingerprint> fingerprints = fingerprints_of(meshes);
  TableWriter table;
  std::size_t buffers = 0;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    add_mesh(table, meshes[i], fingerprints[i]);
    if (options.with_buffers) buffers += buffer_bytes(meshes[i]);
  }
  for (std::uint32_t record = 0; record < tree.meshes.size(); ++record)
    add_record(table, tree.meshes.entry(record), tree.meshes.record(record).index);

  FileHeader header;
  std::memset(static_cast<void*>(&header), 0, sizeof header);  // what lies between members is hashed too
  header.magic = kFileMagic;
  header.version = kFileVersion;
  std::size_t end = kHeaderBytes;
  const auto placed = [&end](std::size_t bytes) {
    const FileSection section{end, bytes};
    end += padded(bytes);
    return section;
  };
  header.is_empty = tree.is_empty ? 1 : 0;
  header.block = placed(block.bytes.size());
  header.tables = placed(table.bytes().size());
  header.has_buffers = options.with_buffers ? 1 : 0;
  header.buffers = placed(buffers);
  header.user = placed(options.user_data.size());
  HashedBody body(end);
  header.indexed_bytes = block.indexed_bytes;
  header.mesh_count = meshes.size();
  header.record_count = tree.meshes.size();
  header.max_bytes = tree.settings.max_bytes;
  header.max_peak_bytes = tree.settings.max_peak_bytes;
  header.wanted_bytes = structure.statistics().wanted_bytes;
  header.temporal_splits = tree.temporal_splits;
  header.usual_area = tree.usual_area;
  header.tolerance = tree.settings.tolerance;
  header.precision = static_cast<std::uint32_t>(tree.settings.precision);
  header.root = tree.root;
  header.root.link = block.root;

  const std::vector<std::byte> zeros(kHeaderBytes);
  // Twice over everything: the header, which comes first, has the hash of the hashes of what follows.
  const auto for_each_part = [&](const auto& use) {
    const auto pad = [&](std::size_t bytes) { use(std::span(zeros).first(padded(bytes) - bytes)); };
    use(std::span<const std::byte>(block.bytes));
    pad(block.bytes.size());
    use(table.bytes());
    pad(table.bytes().size());
    for (const MeshView& mesh : meshes) {
      if (options.with_buffers) for_each_buffer(mesh, use);
    }
    pad(buffers);
    use(options.user_data);
    pad(options.user_data.size());
  };
  for_each_part([&](std::span<const std::byte> bytes) { body.add(bytes); });
  body.finish();
  header.hashes = placed(body.hashes().size() * sizeof(ContentHash));
  header.file_bytes = end;
  header.hash_of_hashes = hash_of(bytes_of(body.hashes()));
  header.hash_of_header = hash_of_header(header);

  write(bytes_of(header));
  write(std::span(zeros).first(kHeaderBytes - sizeof header));
  for_each_part([&](std::span<const std::byte> bytes) {
    if (!bytes.empty()) write(bytes);
  });
  write(bytes_of(body.hashes()));
  write(std::span(zeros).first(padded(header.hashes.bytes) - header.hashes.bytes));
}

// Reading ---------------------------------------------------------------------------------------------------

namespace {

void require(bool condition, const char* problem) {
  if (!condition) throw BadStructureFile(problem);
}

/// Of a file of `bytes` bytes.
void check_header(const FileHeader& header, std::size_t bytes) {
  require(header.magic == kFileMagic, "is not a structure of STBVH");
  require(header.version == kFileVersion, "is of another version of STBVH");
  require(header.hash_of_header == hash_of_header(header), "is damaged (its header)");
  require(header.file_bytes <= bytes, "is truncated");
  std::size_t end = kHeaderBytes;
  for (const FileSection& section :
       {header.block, header.tables, header.buffers, header.user, header.hashes}) {
    const bool fits = section.offset == end && section.bytes <= bytes - std::min(bytes, end);
    require(fits, "is damaged (its header)");
    end += padded(section.bytes);
    require(end <= bytes, "is truncated");
  }
  require(end == header.file_bytes && end == bytes, "has another length than it says");
}

class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& file)
      : descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~OpenFile() {
    if (descriptor >= 0) ::close(descriptor);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  const int descriptor;
};

/// A file in memory, aligned to pages.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& file) {
    const auto fail = [&] { throw std::system_error(errno, std::generic_category(), file.string()); };
    const OpenFile opened(file);
    struct stat status {};
    if (opened.descriptor < 0 || ::fstat(opened.descriptor, &status) != 0) fail();
    require(S_ISREG(status.st_mode), "is not a file");
    bytes_ = static_cast<std::size_t>(status.st_size);
    require(bytes_ >= kHeaderBytes, "is truncated");
    // Before addresses are taken for all of it: a file may have any size.
    FileHeader header;
    const ssize_t read = ::pread(opened.descriptor, static_cast<void*>(&header), sizeof header, 0);
    if (read < 0) fail();
    require(read == sizeof header, "is truncated");
    check_header(header, bytes_);
    // Updates change nodes where they are: in this process alone.
    void* const data = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE, opened.descriptor, 0);
    if (data == MAP_FAILED) fail();
    data_ = static_cast<std::byte*>(data);
  }
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes.size()) {
    require(bytes_ >= kHeaderBytes, "is truncated");
    void* const data = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (data == MAP_FAILED) throw std::bad_alloc();
    data_ = static_cast<std::byte*>(data);
    std::memcpy(data_, bytes.data(), bytes_);
  }
  ~MappedFile() {
    if (data_ != nullptr) ::munmap(data_, bytes_);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<std::byte> bytes() const { return {data_, bytes_}; }

 private:
  std::byte* data_ = nullptr;
  std::size_t bytes_ = 0;
};

FileHeader checked_header(std::span<const std::byte> file) {
  FileHeader header;
  std::memcpy(static_cast<void*>(&header), file.data(), sizeof header);
  check_header(header, file.size());
  return header;
}

void check_hashes(std::span<const std::byte> file, const FileHeader& header) {
  const std::span<const std::byte> hashes = file.subspan(header.hashes.offset, header.hashes.bytes);
  const std::span<const std::byte> body = file.subspan(kHeaderBytes, header.hashes.offset - kHeaderBytes);
  const std::size_t chunks = (body.size() + kHashedBytes - 1) / kHashedBytes;
  require(hashes.size() == chunks * sizeof(ContentHash), "is damaged (its header)");
  require(hash_of(hashes) == header.hash_of_hashes, "is damaged (its checksums)");
  std::atomic<bool> is_damaged{false};
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t i) {
    ContentHash expected;
    std::memcpy(&expected, hashes.data() + i * sizeof expected, sizeof expected);
    const std::size_t first = i * kHashedBytes;
    if (hash_of(body.subspan(first, std::min(kHashedBytes, body.size() - first))) != expected)
      is_damaged.store(true, std::memory_order_relaxed);
  });
  require(!is_damaged.load(), "is damaged");
}

/// A mesh as it was saved.
struct SavedMesh {
  std::size_t step_count = 0;
  std::vector<VertexBufferView> steps;  ///< empty where there are no vertices in the file
  std::vector<float> step_times;
  MeshFingerprint fingerprint;
};

struct SavedRecord {
  MeshEntry entry;
  MeshRecord record{};
};

constexpr std::size_t kLeastMeshBytes = 80, kLeastRecordBytes = 92;
constexpr const char* kBadTable = "has a table of meshes that is not one";

}  // namespace

class SavedStructure::Impl {
 public:
  template <typename From>
  explicit Impl(const From& from)
      : file_(std::make_shared<MappedFile>(from)), header_(checked_header(bytes())) {
    check_hashes(bytes(), header_);
    TableReader table(section(header_.tables));
    // None of them takes less, so that a small file cannot ask for much.
    require(header_.mesh_count <= header_.tables.bytes / kLeastMeshBytes &&
                header_.record_count <= header_.tables.bytes / kLeastRecordBytes,
            kBadTable);
    require(header_.precision <= 1 && (header_.tolerance == kKeepAllSteps ||
                                       (header_.tolerance >= 0.0f && std::isfinite(header_.tolerance))),
            kBadTable);
    std::size_t buffer = 0;
    meshes_.resize(header_.mesh_count);
    for (SavedMesh& mesh : meshes_) views_.push_back(read_mesh(table, mesh, buffer));
    require(!has_buffers() || buffer == header_.buffers.bytes, kBadTable);
    for (std::size_t i = 0; i < header_.record_count; ++i) records_.push_back(read_record(table));
    require(table.is_at_end(), kBadTable);
  }

  BuildSettings settings() const {
    BuildSettings settings;
    settings.max_bytes = header_.max_bytes;
    settings.max_peak_bytes = header_.max_peak_bytes;
    settings.precision = static_cast<Precision>(header_.precision);
    settings.tolerance = header_.tolerance;
    return settings;
  }
  bool has_buffers() const { return header_.has_buffers != 0; }
  std::span<const MeshView> views() const { return views_; }
  std::span<const std::byte> user_data() const { return section(header_.user); }

  std::unique_ptr<Structure> structure(std::span<const MeshView> meshes, bool is_own) const {
    if (!is_own) check_meshes(meshes);
    require(!is_own || has_buffers(), "holds no triangles: meshes are needed");
    // The mapping lives as long as a structure in it.
    const auto release = [file = file_](void*, std::size_t) {};
    const std::span<std::byte> block = file_->bytes().subspan(header_.block.offset, header_.block.bytes);
    StoredTree tree(settings(), Block(block.data(), block.size(), release));
    std::vector<MeshView> mesh_of_record;
    for (const SavedRecord& saved : records_) {
      tree.meshes.restore(saved.entry, saved.record);
      if (saved.entry.is_used) {
        const auto record = static_cast<std::uint32_t>(mesh_of_record.size());
        mesh_of_record.push_back(meshes[saved.record.index]);
        tree.meshes.refresh(record, mesh_of_record.back(), saved.record.index);
      } else {
        mesh_of_record.emplace_back();
      }
    }
    tree.is_empty = header_.is_empty != 0;
    tree.root = header_.root;
    require(!tree.is_empty || block.empty(), "has a tree that is not one");
    if (!tree.is_empty)
      tree.counts = checked_counts(block, header_.indexed_bytes, tree.root, tree.meshes, mesh_of_record);
    require(std::isfinite(header_.usual_area), "has a tree that is not one");
    tree.usual_area = header_.usual_area;
    tree.temporal_splits = header_.temporal_splits;
    tree.indexed_leaf_bytes = header_.indexed_bytes;
    return structure_of(std::move(tree), header_.wanted_bytes);
  }

 private:
  std::span<const std::byte> bytes() const { return file_->bytes(); }
  std::span<const std::byte> section(const FileSection& section) const {
    return bytes().subspan(section.offset, section.bytes);
  }

  MeshView read_mesh(TableReader& table, SavedMesh& mesh, std::size_t& buffer) const {
    MeshView view;
    view.triangle_count = table.take<std::uint64_t>();
    const auto vertices = table.take<std::uint64_t>();
    const auto steps = table.take<std::uint64_t>();
    view.time_range = table.take<TimeRange>();
    view.mask = table.take<std::uint32_t>();
    view.geom_id = table.take<std::uint32_t>();
    mesh.fingerprint = table.take<MeshFingerprint>();
    mesh.step_times.resize(table.take_count(sizeof(float)));
    for (float& time : mesh.step_times) time = table.take<float>();
    require(view.triangle_count <= kInvalidId && vertices <= kInvalidId && steps > 0 && steps <= kMaxSteps,
            kBadTable);
    const auto next = [&](std::size_t count) -> const void* {
      if (!has_buffers()) return nullptr;
      require(count * kElementBytes <= header_.buffers.bytes - buffer, kBadTable);
      const void* const data = section(header_.buffers).data() + buffer;
      buffer += count * kElementBytes;
      return data;
    };
    view.indices = next(view.triangle_count);
    mesh.step_count = steps;
    if (has_buffers() && vertices > 0) {
      require(steps <= (header_.buffers.bytes - buffer) / (vertices * kElementBytes), kBadTable);
      for (std::size_t step = 0; step < steps; ++step)
        mesh.steps.push_back({next(vertices), vertices, kElementBytes});
      view.steps = mesh.steps;
    } else {
      static const std::vector<VertexBufferView> kNoVertices(kMaxSteps);
      view.steps = std::span(kNoVertices).first(steps);
    }
    view.step_times = mesh.step_times;
    require(!has_buffers() || problem_of(view) == nullptr, kBadTable);
    return view;
  }

  SavedRecord read_record(TableReader& table) const {
    SavedRecord saved;
    MeshEntry& entry = saved.entry;
    entry.is_used = table.take<std::uint32_t>() != 0;
    saved.record.index = table.take<std::uint32_t>();
    entry.is_part = table.take<std::uint32_t>() != 0;
    entry.time_range = table.take<TimeRange>();
    entry.bounds = table.take<Box3f>();
    entry.triangles = table.take<std::uint64_t>();
    entry.invalid_triangles = table.take<std::uint64_t>();
    entry.primitive_segments = table.take<std::uint64_t>();
    entry.deviation = table.take<double>();
    entry.kept.resize(table.take_count(sizeof(std::uint32_t)));
    for (std::size_t& step : entry.kept) step = table.take<std::uint32_t>();
    entry.step_times.resize(table.take_count(sizeof(float)));
    for (float& time : entry.step_times) time = normal_time(table.take<float>());
    if (!entry.is_used) return saved;
    require(saved.record.index < meshes_.size(), kBadTable);
    const std::size_t given = meshes_[saved.record.index].step_count;
    require(!entry.kept.empty() && entry.kept.back() < given, kBadTable);
    require(std::ranges::adjacent_find(entry.kept, std::ranges::greater_equal{}) == entry.kept.end(),
            kBadTable);
    require(entry.step_times.empty() || entry.step_times.size() == entry.kept.size(), kBadTable);
    entry.steps_given = given;
    entry.steps.resize(entry.kept.size());
    // As a mesh with these steps it must be one that could be built, whatever its buffers.
    MeshView view;
    const std::vector<VertexBufferView> none(entry.kept.size());
    view.steps = none;
    view.time_range = entry.time_range;
    view.step_times = entry.step_times;
    require(problem_of(view) == nullptr, kBadTable);
    saved.record.grid = time_grid_of(view);
    return saved;
  }

  void check_meshes(std::span<const MeshView> meshes) const {
    require(meshes.size() == meshes_.size(), "is of another number of meshes");
    for (const MeshView& mesh : meshes) {
      if (const char* const problem = problem_of(mesh)) throw InvalidMesh(std::string("a mesh ") + problem);
    }
    const std::vector<MeshFingerprint> fingerprints = fingerprints_of(meshes);
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      const bool same = change_between(meshes_[i].fingerprint, fingerprints[i]) == MeshChange::kNothing;
      require(same && meshes[i].steps.size() == meshes_[i].step_count, "is of meshes that differ from these");
    }
  }

  std::shared_ptr<MappedFile> file_;
  FileHeader header_;
  std::vector<SavedMesh> meshes_;
  std::vector<MeshView> views_;
  std::vector<SavedRecord> records_;
};

SavedStructure::SavedStructure(const std::filesystem::path& file) {
  isolated([&] { impl_ = std::make_unique<Impl>(file); });
}
SavedStructure::SavedStructure(std::span<const std::byte> bytes) {
  isolated([&] { impl_ = std::make_unique<Impl>(bytes); });
}
SavedStructure::~SavedStructure() = default;
SavedStructure::SavedStructure(SavedStructure&&) noexcept = default;
SavedStructure& SavedStructure::operator=(SavedStructure&&) noexcept = default;

BuildSettings SavedStructure::settings() const {
  return impl_->settings();
}
bool SavedStructure::has_buffers() const {
  return impl_->has_buffers();
}
std::span<const MeshView> SavedStructure::meshes() const {
  return impl_->views();
}
std::span<const std::byte> SavedStructure::user_data() const {
  return impl_->user_data();
}
std::unique_ptr<Structure> SavedStructure::structure() const {
  std::unique_ptr<Structure> structure;
  isolated([&] { structure = impl_->structure(impl_->views(), true); });
  return structure;
}
std::unique_ptr<Structure> SavedStructure::structure(std::span<const MeshView> meshes) const {
  std::unique_ptr<Structure> structure;
  isolated([&] { structure = impl_->structure(meshes, false); });
  return structure;
}

}  // namespace stbvh
