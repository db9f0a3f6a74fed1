// Who is at work in a folder, on this machine and on others, and who has what.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <thread>

#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tests/tools/program.h"
#include "tools/system/locked_folder.h"
#include "tools/system/presence.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

/// A file that somebody left `age` seconds ago.
void leave(const fs::path& path, const Worker& worker, double age) {
  make_file(path, worker_text(worker));
  timespec times[2];
  clock_gettime(CLOCK_REALTIME, &times[0]);
  times[0].tv_sec -= long(age);
  times[1] = times[0];
  REQUIRE(utimensat(AT_FDCWD, path.c_str(), times, 0) == 0);
}

Worker elsewhere() {
  Worker worker = this_worker("draw");
  worker.host = "another-machine";
  return worker;
}

/// A process of this machine that has ended.
Worker ended() {
  const pid_t child = fork();
  if (child == 0) pause();
  Worker worker = this_worker("draw");
  worker.process = child;
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  return worker;
}

std::size_t files_in_place(const fs::path& place) {
  return std::size_t(std::distance(fs::directory_iterator(place), fs::directory_iterator()));
}

constexpr FolderKind kind{"test of umax", ".place", [](const fs::path&) { return true; }};

}  // namespace

TEST_CASE("who comes has said who it is as soon as it is seen") {
  const TemporaryFolder folder;
  const fs::path place = folder / "place";
  fs::create_directories(place);
  const int nameless = ::open(place.c_str(), O_WRONLY | O_TMPFILE, 0666);
  if (nameless < 0) {
    WARN("this file system has no files without names");
    return;
  }
  ::close(nameless);
  std::atomic<bool> is_over = false;
  std::thread coming([&] {
    for (int i = 0; i < 2000; ++i) const Presence presence(place, "draw");
    is_over = true;
  });
  int seen = 0, unknown = 0;
  while (!is_over)
    for (const Worker& worker : workers_in(place)) (worker.process == getpid() ? seen : unknown) += 1;
  coming.join();
  CHECK(seen > 0);
  CHECK(unknown == 0);
}

TEST_CASE("a worker's text tells who it is, and half of it does not") {
  const Worker worker = this_worker("draw, clip");
  const std::string text = worker_text(worker);
  const auto back = parse_worker(text);
  REQUIRE(back);
  CHECK(worker_text(*back) == text);
  CHECK(back->role == "draw, clip");
  CHECK(back->process == getpid());
  CHECK(back->start > 0);
  CHECK(!parse_worker(text.substr(0, text.size() / 2)));
  CHECK(!parse_worker(""));
}

TEST_CASE("a process of this machine is alive as long as it runs, whatever its heart does") {
  const Worker self = this_worker("");
  CHECK(is_alive(self, 0));
  CHECK(is_alive(self, 1e6));
  CHECK(!is_alive(ended(), 0));
  // its number may be another's by now
  Worker later = self;
  later.start += 1;
  CHECK(!is_alive(later, 0));
}

TEST_CASE("of a process of another machine, boot or container only the heart tells") {
  for (const auto change :
       {+[](Worker& worker) { worker.host = "another"; }, +[](Worker& worker) { worker.boot = "b"; },
        +[](Worker& worker) { worker.processes = "pid:[1]"; }, +[](Worker& worker) { worker.start = 0; }}) {
    Worker worker = ended();
    change(worker);
    CHECK(is_alive(worker, 59));
    CHECK(!is_alive(worker, 61));
    worker.lease = 5;
    CHECK(!is_alive(worker, 6));
  }
}

TEST_CASE("a claim is one's own until it is released, and nothing is left behind") {
  const TemporaryFolder folder;
  const fs::path place = folder / "place";
  {
    Presence one(place, "draw"), other(place, "draw");
    CHECK(one.claim("frame-0001"));
    CHECK(!other.claim("frame-0001"));
    CHECK(!one.claim("frame-0001"));
    CHECK(other.claim("frame-0002"));
    CHECK(one.holds("frame-0001"));
    CHECK(!other.holds("frame-0001"));
    CHECK(one.others().size() == 1);
    CHECK(one.claimed_by_others() == std::set<std::string>{"frame-0002"});
    CHECK(workers_in(place).size() == 2);
    one.release("frame-0001");
    CHECK(other.claim("frame-0001"));
  }
  CHECK(!fs::exists(place));
  CHECK(workers_in(place).empty());
}

TEST_CASE("who cannot say who it is leaves no place behind") {
  const TemporaryFolder folder;
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit none{.rlim_cur = 0, .rlim_max = before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &none);
  const int code = error_code_of([&] { Presence(folder / "place", "draw"); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  CHECK(code == 73);
  CHECK(!fs::exists(folder / "place"));
}

TEST_CASE("what the gone have claimed is free, on this machine at once, on others after their lease") {
  const TemporaryFolder folder;
  const fs::path place = folder / "place";
  fs::create_directories(place);
  leave(place / "frame-0001.1", ended(), 0);
  leave(place / "frame-0002.1", elsewhere(), 59);
  leave(place / "frame-0003.1", elsewhere(), 62);
  leave(place / "frame-0003.2", elsewhere(), 1);
  leave(place / "frame-0004.1", elsewhere(), 62);
  make_file(place / "frame-0005.1", "");  // somebody is writing it
  {
    Presence presence(place, "draw");
    CHECK(presence.claim("frame-0001"));
    CHECK(!presence.claim("frame-0002"));
    CHECK(!presence.claim("frame-0003"));
    CHECK(presence.claim("frame-0004"));
    CHECK(!presence.claim("frame-0005"));
    CHECK(presence.claimed_by_others() == std::set<std::string>{"frame-0002", "frame-0003", "frame-0005"});
    // somebody who thinks us gone takes it over
    leave(place / "frame-0001.3", elsewhere(), 0);
    CHECK(!presence.holds("frame-0001"));
  }
  CHECK(!fs::exists(place / "frame-0004.1"));  // what we followed goes with ours
}

TEST_CASE("sweeping removes what the gone left, and nothing of the living") {
  const TemporaryFolder folder;
  const fs::path place = folder / "place";
  fs::create_directories(place);
  leave(place / "worker-1", ended(), 0);
  leave(place / "frame-0001.1", ended(), 0);
  leave(place / "frame-0001.2", elsewhere(), 100);
  leave(place / "worker-2", elsewhere(), 1);
  leave(place / "frame-0002.1", elsewhere(), 1);
  Presence presence(place, "draw");
  presence.claim("frame-0003");
  presence.sweep();
  CHECK(files_in_place(place) == 4);
  CHECK(fs::exists(place / "worker-2"));
  CHECK(fs::exists(place / "frame-0002.1"));
  CHECK(presence.holds("frame-0003"));
}

TEST_CASE("of many who grasp at once one gets it, also at what the gone had") {
  const TemporaryFolder folder;
  const fs::path place = folder / "place";
  fs::create_directories(place);
  constexpr int num_workers = 8, num_claims = 60;
  std::vector<std::atomic<int>> owners(num_claims);
  for (int i = 0; i < num_claims; i += 2) leave(place / ("frame-" + std::to_string(i) + ".1"), elsewhere(), 100);
  std::vector<std::thread> threads;
  for (int k = 0; k < num_workers; ++k)
    threads.emplace_back([&] {
      Presence presence(place, "draw");
      for (int i = 0; i < num_claims; ++i) {
        const std::string name = "frame-" + std::to_string(i);
        for (int attempt = 0; attempt < 3; ++attempt) {
          if (!presence.claim(name)) continue;
          if (owners[std::size_t(i)]++ != 0) owners[std::size_t(i)] += 100;  // somebody else has it, too
          std::this_thread::yield();
          --owners[std::size_t(i)];
          presence.release(name);
        }
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const auto& owner : owners) CHECK(owner == 0);
}

TEST_CASE("the heart beats, for others on other machines to see") {
  const TemporaryFolder folder;
  const fs::path place = folder / "place";
  setenv("UMAX_LEASE", "1", 1);
  Presence presence(place, "draw");
  unsetenv("UMAX_LEASE");
  REQUIRE(presence.claim("frame-0001"));
  const auto before = fs::last_write_time(place / "frame-0001.1");
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  CHECK(fs::last_write_time(place / "frame-0001.1") > before);
}

TEST_CASE("a bad lease is wrong usage") {
  const TemporaryFolder folder;
  for (const char* lease : {"0", "-5", "soon", "", "1e9"}) {
    setenv("UMAX_LEASE", lease, 1);
    CHECK(error_code_of([&] { const Presence presence(folder / "place", ""); }) == 2);
  }
  unsetenv("UMAX_LEASE");
}

TEST_CASE("a folder is held by one alone or shared by many") {
  const TemporaryFolder folder;
  const auto code = [&](FolderUse use) {
    return error_code_of([&] { const LockedFolder held(folder / "f", ExistingFolder::keep, kind, use); });
  };
  {
    LockedFolder alone(folder / "f", ExistingFolder::keep, kind);
    CHECK(code(FolderUse::alone) == 75);
    CHECK(code(FolderUse::shared) == 75);
    alone.share();
    CHECK(code(FolderUse::alone) == 75);
    CHECK(code(FolderUse::shared) == 0);
  }
  {
    const LockedFolder one(folder / "f", ExistingFolder::keep, kind, FolderUse::shared);
    const LockedFolder other(folder / "f", ExistingFolder::keep, kind, FolderUse::shared);
    CHECK(code(FolderUse::alone) == 75);
  }
  CHECK(code(FolderUse::alone) == 0);
}

TEST_CASE("who has been taken for gone finds that the folder is another's") {
  const TemporaryFolder folder;
  const LockedFolder held(folder / "f", ExistingFolder::keep, kind);
  held.require_hold();
  leave(folder / "f/.place/owner.2", elsewhere(), 0);
  CHECK(error_code_of([&] { held.require_hold(); }) == 75);
}
