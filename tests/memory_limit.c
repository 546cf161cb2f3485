/* Preloaded, it lets a program have MEMORY_LIMIT_KIB of memory beyond what it has when its libraries are
 * loaded. A limit from the start (ulimit -v) is met by the loader first, which reports it, or dies of a
 * signal: glibc 2.41 does both. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* Linked with -z initfirst, it runs before the constructors of all libraries, and before what the program
 * itself runs before those: the C library does not know the environment yet. */
__attribute__((constructor)) static void limit_memory(int argc, char** argv, char** environment) {
  static const char kName[] = "MEMORY_LIMIT_KIB=";
  (void)argc;
  (void)argv;
  while (*environment != NULL && strncmp(*environment, kName, sizeof(kName) - 1) != 0) ++environment;
  char pages[64] = "";
  const int statm = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (*environment == NULL || statm < 0 || read(statm, pages, sizeof(pages) - 1) < 0) _exit(99);
  close(statm);
  const rlim_t most = strtoul(pages, NULL, 10) * (rlim_t)sysconf(_SC_PAGESIZE) +
                      strtoul(*environment + sizeof(kName) - 1, NULL, 10) * 1024;
  const struct rlimit limit = {most, most};
  if (setrlimit(RLIMIT_AS, &limit) != 0) _exit(99);
}
