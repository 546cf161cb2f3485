#include "builder/build_progress.h"

#include <algorithm>

namespace stbvh {

void BuildProgress::add(double share) {
  if (!callbacks_.progress) return;
  check();
  done_.fetch_add(share);
  const std::unique_lock lock(report_, std::try_to_lock);
  if (!lock.owns_lock()) return;
  const double done = std::min(done_.load(), 1.0);  // read under the lock: what is reported never falls
  if (share > 0.0 && done < reported_ + 0.01) return;
  check();
  reported_ = std::max(reported_, done);
  report(reported_);
}

void BuildProgress::report(double fraction) {
  if (!callbacks_.progress || callbacks_.progress(fraction)) return;
  cancelled_.store(true);
  throw BuildCancelled();
}

}  // namespace stbvh
