#include "stbvh/isa.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace stbvh {
namespace {

TEST(Isa, EnvironmentChooses) {
  const std::vector<Isa> isas = available_isas();
  ASSERT_FALSE(isas.empty());
  EXPECT_EQ(isas.front(), Isa::kScalar);
  const char* wanted = std::getenv("STBVH_ISA");
  Isa expected = isas.back();
  for (const Isa isa : isas) {
    if (wanted != nullptr && isa_name(isa) == wanted) expected = isa;
  }
  EXPECT_EQ(default_isa(), expected);
}

}  // namespace
}  // namespace stbvh
