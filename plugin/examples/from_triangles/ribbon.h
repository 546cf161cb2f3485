/* The moving mesh of the example, and the two ways to put it into a scene. */
#ifndef RIBBON_H
#define RIBBON_H

#if STBVH_EMBREE_MAJOR >= 4 /* by CMake or pkg-config: which Embree libstbvh is for */
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

enum { kColumns = 64, kSteps = 9, kVertices = 2 * (kColumns + 1), kTriangles = 2 * kColumns };

/* A ribbon that waves: x along it, y across it, z up; kSteps positions of each vertex, equidistant in time.
 */
struct Ribbon {
  unsigned int triangles[kTriangles][3];
  float vertices[kSteps][kVertices][3];
};

void make_ribbon(struct Ribbon* ribbon);

/* Attaches the ribbon as Embree's own triangles. */
void attach_with_embree(RTCDevice device, RTCScene scene, const struct Ribbon* ribbon);

/* Attaches the ribbon through us: compare with_embree.c with with_stbvh.c. */
void attach_with_stbvh(RTCDevice device, RTCScene scene, const struct Ribbon* ribbon);

/* To be called when no ray is traced any more. */
void release_stbvh(void);

#endif
