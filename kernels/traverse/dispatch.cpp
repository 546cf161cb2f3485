#include <cstdio>
#include <cstdlib>

#include "stbvh/isa.h"
#include "traverse/kernel_table.h"

namespace stbvh {

std::string_view isa_name(Isa isa) {
  switch (isa) {
    case Isa::kScalar:
      return "scalar";
    case Isa::kAvx2:
      return "avx2";
    case Isa::kAvx512:
      return "avx512";
  }
  return "";
}

std::vector<Isa> available_isas() {
  std::vector<Isa> isas{Isa::kScalar};
  __builtin_cpu_init();
  const bool has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (has_avx2) isas.push_back(Isa::kAvx2);
  const bool has_avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                          __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
  if (has_avx2 && has_avx512) isas.push_back(Isa::kAvx512);
  return isas;
}

namespace {

Isa choose_isa() {
  const std::vector<Isa> isas = available_isas();
  const Isa best = isas.back();
  if (const char* wanted = std::getenv("STBVH_ISA"); wanted != nullptr && *wanted != '\0') {
    for (const Isa isa : isas) {
      if (isa_name(isa) == wanted) return isa;
    }
    std::fprintf(stderr, "stbvh: STBVH_ISA=%s is not available here, using %s\n", wanted,
                 isa_name(best).data());
  } else if (best == Isa::kScalar) {
    std::fprintf(stderr, "stbvh: this machine has no AVX2 with FMA, using the scalar traversal\n");
  }
  return best;
}

}  // namespace

Isa default_isa() {
  static const Isa isa = choose_isa();
  return isa;
}

const KernelTable& kernel_table(Isa isa, Precision precision) {
  const KernelTables& tables = isa == Isa::kAvx512 ? kAvx512Kernels
                               : isa == Isa::kAvx2 ? kAvx2Kernels
                                                   : kScalarKernels;
  return precision == Precision::kFast ? tables.fast : tables.watertight;
}

}  // namespace stbvh
