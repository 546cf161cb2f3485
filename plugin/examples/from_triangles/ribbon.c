#include "ribbon.h"

#include <math.h>

void make_ribbon(struct Ribbon* ribbon) {
  for (unsigned int c = 0; c < kColumns; ++c) {
    const unsigned int corner = 2 * c;
    const unsigned int first[3] = {corner, corner + 2, corner + 1};
    const unsigned int second[3] = {corner + 1, corner + 2, corner + 3};
    for (int i = 0; i < 3; ++i) {
      ribbon->triangles[2 * c][i] = first[i];
      ribbon->triangles[2 * c + 1][i] = second[i];
    }
  }
  for (int step = 0; step < kSteps; ++step) {
    const float phase = 6.2831853f * (float)step / (float)(kSteps - 1);
    for (int v = 0; v < kVertices; ++v) {
      const float x = (float)(v / 2) / (float)kColumns;
      ribbon->vertices[step][v][0] = 10.0f * x;
      ribbon->vertices[step][v][1] = v % 2 == 0 ? -1.0f : 1.0f;
      ribbon->vertices[step][v][2] = sinf(6.2831853f * x + phase);
    }
  }
}
