/* Preloaded, it lets a program have MEMORY_LIMIT_KIB of memory beyond what it has when its libraries are
 * loaded and ready, before its own initialisers. With less, from the start on (ulimit -v), libraries end it
 * as they like: oneTBB 2022, which Debian 13 has, follows a null pointer where its initialiser gets no
 * memory. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

/* The loader takes it for a library that only the program needs: its constructor is the last of all
 * libraries'. */
__attribute__((constructor)) static void limit_memory(void) {
  const char* const kib = getenv("MEMORY_LIMIT_KIB");
  char pages[64] = "";
  const int statm = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (kib == NULL || statm < 0 || read(statm, pages, sizeof(pages) - 1) < 0) _exit(99);
  close(statm);
  const rlim_t most =
      strtoul(pages, NULL, 10) * (rlim_t)sysconf(_SC_PAGESIZE) + strtoul(kib, NULL, 10) * (rlim_t)1024;
  const struct rlimit limit = {most, most};
  if (setrlimit(RLIMIT_AS, &limit) != 0) _exit(99);
}
