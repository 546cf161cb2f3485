/// Machines and buildings as sets of parametric patches, cut into just as many triangles as asked for.
///
/// A scene describes its parts at no particular resolution; `tessellate` finds the resolution that gives the
/// triangle count of the paper's table times the scale.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "harness/scenes/procedural/shared/mesh_tools.h"

namespace stbvh::harness {

/// Where rest positions are at one time.
using PointMap = std::function<Vec3(Vec3)>;
/// Motion over the shutter: asked once for each step of a patch. Empty: no motion.
using Motion = std::function<PointMap(double time)>;

Motion rigid_motion(std::function<Rigid(double time)> pose);
/// `outer` after `inner`.
Motion compose(Motion outer, Motion inner);

/// A surface f(u, v) over [0,1]^2, to be cut into quads of about equal size.
struct Patch {
  std::function<Vec3(double, double)> at;
  double length_u = 0;  ///< extent along u, in metres; 0: always min_u quads
  double length_v = 0;
  std::size_t min_u = 1;  ///< fewest quads
  std::size_t min_v = 1;
  Wrap wrap = Wrap::kNone;
};
using Patches = std::vector<Patch>;

/// Where a group of patches is put, how it moves from there, and how much finer than others it is cut.
struct Placement {
  Rigid pose;
  Motion motion;
  double detail = 1;
};

/// Patches that become one mesh: one colour, one number of steps.
struct Part {
  std::string name;
  std::size_t steps = 1;
  Vec3 color;
  std::vector<Patch> patches;
  std::vector<Motion> motions;  ///< one for each patch

  void add(const Patches& added, const Placement& placement = {});
};

/// Meshes of the parts with `triangles` triangles in all, to within a few, or as many as the coarsest cut has
/// if that is more. Parts without patches give no mesh.
std::vector<Mesh> tessellate(const std::vector<Part>& parts, std::size_t triangles);

/// `count` at scale 1, scaled.
std::size_t scaled_count(double count, double scale);

// --- Patches
// -------------------------------------------------------------------------------------------------

/// Pose that turns the y axis into `axis` and moves the origin to `origin`.
Rigid along_axis(Vec3 origin, Vec3 axis);

Patches quad(Vec3 p00, Vec3 p10, Vec3 p11, Vec3 p01);
Patches box(Vec3 center, Vec3 half);
/// Cone or cylinder from `a` to `b`, closed by discs if `capped`.
Patches cylinder(Vec3 a, Vec3 b, double radius_a, double radius_b, bool capped = true,
                 std::size_t around = 6);
Patches disc(Vec3 center, Vec3 normal, double radius, std::size_t around = 6);
/// Surface of revolution about the y axis, one patch for each piece of the profile, so that its edges stay
/// sharp.
Patches lathe(const std::vector<ProfilePoint>& profile, std::size_t around = 10);
/// Surface of revolution with a smooth profile of that `length`, v from 0 to 1.
Patches smooth_lathe(const std::function<ProfilePoint(double)>& profile, double radius, double length,
                     std::size_t around = 8, std::size_t along = 4);
Patches ellipsoid(Vec3 center, Vec3 half, std::size_t around = 8, std::size_t along = 4);
/// Ring about `axis` with a round section.
Patches torus(Vec3 center, Vec3 axis, double radius, double thickness, std::size_t around = 12,
              std::size_t section = 4);
/// Open tube of `length` along a curve s in [0, 1]; `side` is nowhere along the curve.
Patches tube(const std::function<Vec3(double)>& curve, double length, double radius, Vec3 side,
             std::size_t around = 4, std::size_t along = 4);
Patches sheet(const std::function<Vec3(double, double)>& at, double length_u, double length_v,
              std::size_t min_u = 1, std::size_t min_v = 1);

/// All patches of several groups.
Patches join(std::initializer_list<Patches> groups);

}  // namespace stbvh::harness
