// umax-import: reads one mesh file of a foreign format for umax, which starts it for that
// (embedding/mesh_files/foreign_mesh.h), and writes what it holds as a record to its standard output. Whatever the file
// does to the library that reads it ends this program and no other.
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "embedding/foreign_files/foreign_file.h"
#include "embedding/mesh_record/mesh_record.h"

namespace {

void limit(int resource, unsigned long long soft, unsigned long long hard) {
  const rlimit values{rlim_t(soft), rlim_t(hard)};
  ::setrlimit(__rlimit_resource_t(resource), &values);
}

void limit_memory([[maybe_unused]] unsigned long long bytes) {
#ifndef __SANITIZE_ADDRESS__  // whose shadow needs more addresses than there is memory
  limit(RLIMIT_AS, bytes, bytes);
#endif
}

void end_for_want_of_memory() {
  ::_exit(umax::import_out_of_memory);
}

void put(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(umax::import_not_written);
    bytes.remove_prefix(std::size_t(written));
  }
}

/// Tells by the end of its messages that the record is whole; then the system frees what is left faster than we do.
[[noreturn]] void finish() {
  ::close(STDERR_FILENO);
  ::_exit(0);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 6) {
    std::fprintf(stderr, "umax-import: reads meshes for umax, which starts it\n");
    return 2;
  }
  if (std::atoi(arguments[1]) != umax::mesh_record_version) return umax::import_other_version;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const unsigned long long seconds = std::strtoull(arguments[3], nullptr, 10);
  limit(RLIMIT_CORE, 0, 0);
  limit(RLIMIT_CPU, seconds, seconds + 1);
  limit_memory(std::strtoull(arguments[2], nullptr, 10));
  std::set_new_handler(end_for_want_of_memory);
  try {
    umax::read_with_assimp(arguments[5], arguments[4], [](umax::MeshFile&& file) {
      umax::put_mesh_record(file, put);
      finish();
    });
  } catch (const umax::Error& error) {
    umax::put_error_record(error, put);
  }
  finish();
}
