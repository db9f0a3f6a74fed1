#include <sys/resource.h>

#include <csignal>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/error_code_of.h"
#include "tools/run/steps_csv.h"

using namespace umax;

namespace {

StepRow row(long long step) {
  StepRow row{.step = step,
              .frame = int(step) + 1,
              .time = double(step) / 60,
              .hexes = 56,
              .report = {},
              .wall_ms = 1.25,
              .probes = {}};
  row.report.limits_active = 3;
  row.report.max_energy_ratio = 1.0005;
  if (step % 3 == 0) row.report.status = StepStatus::iteration_limit;
  return row;
}

std::string text_of_rows(long long last) {
  std::string text = steps_header({}) + "\n";
  for (long long step = 1; step <= last; ++step) text += format_step(row(step)) + "\n";
  return text;
}

}  // namespace

TEST_CASE("steps.csv has the columns that scripts rely on, in their order") {
  CHECK(steps_header({}) ==
        "step,frame,time_s,status,hexes,limits_active,contacts,sqp_iterations,factorisations,linear_iterations,retries,"
        "max_energy_ratio,kkt_residual,max_penetration_m,kinetic_energy_J,elastic_energy_J,potential_energy_J,wall_ms,"
        "contacts_obstacles,contacts_bodies,contacts_self,substeps");
  // what came later stands behind the probes, whose places scripts know, too
  CHECK(steps_header({"tip", "heel"})
            .find(",wall_ms,tip_x_m,tip_y_m,tip_z_m,heel_x_m,heel_y_m,heel_z_m,contacts_obstacles,contacts_bodies,") !=
        std::string::npos);
}

TEST_CASE("a row has one value for each column") {
  StepRow with_probe = row(6);
  with_probe.probes = {Vector3d(0.5, -0.25, 1e-9)};
  with_probe.report.contacts = 9;
  with_probe.report.contacts_obstacles = 2;
  with_probe.report.contacts_between = 3;
  with_probe.report.contacts_within = 4;
  CHECK(format_step(with_probe) ==
        "6,7,0.1,iteration_limit,56,3,9,0,0,0,0,1.0005,0,0,0,0,0,1.250,0.5,-0.25,1e-09,2,3,4,1");
}

TEST_CASE("rows are appended and read back") {
  const TemporaryFolder folder;
  const auto path = folder / "steps.csv";
  {
    StepsFile file(path, steps_header({}), 0);
    file.append({row(1), row(2)});
    file.append({row(3)});
  }
  CHECK(file_text(path) == text_of_rows(3));
  const StepsFound found = read_steps(path, steps_header({}));
  CHECK(found.rows == 3);
  CHECK(found.converged == std::vector<bool>{true, true, false});
  CHECK(found.columns.at("time_s") == std::vector<double>{1.0 / 60, 2.0 / 60, 3.0 / 60});
  CHECK(found.columns.at("limits_active") == std::vector<double>{3, 3, 3});
  CHECK(found.columns.at("wall_ms") == std::vector<double>{1.25, 1.25, 1.25});
  CHECK(found.columns.at("substeps") == std::vector<double>{1, 1, 1});
}

TEST_CASE("a run that goes on keeps the rows up to its state and loses the rest") {
  const TemporaryFolder folder;
  const auto path = folder / "steps.csv";
  make_file(path, text_of_rows(7) + "8,9,0.13");
  CHECK(read_steps(path, steps_header({})).rows == 7);
  {
    StepsFile file(path, steps_header({}), 4);
    file.append({row(5)});
  }
  CHECK(file_text(path) == text_of_rows(5));
}

TEST_CASE("rows behind a gap do not count") {
  const TemporaryFolder folder;
  const auto path = folder / "steps.csv";
  make_file(path, text_of_rows(2) + format_step(row(4)) + "\n");
  CHECK(read_steps(path, steps_header({})).rows == 2);
}

TEST_CASE("a file with other columns is refused, a missing one has no rows") {
  const TemporaryFolder folder;
  make_file(folder / "steps.csv", text_of_rows(2));
  CHECK(error_code_of([&] { read_steps(folder / "steps.csv", steps_header({"tip"})); }) == 65);
  CHECK(read_steps(folder / "none.csv", steps_header({})).rows == 0);
}

TEST_CASE("a full disk leaves whole rows and an error 74") {
  const TemporaryFolder folder;
  const auto path = folder / "steps.csv";
  StepsFile file(path, steps_header({}), 0);
  file.append({row(1)});
  // the file is limited to a few bytes more than it has: the next row does not fit
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = std::filesystem::file_size(path) + 10;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  const int code = error_code_of([&] { file.append({row(2)}); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  CHECK(code == 74);
  CHECK(file_text(path) == text_of_rows(1));
}
