#include <stbvh/stbvh_embree.h>
#include <stdio.h>

#include "ribbon.h"

static StbvhGeometry geometry; /* kept for as long as rays shall hit it */

void attach_with_stbvh(RTCDevice device, RTCScene scene, const struct Ribbon* ribbon) {
  const void* steps[kSteps];
  struct StbvhMeshArguments mesh;
  stbvhInitMeshArguments(&mesh);
  mesh.indices = ribbon->triangles;
  mesh.triangleCount = kTriangles;
  mesh.stepCount = kSteps;
  mesh.vertices = steps;
  mesh.vertexCount = kVertices;
  for (unsigned int step = 0; step < kSteps; ++step) {
    steps[step] = ribbon->vertices[step];
  }
  geometry = stbvhNewGeometry(device);
  if (stbvhAddMesh(geometry, &mesh, NULL) || stbvhCommitGeometry(geometry))
    fprintf(stderr, "stbvh: %s\n", stbvhGetErrorMessage(geometry));
  rtcAttachGeometry(scene, stbvhGetGeometry(geometry));
}

void release_stbvh(void) {
  stbvhReleaseGeometry(geometry);
}
