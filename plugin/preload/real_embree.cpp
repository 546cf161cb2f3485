#include "plugin/preload/real_embree.h"

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>

namespace stbvh::preload {
namespace {

void* look_up(const char* name) {
  if (void* const function = dlsym(RTLD_NEXT, name)) return function;
  // Programs that load a module which links to Embree, such as Python, may keep it out of the global scope.
  static void* const loaded = dlopen("libembree3.so.3", RTLD_LAZY | RTLD_NOLOAD);
  return loaded == nullptr ? nullptr : dlsym(loaded, name);
}

template <typename Function>
void load(Function*& function, const char* name) {
  function = reinterpret_cast<Function*>(look_up(name));
  if (function != nullptr) return;
  std::fprintf(stderr, "libstbvh_preload: there is no %s of Embree 3 behind this library\n", name);
  std::abort();
}

RealEmbree load_all() {
  RealEmbree functions;
#define STBVH_FUNCTION(name) load(functions.name, #name);
#include "plugin/preload/real_functions.inl"
#undef STBVH_FUNCTION
  return functions;
}

}  // namespace

const RealEmbree& real() {
  static const RealEmbree functions = load_all();
  return functions;
}

}  // namespace stbvh::preload
