/// Ctrl-C, taken as the wish to stop with what is done.
#pragma once

#include <atomic>
#include <csignal>
#include <stdexcept>

namespace stbvh::harness {

/// The user stopped the program; what() is one sentence about what there is. The exit code is 130.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// While one of these lives (one at a time), the first SIGINT sets a flag; a second one ends the program.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  const std::atomic<bool>& flag() const;

 private:
  struct sigaction before_;
};

}  // namespace stbvh::harness
