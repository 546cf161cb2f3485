#include "harness/program/program.h"

#include <errno.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gmp.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <system_error>

#include "harness/files/user_error.h"
#include "harness/program/interruption.h"
#include "harness/program/script.h"
#include "harness/report/read_records.h"
#include "plugin/files/output_file.h"

namespace stbvh::harness {
namespace {

constexpr const char* kNoMemory = "Not enough memory.";

int fail(int code, const std::string& text) {
  std::fflush(stdout);
  write_to_stderr(fmt::format("{}: {}\n", program_invocation_short_name, one_line(text)));
  return code;
}

/// Ends the program without taking any memory.
[[noreturn]] void end_without_memory() {
  for (const char* part : {static_cast<const char*>(program_invocation_short_name), ": ", kNoMemory, "\n"}) {
    if (write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
  }
  _exit(1);
}

thread_local bool have_lacked_memory = false;  // in operator new

[[noreturn]] void on_new_failed() {
  have_lacked_memory = true;
  throw std::bad_alloc();
}

/// An exception that gets as far as a function that must not throw may come here without being caught first:
/// then nobody knows its type.
[[noreturn]] void on_terminate() {
  try {
    if (std::current_exception()) throw;
    if (std::uncaught_exceptions() > 0 && have_lacked_memory) end_without_memory();
  } catch (const std::bad_alloc&) {
    end_without_memory();
  } catch (...) {
  }
  std::abort();  // a mistake of ours
}

void* allocate_or_end(std::size_t bytes) {
  void* const data = std::malloc(bytes);
  if (data == nullptr) end_without_memory();
  return data;
}

void* reallocate_or_end(void* data, std::size_t, std::size_t bytes) {
  data = std::realloc(data, bytes);
  if (data == nullptr) end_without_memory();
  return data;
}

void release(void* data, std::size_t) {
  std::free(data);
}

/// A file of ours would get the number of a stream that is closed: others would write into it, and take it
/// for their input. What is written to a closed stdout must still be an error, so its stand-in can only be
/// read.
void open_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

/// Runs before the constructors of all libraries, which take memory too.
void prepare(int, char**, char**) {
  open_closed_streams();
  std::set_new_handler(on_new_failed);
  std::set_terminate(on_terminate);
  mp_set_memory_functions(allocate_or_end, reallocate_or_end, release);  // GMP itself would abort
  std::signal(SIGXFSZ, SIG_IGN);  // a file that becomes too large is an error of write()
}
__attribute__((section(".preinit_array"), used)) void (*const prepare_first)(int, char**, char**) = prepare;

void flush_output() {
  if (std::fflush(stdout) != 0) throw std::system_error(errno, std::generic_category());
  if (std::ferror(stdout) != 0) throw std::runtime_error("Cannot write to standard output.");  // earlier
}

}  // namespace

std::string one_line(std::string text) {
  constexpr std::size_t kKept = 250;  // bytes of either end: names may be there, and what is wrong with them
  const auto is_within_character = [&](std::size_t i) {
    return (static_cast<unsigned char>(text[i]) >> 6) == 2;
  };
  if (text.size() > 2 * kKept) {
    std::size_t begin = kKept, end = text.size() - kKept;
    while (begin > 0 && is_within_character(begin)) --begin;
    while (end < text.size() && is_within_character(end)) ++end;
    text.replace(begin, end - begin, "...");
  }
  for (char& c : text) {
    if ((c >= 0 && c < ' ') || c == '\x7f') c = '?';
  }
  return text;
}

void write_to_stderr(std::string_view text) noexcept {
  while (!text.empty()) {
    const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

int run_as_program(const std::function<void()>& work) {
  try {
    work();
    flush_output();
    return 0;
  } catch (const UserError& e) {
    return fail(2, e.what());
  } catch (const OutputFileError& e) {
    return fail(2, e.what());
  } catch (const std::filesystem::filesystem_error& e) {
    return fail(2, fmt::format("\"{}\": {}.", e.path1().string(), e.code().message()));
  } catch (const Interrupted& e) {
    return fail(130, e.what());
  } catch (const ScriptFailure& e) {
    return e.exit_code;
  } catch (const std::bad_alloc&) {
    std::fflush(stdout);
    end_without_memory();
  } catch (const std::system_error& e) {
    if (std::ferror(stdout) == 0 && e.code() == std::errc::resource_unavailable_try_again)
      return fail(1, fmt::format("A thread could not be started: {}.", e.code().message()));
    if (std::ferror(stdout) == 0) return fail(1, e.what());
    return fail(1, fmt::format("Cannot write to standard output: {}.", e.code().message()));
  } catch (const std::exception& e) {
    return fail(1, e.what());
  }
}

}  // namespace stbvh::harness
