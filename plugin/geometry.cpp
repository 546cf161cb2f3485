#include "plugin/geometry.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>
#include <utility>

#include "plugin/device_memory.h"
#include "plugin/files/output_file.h"
#include "plugin/never_decreasing.h"
#include "stbvh/saved_structure.h"

namespace stbvh::plugin {
namespace {

PublishedMesh published_mesh(const MeshDescription& mesh) {
  const StbvhMeshArguments arguments = mesh.arguments();
  return {arguments.geomID, arguments.userPtr, arguments.intersectFilter, arguments.occludedFilter,
          mesh.takes_query_filters()};
}

RTCDevice retained(RTCDevice device) {
  rtcRetainDevice(device);
  return device;
}

/// Index of the mesh that has no geomID of its own, or RTC_INVALID_GEOMETRY_ID. Throws ApiError for two.
unsigned find_default_mesh(const std::vector<MeshDescription>& meshes) {
  unsigned found = RTC_INVALID_GEOMETRY_ID;
  for (unsigned i = 0; i < meshes.size(); ++i) {
    if (meshes[i].geom_id() != RTC_INVALID_GEOMETRY_ID) continue;
    if (found != RTC_INVALID_GEOMETRY_ID) {
      throw ApiError(RTC_ERROR_INVALID_OPERATION,
                     "meshes " + std::to_string(found) + " and " + std::to_string(i) +
                         " both have the default geomID, so that their hits could not be told apart: set " +
                         "geomID of all meshes but one");
    }
    found = i;
  }
  return found;
}

}  // namespace

Geometry::Geometry(RTCDevice device) : device_(retained(device)), user_geometry_(device) {}

void Geometry::add_mesh(MeshDescription mesh) {
  meshes_.push_back(std::move(mesh));
  user_geometry_.require_commit();
}

void Geometry::set_mesh(std::size_t index, MeshDescription mesh) {
  meshes_[index] = std::move(mesh);
  user_geometry_.require_commit();
}

void Geometry::set_precision(Precision precision) {
  settings_.precision = precision;
  user_geometry_.require_commit();
}

void Geometry::set_max_bytes(std::size_t structure_bytes, std::size_t peak_bytes) {
  settings_.max_bytes = structure_bytes;
  settings_.max_peak_bytes = peak_bytes;
  user_geometry_.require_commit();
}

void Geometry::set_tolerance(float tolerance) {
  settings_.tolerance = tolerance;
  user_geometry_.require_commit();
}

void Geometry::set_progress(RTCProgressMonitorFunction progress, void* user_ptr) {
  progress_ = progress;
  progress_user_ptr_ = user_ptr;
}

std::vector<MeshView> Geometry::views() const {
  std::vector<MeshView> views;
  for (const MeshDescription& mesh : meshes_) views.push_back(mesh.view());
  return views;
}

void Geometry::save(const char* file) const {
  const Published* const published = user_geometry_.published();
  if (published == nullptr)
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "nothing has been committed that could be saved");
  const std::vector<MeshView> meshes = views();
  if (fingerprints_of(meshes) != committed_.fingerprints)
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "meshes have changed since the last commit");
  const std::vector<std::byte> motions = to_bytes(committed_.motions);
  std::string bytes;
  save_structure(*published->structure, meshes, {.with_buffers = false, .user_data = motions},
                 [&](std::span<const std::byte> piece) {
                   bytes.append(reinterpret_cast<const char*>(piece.data()), piece.size());
                 });
  write_file(file, bytes);
}

std::shared_ptr<Structure> Geometry::read_structure(const char* file, Committed& now,
                                                    std::span<const MeshView> views) const {
  const auto refusal = [&](const std::string& problem) {
    return ApiError(RTC_ERROR_INVALID_ARGUMENT, '"' + std::string(file) + "\" " + problem);
  };
  try {
    const SavedStructure saved{std::filesystem::path(file)};
    if (saved.settings() != now.settings)
      throw refusal("was built with other settings than this geometry has");
    std::vector<TimeRange> time_ranges;
    for (const MeshView& view : views) time_ranges.push_back(view.time_range);
    std::shared_ptr<Structure> structure = saved.structure(views);
    std::optional<MotionsOfMeshes> motions = to_motions(saved.user_data(), time_ranges);
    if (!motions) throw refusal("was not written by stbvhSaveGeometry");
    now.motions = std::move(*motions);
    return structure;
  } catch (const BadStructureFile& error) {
    throw refusal(error.what());
  } catch (const std::system_error& error) {
    throw refusal("cannot be read: " + error.code().message());
  }
}

void Geometry::commit(const char* saved_file) {
  const auto start = std::chrono::steady_clock::now();
  std::shared_ptr<Structure> structure;
  if (user_geometry_.published() != nullptr) structure = user_geometry_.published()->structure;
  user_geometry_.publish(nullptr);
  report_.reset();
  default_mesh_ = find_default_mesh(meshes_);
  const EmbreeLayout layout = embree_layout();
  if (!layout.hits) {
    throw ApiError(
        RTC_ERROR_INVALID_OPERATION,
        "hits of this Embree are laid out otherwise than those of the one this library was built with");
  }
  auto published = std::make_shared<Published>();
  published->runs_query_filters = layout.options_behind_arguments;
  const std::vector<MeshView> meshes = views();
  for (std::size_t i = 0; i < meshes.size(); ++i) published->add(published_mesh(meshes_[i]), meshes[i].mask);
  TemporaryMemory temporary_memory(device_.get());
  Committed now{settings_, fingerprints_of(meshes), {}};
  CommitReport report;
  try {
    structure = saved_file != nullptr ? read_structure(saved_file, now, meshes)
                                      : make_structure(std::move(structure), now, meshes,
                                                       build_callbacks(temporary_memory), report);
  } catch (const BuildCancelled&) {
    if (temporary_memory.refused()) throw std::bad_alloc();
    throw ApiError(RTC_ERROR_CANCELLED, "the progress function cancelled the build");
  } catch (const MemoryLimit& error) {
    throw ApiError(RTC_ERROR_OUT_OF_MEMORY, error.what());
  } catch (const InvalidMesh& error) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, error.what());
  }
  std::vector<MeshMotion> motions;
  for (const std::vector<MeshMotion>& of_mesh : now.motions)
    motions.insert(motions.end(), of_mesh.begin(), of_mesh.end());
  published->grid = fit_motion_grid(motions);
  published->structure = std::move(structure);
  committed_ = std::move(now);
  user_geometry_.publish(std::move(published));
  report.tree = user_geometry_.published()->structure->statistics();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report_ = report;
}

std::shared_ptr<Structure> Geometry::make_structure(std::shared_ptr<Structure> old, Committed& now,
                                                    std::span<const MeshView> views, BuildCallbacks callbacks,
                                                    CommitReport& report) {
  now.motions = std::move(committed_.motions);
  now.motions.resize(views.size());
  std::vector<MeshUpdate> updates(views.size());
  for (std::size_t i = 0; i < std::min(views.size(), committed_.fingerprints.size()); ++i)
    updates[i] = {i, change_between(committed_.fingerprints[i], now.fingerprints[i])};
  const auto forget_motions = [&](bool all) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (all || updates[i].change != MeshChange::kNothing) now.motions[i].clear();
    }
  };
  callbacks.step_bounds = [&](std::size_t mesh, std::vector<Box3f> boxes, std::span<const float> times) {
    now.motions[mesh].push_back({std::move(boxes), views[mesh].time_range, {times.begin(), times.end()}});
  };
  if (old != nullptr && committed_.settings == now.settings) {
    forget_motions(false);
    if (const auto update = old->update(views, updates, callbacks)) {
      report.update = *update;
      report.is_update = true;
      return old;
    }
  }
  old.reset();  // there is never memory for two
  forget_motions(true);
  report.update.meshes_built = views.size();
  return Structure::build(views, now.settings, callbacks);
}

BuildCallbacks Geometry::build_callbacks(TemporaryMemory& temporary_memory) const {
  BuildCallbacks callbacks;
  callbacks.allocate = [device = device_.get()](std::size_t bytes) {
    return allocate_on_device(device, bytes);
  };
  callbacks.release = [](void* data, std::size_t) { release_on_device(data); };
  callbacks.temporary_memory = [&temporary_memory](std::ptrdiff_t bytes) {
    return temporary_memory.report(bytes);
  };
  if (progress_ != nullptr) {
    callbacks.progress = never_decreasing([progress = progress_, user_ptr = progress_user_ptr_](
                                              double fraction) { return progress(user_ptr, fraction); });
  }
  return callbacks;
}

}  // namespace stbvh::plugin
