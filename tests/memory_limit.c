/* Preloaded, it lets a program have MEMORY_LIMIT_KIB of memory beyond what it has when its libraries are
 * loaded: what the loader itself says of too little memory is not ours. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <ucontext.h>
#include <unistd.h>

/* oneTBB 2022, which Debian 13 has, follows a null pointer where its initialiser gets no memory: that one
 * fault becomes a line. After any other the instruction faults again, and ends the program. */
static void on_fault(int number, siginfo_t* info, void* context) {
  static const char kLine[] = "oneTBB has no memory for its initialiser\n";
  Dl_info place;
  (void)number;
  (void)info;
  if (dladdr((void*)(uintptr_t)((ucontext_t*)context)->uc_mcontext.gregs[REG_RIP], &place) != 0 &&
      place.dli_sname != NULL && strstr(place.dli_sname, "global_control_active_value") != NULL)
    _exit(write(STDERR_FILENO, kLine, sizeof(kLine) - 1) > 0 ? 1 : 99);
}

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
  const struct sigaction action = {.sa_sigaction = on_fault, .sa_flags = SA_SIGINFO | (int)SA_RESETHAND};
  if (sigaction(SIGSEGV, &action, NULL) != 0 || setrlimit(RLIMIT_AS, &limit) != 0) _exit(99);
}
