#include "plugin/preload/real_embree.h"

#include <dlfcn.h>
#include <link.h>

#include <array>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace stbvh::preload {
namespace {

/// The file name of a path.
std::string_view name_of(const char* path) {
  const std::string_view view(path);
  return view.substr(view.rfind('/') + 1);
}

/// Names of what is loaded, in memory of the loader.
struct Loaded {
  std::array<const char*, 16> embrees{};
  std::size_t count = 0;
};

int note_embree(dl_phdr_info* info, std::size_t, void* user) {
  Loaded& loaded = *static_cast<Loaded*>(user);
  if (!name_of(info->dlpi_name).starts_with("libembree")) return 0;
  loaded.embrees[loaded.count++] = info->dlpi_name;
  return loaded.count == loaded.embrees.size() ? 1 : 0;
}

/// Programs that load a module which links to Embree, such as Python, may keep it out of the global scope,
/// and under a longer name (libembree4-4aef3270.so.4). Other versions have a function or more of the same
/// name, which come here too, to be passed on.
void* find_loaded() {
  Loaded loaded;
  dl_iterate_phdr(note_embree, &loaded);  // which holds a lock that dlopen must not meet
  for (std::size_t i = 0; i < loaded.count; ++i) {
    void* const library = dlopen(loaded.embrees[i], RTLD_LAZY | RTLD_NOLOAD);
    if (library != nullptr && dlsym(library, "rtcNewDevice") != nullptr) return library;
  }
  return nullptr;
}

void* look_up(const char* name) {
  if (void* const function = dlsym(RTLD_NEXT, name)) return function;
  static void* const kLoaded = find_loaded();
  return kLoaded == nullptr ? nullptr : dlsym(kLoaded, name);
}

template <typename Function>
void load(Function*& function, const char* name) {
  function = reinterpret_cast<Function*>(look_up(name));
}

RealEmbree load_all() {
  RealEmbree functions;
#define STBVH_FUNCTION(name) load(functions.name, #name);
#include "plugin/preload/real_functions.inl"
#undef STBVH_FUNCTION
  if (functions.rtcNewDevice == nullptr) {
    std::fputs("libstbvh_preload: there is no Embree behind this library\n", stderr);
    std::abort();
  }
  return functions;
}

}  // namespace

const RealEmbree& detail::load_embree() {
  static const RealEmbree functions = load_all();
  loaded_embree.store(&functions, std::memory_order_release);
  return functions;
}

bool is_loaded_for(long major) {
  const char* const library = major == 3   ? "libstbvh_preload.so"
                              : major == 4 ? "libstbvh_preload4.so"
                                           : nullptr;
  return library != nullptr && dlopen(library, RTLD_LAZY | RTLD_NOLOAD) != nullptr;
}

}  // namespace stbvh::preload
