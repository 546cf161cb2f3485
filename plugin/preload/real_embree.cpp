#include "plugin/preload/real_embree.h"

#include <dlfcn.h>
#include <link.h>

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

/// dl_iterate_phdr calls it for all that is loaded, until it returns 1.
int take_embree(dl_phdr_info* info, std::size_t, void* found) {
  if (!name_of(info->dlpi_name).starts_with("libembree")) return 0;
  void*& library = *static_cast<void**>(found);
  library = dlopen(info->dlpi_name, RTLD_LAZY | RTLD_NOLOAD);
  return library != nullptr && dlsym(library, "rtcNewDevice") != nullptr ? 1 : 0;
}

/// Programs that load a module which links to Embree, such as Python, may keep it out of the global scope,
/// and under a longer name (libembree4-4aef3270.so.4). Other versions have a function or more of the same
/// name, which come here too, to be passed on.
void* find_loaded() {
  void* library = nullptr;
  return dl_iterate_phdr(take_embree, &library) == 1 ? library : nullptr;
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
#if RTC_VERSION_MAJOR >= 4
#include "plugin/preload/embree4/real_functions.inl"
#endif
#undef STBVH_FUNCTION
  if (functions.rtcNewDevice == nullptr) {
    std::fputs("libstbvh_preload: there is no Embree behind this library\n", stderr);
    std::abort();
  }
  return functions;
}

}  // namespace

const RealEmbree& real() {
  static const RealEmbree functions = load_all();
  return functions;
}

bool is_loaded_for(long major) {
  const char* const library = major == 3   ? "libstbvh_preload.so"
                              : major == 4 ? "libstbvh_preload4.so"
                                           : nullptr;
  return library != nullptr && dlopen(library, RTLD_LAZY | RTLD_NOLOAD) != nullptr;
}

}  // namespace stbvh::preload
