#include "harness/preview/preview_program.h"

int main(int argc, char** argv) {
  return stbvh::harness::run_preview(argc, argv);
}
