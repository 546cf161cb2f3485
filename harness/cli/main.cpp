#include "harness/cli/commands.h"

int main(int argc, char** argv) {
  return stbvh::harness::run_program(argc, argv);
}
