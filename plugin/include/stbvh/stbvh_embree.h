/**
 * STBVH for Embree 3 and 4: triangle meshes with multi-segment motion blur, in a tree of their own, as a user
 * geometry.
 *
 *   StbvhGeometry g = stbvhNewGeometry(device);
 *   struct StbvhMeshArguments mesh;
 *   stbvhInitMeshArguments(&mesh);
 *   mesh.indices = ...; mesh.vertices = ...; mesh.stepCount = 9; ...
 *   if (stbvhAddMesh(g, &mesh, NULL) || stbvhCommitGeometry(g)) puts(stbvhGetErrorMessage(g));
 *   rtcAttachGeometry(scene, stbvhGetGeometry(g));
 *   rtcCommitScene(scene);
 *   ... rtcIntersect1(scene, ...) ...
 *   stbvhReleaseGeometry(g);
 *
 * C99 and C++. What is answered in which query: docs/api.md.
 *
 * Errors. Functions return an RTCError, and compilers warn where it is dropped; stbvhGetErrorMessage gives
 * the reason as one sentence. As with Embree's own functions, the device's error is set too
 * (rtcGetDeviceError) and its error function is called, on the thread of the failing call; without a device
 * or a handle it is the thread's error, that of rtcGetDeviceError(NULL). The text that the error function is
 * given is Embree's, and general; within it stbvhGetErrorMessage has the reason. No function aborts or throws
 * on bad input.
 *
 * Setters. stbvhSetGeometry...(geometry, value) sets a property of the geometry from the next commit on. A
 * value out of range is refused with RTC_ERROR_INVALID_ARGUMENT and changes nothing.
 *
 * Commits. As with Embree's own geometries, rtcCommitScene fails with RTC_ERROR_INVALID_OPERATION while a
 * scene holds a geometry that has not been committed yet, or not since a mesh was added or set, or the
 * precision or the inline share.
 *
 * Embree. The header is the same for both majors, a library is for one of them: it includes what the CMake
 * target and pkg-config name (STBVH_EMBREE_MAJOR), else what the application has included already, else what
 * is installed. What differs stands under RTC_VERSION_MAJOR.
 *
 * Lifetime. Embree does not tell anybody that a user geometry has died, so the handle owns the tree:
 *   - Keep a reference to the StbvhGeometry for as long as rays shall hit it.
 *   - The RTCGeometry may outlive the handle, for instance in a scene that is released later. From the last
 *     stbvhReleaseGeometry on it hits nothing and has empty bounds; querying, committing and releasing that
 * scene stays safe.
 *   - Index and vertex buffers belong to the application. They must stay alive and unchanged from
 *     stbvhCommitGeometry until the next stbvhCommitGeometry begins or the last reference is released.
 *
 * Versions. Structs begin with their size, so that a library runs with programs that were compiled with an
 * older header of the same soname: members that the older header does not have keep their defaults, and are
 * not written. A struct larger than the library's own is refused. Later versions append members, and change
 * none. The macros STBVH_VERSION... name the version of the header, stbvhGetVersion that of the library.
 *
 * Threads. Queries, by a scene or by stbvhIntersect1, stbvhIntersectN and the like, run on any number of
 * threads at once. Retain and release are atomic. All other functions on one handle are for one thread at a
 * time, and, like the last release, not while the geometry is queried or a scene that holds it is committed.
 * Different handles are independent.
 */
#ifndef STBVH_EMBREE_H
#define STBVH_EMBREE_H

#include <stddef.h>
#include <stdint.h>

#if !defined(STBVH_EMBREE_MAJOR)
#if defined(RTC_VERSION_MAJOR)
#define STBVH_EMBREE_MAJOR RTC_VERSION_MAJOR
#elif defined(__has_include)
#if __has_include(<embree4/rtcore.h>) && !__has_include(<embree3/rtcore.h>)
#define STBVH_EMBREE_MAJOR 4
#else
#define STBVH_EMBREE_MAJOR 3
#endif
#else
#define STBVH_EMBREE_MAJOR 3
#endif
#endif

#if defined(RTC_VERSION_MAJOR)
#if RTC_VERSION_MAJOR != STBVH_EMBREE_MAJOR
#error "this STBVH library is for another major version of Embree than what was included before"
#endif
#elif STBVH_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#if defined(__GNUC__)
#define STBVH_API __attribute__((visibility("default")))
#else
#define STBVH_API
#endif

/** Before functions whose result must be looked at: the compiler warns where it is dropped. */
#if defined(__cplusplus) && __cplusplus >= 201703L
#define STBVH_NODISCARD [[nodiscard]]
#elif defined(__GNUC__)
#define STBVH_NODISCARD __attribute__((warn_unused_result))
#else
#define STBVH_NODISCARD
#endif

/** Version of this header. */
#define STBVH_VERSION_MAJOR 0
#define STBVH_VERSION_MINOR 1
#define STBVH_VERSION_PATCH 0
/** The same as one number that grows with each version, as RTC_VERSION: 10203 is 1.2.3. */
#define STBVH_VERSION (STBVH_VERSION_MAJOR * 10000 + STBVH_VERSION_MINOR * 100 + STBVH_VERSION_PATCH)
/** The same as text. */
#define STBVH_VERSION_STRING "0.1.0"

#ifdef __cplusplus
extern "C" {
#endif

/** STBVH_VERSION of the library that runs, which may be newer than the header. */
STBVH_API unsigned int stbvhGetVersion(void);

/** Mask of a mesh on which none is set, as in Embree. */
#if RTC_VERSION_MAJOR >= 4
#define STBVH_DEFAULT_MASK 1u
#else
#define STBVH_DEFAULT_MASK 0xFFFFFFFFu
#endif

/** Most steps of a mesh; Embree's own geometries take 129. */
#define STBVH_MAX_STEP_COUNT 4096

/** Handle of a set of meshes with one tree over them; reference counted. */
typedef struct StbvhGeometryTy* StbvhGeometry;

/**
 * A triangle mesh. Fill in with stbvhInitMeshArguments first.
 *
 * The arrays `vertices`, `vertexByteStrides` and `stepTimes` are copied by the call they are given to; the
 * buffers they point to are shared, read at commit and during queries, and never written. All pointers and
 * strides are multiples of 4 bytes; 12 bytes are read at each vertex and each triangle, no padding is needed
 * behind the last.
 *
 * A triangle with an index >= vertexCount, or with a vertex that in some step is not finite or not smaller
 * than 1.844e18, is left out for all times, as Embree does.
 */
struct StbvhMeshArguments {
  size_t byteSize; /**< sizeof(struct StbvhMeshArguments), set by stbvhInitMeshArguments */

  const void*
      indices; /**< three unsigned 32-bit vertex indices for each triangle; may be null without triangles */
  size_t indexByteStride; /**< bytes from one triangle to the next, >= 12; default 12 */
  size_t triangleCount;   /**< default 0 */

  const void* const* vertices; /**< stepCount pointers to x, y, z floats */
  size_t vertexByteStride;     /**< bytes from one vertex to the next, >= 12; default 12 */
  const size_t*
      vertexByteStrides;  /**< stepCount strides, one for each step; null (default): vertexByteStride */
  size_t vertexCount;     /**< vertices in each step; default 0 */
  unsigned int stepCount; /**< 1 (static; default) to STBVH_MAX_STEP_COUNT, equidistant in the time range
                             where stepTimes is null */

  float startTime; /**< ray time of the first step; default 0 */
  float endTime;   /**< ray time of the last step, > startTime, with several steps by 1.18e-38 or more where
                        denormal times count as 0; default 1. A mesh with several steps is not hit outside
                        [startTime, endTime]; a static one is hit at all times, as in Embree. */

  unsigned int mask;   /**< hit by rays with (ray.mask & mask) != 0; default STBVH_DEFAULT_MASK */
  unsigned int geomID; /**< reported in hits; RTC_INVALID_GEOMETRY_ID (default): the ID under which the
                          geometry is attached. Of all meshes of a geometry one at most may have the default:
                          the primIDs of two would overlap. */
  void* userPtr;       /**< geometryUserPtr of this mesh's filters; default null */
  RTCFilterFunctionN intersectFilter; /**< as rtcSetGeometryIntersectFilterFunction; default null */
  RTCFilterFunctionN occludedFilter;  /**< as rtcSetGeometryOccludedFilterFunction; default null */
#if RTC_VERSION_MAJOR >= 4
  size_t enableFilterFunctionFromArguments; /**< as rtcSetGeometryEnableFilterFunctionFromArguments: not 0
                                               runs a query's filter on this mesh also where the query's flags
                                               do not; default 0 */
#endif
  const float* stepTimes; /**< stepCount ray times, each greater than the one before by 1.18e-38 or more where
                             denormal times count as 0; instead of startTime and endTime, which are not looked
                             at. Null (default): equidistant. Copied, as `vertices`. */
};

/** Fills in the defaults stated at struct StbvhMeshArguments. */
static inline void stbvhInitMeshArguments(struct StbvhMeshArguments* arguments) {
  arguments->byteSize = sizeof(struct StbvhMeshArguments);
  arguments->indices = NULL;
  arguments->indexByteStride = 3 * sizeof(unsigned int);
  arguments->triangleCount = 0;
  arguments->vertices = NULL;
  arguments->vertexByteStride = 3 * sizeof(float);
  arguments->vertexByteStrides = NULL;
  arguments->vertexCount = 0;
  arguments->stepCount = 1;
  arguments->startTime = 0.0f;
  arguments->endTime = 1.0f;
  arguments->mask = STBVH_DEFAULT_MASK;
  arguments->geomID = RTC_INVALID_GEOMETRY_ID;
  arguments->userPtr = NULL;
  arguments->intersectFilter = NULL;
  arguments->occludedFilter = NULL;
#if RTC_VERSION_MAJOR >= 4
  arguments->enableFilterFunctionFromArguments = 0;
#endif
  arguments->stepTimes = NULL;
}

/** What the last successful commit built. Initialise with stbvhInitStatistics first. */
struct StbvhStatistics {
  size_t byteSize;          /**< sizeof(struct StbvhStatistics), set by stbvhInitStatistics */
  size_t triangles;         /**< valid triangles */
  size_t invalidTriangles;  /**< triangles left out */
  size_t primitiveSegments; /**< sum over valid triangles of max(steps kept - 1, 1) */
  size_t structureBytes;    /**< nodes, leaves and mesh table */
  size_t peakBytes;         /**< structure and temporary memory of the build at their largest */
  size_t stepsGiven;        /**< sum over meshes of stepCount */
  size_t stepsKept;         /**< of them, those that the tolerance takes */
  double maxDeviation;      /**< of any vertex at any time, because of the others; scene units */
  size_t wantedBytes;       /**< structureBytes if it were not limited, about */
  size_t leaves;            /**< of the structure */
  size_t indexedLeaves;     /**< of them, those that read the meshes' buffers, because it is limited */
  size_t isUpdate;          /**< 1: the last commit changed the tree that was there, 0: it built one anew */
  size_t meshesRefitted;    /**< by it: kept their leaves, with other positions */
  size_t meshesBuilt;       /**< by it: all, or those that were new or had other triangles, steps or times */
  size_t meshesRemoved;     /**< by it: have no triangles now */
  size_t leavesRefitted;    /**< by it */
  double expectedCost;  /**< what rays have to do, relative to a tree built anew, as far as that is known */
  double commitSeconds; /**< that stbvhCommitGeometry took */
};

/** Sets byteSize, and all else to zero. */
static inline void stbvhInitStatistics(struct StbvhStatistics* statistics) {
  statistics->byteSize = sizeof(struct StbvhStatistics);
  statistics->triangles = 0;
  statistics->invalidTriangles = 0;
  statistics->primitiveSegments = 0;
  statistics->structureBytes = 0;
  statistics->peakBytes = 0;
  statistics->stepsGiven = 0;
  statistics->stepsKept = 0;
  statistics->maxDeviation = 0.0;
  statistics->wantedBytes = 0;
  statistics->leaves = 0;
  statistics->indexedLeaves = 0;
  statistics->isUpdate = 0;
  statistics->meshesRefitted = 0;
  statistics->meshesBuilt = 0;
  statistics->meshesRemoved = 0;
  statistics->leavesRefitted = 0;
  statistics->expectedCost = 0.0;
  statistics->commitSeconds = 0.0;
}

/**
 * Creates an empty geometry with one reference. The device is retained until the handle dies.
 * Returns null for a null device or without memory; stbvhGetErrorMessage(NULL) then says which.
 */
STBVH_API StbvhGeometry stbvhNewGeometry(RTCDevice device);

/** Adds a reference. Null is ignored. */
STBVH_API void stbvhRetainGeometry(StbvhGeometry geometry);

/** Drops a reference; the last one frees the tree (see Lifetime above). Null is ignored. */
STBVH_API void stbvhReleaseGeometry(StbvhGeometry geometry);

/**
 * Adds a mesh; it takes effect at the next commit. Its index (0, 1, 2, ... in the order of the calls) is
 * stored to `meshIndex` unless that is null. RTC_ERROR_INVALID_ARGUMENT, and nothing added: arguments null,
 * not initialised or from a newer header; no steps or more than STBVH_MAX_STEP_COUNT; a buffer or array
 * missing or misaligned; a stride too small or misaligned; counts and strides that reach beyond the end of
 * memory; times not finite, startTime >= endTime, stepTimes that do not increase, or with several steps next
 * to nothing between them. Of what was added the commit refuses a second mesh with the default geomID, and
 * nothing else.
 */
STBVH_NODISCARD STBVH_API enum RTCError stbvhAddMesh(StbvhGeometry geometry,
                                                     const struct StbvhMeshArguments* arguments,
                                                     unsigned int* meshIndex);

/**
 * Replaces a mesh; errors as in stbvhAddMesh, then the mesh stays as it was. It takes effect at the next
 * commit, also a change of mask, IDs or filters alone. A mesh whose buffers changed in place needs no call
 * but the commit. To hide a mesh give it triangleCount 0 or mask 0.
 */
STBVH_NODISCARD STBVH_API enum RTCError stbvhSetMesh(StbvhGeometry geometry, unsigned int meshIndex,
                                                     const struct StbvhMeshArguments* arguments);

/**
 * Reads back a mesh, to change some members and give it to stbvhSetMesh. The arrays `vertices`,
 * `vertexByteStrides` and `stepTimes` belong to the handle and are valid until the mesh is set again.
 */
STBVH_NODISCARD STBVH_API enum RTCError stbvhGetMesh(StbvhGeometry geometry, unsigned int meshIndex,
                                                     struct StbvhMeshArguments* arguments);

/** Number of meshes added; 0 for null. */
STBVH_API unsigned int stbvhGetMeshCount(StbvhGeometry geometry);

/** How rays are tested against boxes and triangles. */
#ifdef __cplusplus
enum StbvhPrecision : unsigned int  // so that any value may be given, to be refused
#else
enum StbvhPrecision
#endif
{
  /** No ray slips through an edge or a vertex that triangles of a mesh share, at any scale; the default. */
  STBVH_PRECISION_WATERTIGHT = 0,
  /** As Embree's own triangles without RTC_SCENE_FLAG_ROBUST: a little faster (docs/results.md), less exact.
   */
  STBVH_PRECISION_FAST = 1
};

/** Sets how rays are tested; a value that is not listed is refused. */
STBVH_NODISCARD STBVH_API enum RTCError stbvhSetGeometryPrecision(StbvhGeometry geometry,
                                                                  enum StbvhPrecision precision);

/** No limit, for stbvhSetGeometryMaxBytes. */
#define STBVH_NO_LIMIT SIZE_MAX

/**
 * Sets how many bytes the structure may take (StbvhStatistics::structureBytes), and how many structure and
 * temporary memory of the build together (peakBytes). Where the structure would take more (wantedBytes),
 * memory is spent where rays profit most from it: time is split less often, and leaves that rays seldom meet
 * read the mesh's buffers instead of holding vertices. stbvhCommitGeometry fails with
 * RTC_ERROR_OUT_OF_MEMORY where even the smallest structure takes more. STBVH_NO_LIMIT (default) for either:
 * none. docs/performance.md has the speed that bytes buy.
 */
STBVH_NODISCARD STBVH_API enum RTCError stbvhSetGeometryMaxBytes(StbvhGeometry geometry,
                                                                 size_t structureBytes, size_t peakBytes);

/** The tolerance that takes all steps as they are given. */
#define STBVH_KEEP_ALL_STEPS (-1.0f)

/**
 * Sets how far a vertex may be from where its mesh says, at any time, in scene units. Of each mesh only the
 * steps are kept that this takes; less memory, and faster rays. 0 (default): as far as straight motion is off
 * whose positions were rounded to floats, so that what stands still is static, and straight motion has two
 * steps. STBVH_KEEP_ALL_STEPS, or finite and not negative; anything else is refused.
 */
STBVH_NODISCARD STBVH_API enum RTCError stbvhSetGeometryTolerance(StbvhGeometry geometry, float tolerance);

/**
 * Sets a function that stbvhCommitGeometry calls with the fraction done, 0 to 1, never decreasing, one call
 * at a time but possibly on a worker thread. Returning false cancels the build. Null (default): none. Alone
 * among the properties it may be set without a commit afterwards.
 */
STBVH_NODISCARD STBVH_API enum RTCError stbvhSetGeometryProgressFunction(StbvhGeometry geometry,
                                                                         RTCProgressMonitorFunction progress,
                                                                         void* userPtr);

/**
 * Builds the tree over all meshes and commits the RTCGeometry; scenes that hold it need rtcCommitScene
 * afterwards, as after rtcCommitGeometry.
 *
 * After the first time only what has changed costs: meshes whose positions have changed are refitted, those
 * that are new or have other triangles, steps or times are built by themselves, masks, IDs and filters are
 * entered. Which those are it finds out by reading all buffers. Where rays would be slower by that than in a
 * tree built anew, by an estimate (docs/algorithm.md), or most has changed, the old tree is freed and another
 * built. StbvhStatistics says what was done.
 *
 * All memory is allocated through rtcNewBuffer, so the device's memory monitor is told of every byte, and the
 * temporary memory of the build is announced to it in the same way, in blocks of 1 MB and more.
 *
 * RTC_ERROR_INVALID_OPERATION: two or more meshes have the default geomID; RTC_ERROR_OUT_OF_MEMORY: no
 * memory, the monitor refused, or stbvhSetGeometryMaxBytes allows too little; RTC_ERROR_CANCELLED: the
 * progress function returned false; RTC_ERROR_UNKNOWN: anything else. After an error the geometry is empty
 * (it hits nothing) until a commit succeeds, and all memory has been given back.
 */
STBVH_NODISCARD STBVH_API enum RTCError stbvhCommitGeometry(StbvhGeometry geometry);

/**
 * Writes the tree that the last commit made to a file, which appears whole or not at all; the meshes' buffers
 * do not go into it, but hashes of what they hold. RTC_ERROR_INVALID_OPERATION: nothing is committed, or a
 * mesh has changed since; RTC_ERROR_UNKNOWN: the file cannot be written.
 */
STBVH_NODISCARD STBVH_API enum RTCError stbvhSaveGeometry(StbvhGeometry geometry, const char* file);

/**
 * As stbvhCommitGeometry with the tree of a file that stbvhSaveGeometry wrote: nothing is built. Meshes with
 * the same contents in the same order must have been added, and the same settings made; masks, IDs and
 * filters are as they are now. The file is mapped, not read: the monitor is not told of its bytes, and it
 * must not be changed while the geometry uses it (writing a new one in its place is all right). It is checked
 * whole first.
 *
 * RTC_ERROR_INVALID_ARGUMENT: there is no such file, it is truncated, damaged, of another version, of other
 * meshes or other settings; stbvhGetErrorMessage says which, and the geometry is empty.
 */
STBVH_NODISCARD STBVH_API enum RTCError stbvhCommitSavedGeometry(StbvhGeometry geometry, const char* file);

/**
 * The geometry to attach: RTC_GEOMETRY_TYPE_USER with one primitive. Any number of scenes may hold it, also
 * scenes that are instanced. The reference is borrowed: rtcRetainGeometry it to keep it beyond the handle.
 *
 * The handle sets its time steps, time range, mask, user data and callbacks; the application must not. It may
 * attach, detach, enable and disable it. rtcCommitGeometry builds nothing and is no error, as Embree tells
 * nobody of it: the geometry shows what the last stbvhCommitGeometry made, nothing before the first.
 */
STBVH_API RTCGeometry stbvhGetGeometry(StbvhGeometry geometry);

/**
 * Closest hit in this geometry alone, without a scene and without Embree's tree above it: for applications
 * that query their moving meshes separately from the rest. Ray and hit are those of rtcIntersect1, and
 * come back with the same bits as from rtcIntersect1 on a scene that holds only this geometry: masks, time
 * ranges, the meshes' filters and the context's work alike. Differences: a mesh with the default geomID
 * reports its index, and the end of a time range (docs/api.md).
 *
 * The arguments are in the order of rtcIntersect1 of the same Embree. A null context (Embree 3) is one from
 * rtcInitIntersectContext, null arguments (Embree 4) are those of rtcInitIntersectArguments: no filter of
 * their own, and no instance. The last commit answers, whatever was added or set since; before the first one
 * and after a failed one nothing is hit. A query allocates nothing and locks nothing.
 */
#if RTC_VERSION_MAJOR >= 4
STBVH_API void stbvhIntersect1(StbvhGeometry geometry, struct RTCRayHit* rayhit,
                               struct RTCIntersectArguments* arguments);
#else
STBVH_API void stbvhIntersect1(StbvhGeometry geometry, struct RTCIntersectContext* context,
                               struct RTCRayHit* rayhit);
#endif

/** Any hit, likewise: sets ray->tfar to -inf as rtcOccluded1 does. */
#if RTC_VERSION_MAJOR >= 4
STBVH_API void stbvhOccluded1(StbvhGeometry geometry, struct RTCRay* ray,
                              struct RTCOccludedArguments* arguments);
#else
STBVH_API void stbvhOccluded1(StbvhGeometry geometry, struct RTCIntersectContext* context,
                              struct RTCRay* ray);
#endif

/**
 * The same for `count` rays, `byteStride` bytes apart, each with the bits of a query of its own. Where
 * memory is waited for, several are in flight at once: others go on while that of one is on its way
 * (docs/performance.md). The rays need not be alike, nor sorted; dozens or more in a call are best.
 * Filters run on the calling thread, for one ray's candidates between those of others.
 *
 * RTC_ERROR_INVALID_ARGUMENT as the device's error, and nothing traced: rays null, a stride that is too
 * small or not a multiple of 4, or rays that reach beyond the end of memory.
 */
#if RTC_VERSION_MAJOR >= 4
STBVH_API void stbvhIntersectN(StbvhGeometry geometry, struct RTCRayHit* rayhits, size_t count,
                               size_t byteStride, struct RTCIntersectArguments* arguments);
STBVH_API void stbvhOccludedN(StbvhGeometry geometry, struct RTCRay* rays, size_t count, size_t byteStride,
                              struct RTCOccludedArguments* arguments);
#else
STBVH_API void stbvhIntersectN(StbvhGeometry geometry, struct RTCIntersectContext* context,
                               struct RTCRayHit* rayhits, size_t count, size_t byteStride);
STBVH_API void stbvhOccludedN(StbvhGeometry geometry, struct RTCIntersectContext* context,
                              struct RTCRay* rays, size_t count, size_t byteStride);
#endif

#if RTC_VERSION_MAJOR >= 4
/**
 * For applications that set RTCIntersectArguments::intersect or RTCOccludedArguments::occluded: Embree 4 then
 * calls that function for every user geometry, ours too. It must pass on what it is given for ours, which it
 * tells by arguments->geomID; the very pointer, for Embree keeps more behind the public members.
 */
STBVH_API void stbvhIntersectFunctionN(const struct RTCIntersectFunctionNArguments* arguments);
STBVH_API void stbvhOccludedFunctionN(const struct RTCOccludedFunctionNArguments* arguments);
#endif

/** What was built; all zero before the first commit and after a failed one. */
STBVH_NODISCARD STBVH_API enum RTCError stbvhGetStatistics(StbvhGeometry geometry,
                                                           struct StbvhStatistics* statistics);

/**
 * Why the last failing call on this handle failed, in one sentence; "" if none did. Valid until the next call
 * on the handle. With null: why the last failing call of this thread that had no handle failed,
 * stbvhNewGeometry or another function that was given null.
 */
STBVH_API const char* stbvhGetErrorMessage(StbvhGeometry geometry);

#ifdef __cplusplus
}
#endif

#endif
