// SPDX-License-Identifier: Apache-2.0
// Faults of the disk, call by call. Include this in one source of a test executable: what it
// defines stands in front of the C library's functions for all that the executable loads.
#pragma once

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

#include "palpate/core/error.hpp"

namespace palpate::faults {

/// Which call fails, and how.
struct Fault {
  int call = 0;        ///< counted from 1 over all calls that write below the folder; 0: none
  int error = ENOSPC;  ///< errno
  bool stays = false;  ///< all later calls fail, too
};

struct State {
  bool armed = false;
  Fault fault;
  int calls = 0;
  std::string folder;
};

inline State& state() {
  static State state;
  return state;
}

inline bool is_below(const char* path) {
  return std::strncmp(path, state().folder.c_str(), state().folder.size()) == 0;
}

inline bool is_below(int descriptor) {
  char path[4096] = {};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  return readlink(link.c_str(), path, sizeof path - 1) > 0 && is_below(path);
}

/// Whether this call is to fail; sets errno.
template <class Where>
bool strikes(Where where) {
  if (!state().armed || !is_below(where)) return false;
  const int call = ++state().calls;
  const Fault& fault = state().fault;
  if (fault.call == 0 || !(call == fault.call || (fault.stays && call > fault.call))) return false;
  errno = fault.error;
  return true;
}

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

inline int real_open(const char* name, const char* path, int flags, mode_t mode) {
  if ((flags & O_ACCMODE) != O_RDONLY && strikes(path)) return -1;
  return real<int(const char*, int, ...)>(name)(path, flags, mode);
}

}  // namespace palpate::faults

extern "C" {
int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return palpate::faults::real_open("open", path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return palpate::faults::real_open("open64", path, flags, mode);
}

ssize_t write(int file, const void* bytes, size_t size) {
  if (palpate::faults::strikes(file)) return -1;
  return palpate::faults::real<ssize_t(int, const void*, size_t)>("write")(file, bytes, size);
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  if (palpate::faults::strikes(file)) return -1;
  return palpate::faults::real<ssize_t(int, const void*, size_t, off_t)>("pwrite")(file, bytes,
                                                                                   size, at);
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) {
  if (palpate::faults::strikes(file)) return -1;
  return palpate::faults::real<ssize_t(int, const void*, size_t, off64_t)>("pwrite64")(file, bytes,
                                                                                       size, at);
}

int fsync(int file) {
  if (palpate::faults::strikes(file)) return -1;
  return palpate::faults::real<int(int)>("fsync")(file);
}

int ftruncate(int file, off_t size) noexcept {
  if (palpate::faults::strikes(file)) return -1;
  return palpate::faults::real<int(int, off_t)>("ftruncate")(file, size);
}

int ftruncate64(int file, off64_t size) noexcept {
  if (palpate::faults::strikes(file)) return -1;
  return palpate::faults::real<int(int, off64_t)>("ftruncate64")(file, size);
}

int rename(const char* from, const char* to) noexcept {
  if (palpate::faults::strikes(to)) return -1;
  return palpate::faults::real<int(const char*, const char*)>("rename")(from, to);
}

int mkdir(const char* path, mode_t mode) noexcept {
  if (palpate::faults::strikes(path)) return -1;
  return palpate::faults::real<int(const char*, mode_t)>("mkdir")(path, mode);
}

/// Closes, and then reports the fault, as close(2) does.
int close(int file) {
  const bool strike = palpate::faults::state().armed && palpate::faults::strikes(file);
  const int error = errno;
  const int result = palpate::faults::real<int(int)>("close")(file);
  if (!strike) return result;
  errno = error;
  return -1;
}
}

namespace palpate::faults {

/// What became of a body that met a fault.
struct Outcome {
  int calls = 0;        ///< that would write below the folder
  bool failed = false;  ///< it threw BadInput, and that alone is how it may fail
  std::string message;
};

/// Runs body() in a process of its own, in which calls that write below the folder fail.
/// @throws std::runtime_error if the body ends in any other way than by return or BadInput
template <class Body>
Outcome run(const std::filesystem::path& folder, const Fault& fault, const Body& body) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child == 0) {
    state() = {true, fault, 0, folder.string()};
    int code = 0;
    std::string message;
    try {
      body();
    } catch (const BadInput& error) {
      code = 3;
      message = error.what();
    } catch (const std::exception& error) {
      code = 1;
      message = error.what();
    }
    state().armed = false;
    message = std::to_string(state().calls) + "\n" + message;
    static_cast<void>(!write(ends[1], message.data(), message.size()));
    _exit(code);
  }
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t size; (size = read(ends[0], buffer, sizeof buffer)) > 0;) {
    text.append(buffer, static_cast<std::size_t>(size));
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || (WEXITSTATUS(status) != 0 && WEXITSTATUS(status) != 3)) {
    throw std::runtime_error("died at call " + std::to_string(fault.call) + ": " + text);
  }
  const auto line = text.find('\n');
  return {std::stoi(text), WEXITSTATUS(status) == 3, text.substr(line + 1)};
}

/// Lets every call fail that writes below the folder, one after the other and each for every
/// reason, alone and for good. @param prepare before, @param check after every run
template <class Prepare, class Body, class Check>
int try_all(const std::filesystem::path& folder, const Prepare& prepare, const Body& body,
            const Check& check) {
  prepare();
  const int calls = run(folder, {}, body).calls;
  for (const int error : {ENOSPC, EIO, EACCES}) {
    for (const bool stays : {false, true}) {
      for (int call = 1; call <= calls; ++call) {
        prepare();
        const Fault fault{call, error, stays};
        check(fault, run(folder, fault, body));
      }
    }
  }
  return calls;
}

/// What the operating system says of the fault.
inline std::string words(const Fault& fault) {
  return std::generic_category().message(fault.error);
}

}  // namespace palpate::faults
