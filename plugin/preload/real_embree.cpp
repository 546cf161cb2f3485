#include "plugin/preload/real_embree.h"

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <initializer_list>

namespace stbvh::preload {
namespace {

/// Programs that load a module which links to Embree, such as Python, may keep it out of the global scope.
/// Other versions have a function or more of the same name, which come here too, to be passed on.
void* find_loaded() {
  for (const char* const name : {"libembree3.so.3", "libembree4.so.4", "libembree.so.2"}) {
    if (void* const library = dlopen(name, RTLD_LAZY | RTLD_NOLOAD)) return library;
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

const RealEmbree& real() {
  static const RealEmbree functions = load_all();
  return functions;
}

}  // namespace stbvh::preload
