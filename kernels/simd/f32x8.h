/// F32x8 of the instruction set that a traversal source is compiled for: it includes that one's header first.
/// Else, as for an editor that reads a part of the traversal alone, plain C++.
#pragma once

#ifndef STBVH_F32X8
#include "simd/f32x8_scalar.h"
#endif
