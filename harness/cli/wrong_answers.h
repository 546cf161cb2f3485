/// Ours must be right: a wrong answer of a structure of ours is an error of the program's, not a figure.
#pragma once

#include <span>
#include <stdexcept>

#include "harness/report/records.h"

namespace stbvh::harness {

/// what() is one sentence for the user; the program ends with exit code 1.
struct WrongAnswers : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws WrongAnswers if a structure that promises exact answers (is_exact()) missed, falsely hit or hit a
/// wrong primitive beyond rounding in any of `results`. What other structures answer is theirs; and where a
/// scene has a tolerance, surfaces may stand elsewhere.
void require_right_answers(std::span<const ErrorResult> results);

/// The same; a leak is a wrong answer too.
void require_right_answers(std::span<const HardResult> results);

}  // namespace stbvh::harness
