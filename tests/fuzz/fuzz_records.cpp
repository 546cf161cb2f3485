/// Bytes -> a file of records -> what the report takes from it, or the refusal.
#include "harness/report/read_records.h"
#include "reader_input.h"

namespace stbvh::fuzz {

void run(Bytes bytes) {
  static const InputFolder folder;
  const std::filesystem::path file = folder.write("input.json", bytes);
  try {
    harness::read_speeds_and_hards(file);
  } catch (const harness::RecordFileError&) {
  }
}

}  // namespace stbvh::fuzz
