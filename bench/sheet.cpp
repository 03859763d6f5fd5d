/// Macro-benchmark: the sheet that hangs by two corners (dt = 0.01 s) and sheet P (dt = 0.02 s)
/// over their first 0.4 s, by nodes, integrator, solver and threads. Each case runs in a process of
/// its own, with a time limit, so that its peak memory is its own and its failure nobody else's.
/// Writes a JSON list, one object a case: sheet_case.h says what is in it.
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <poll.h>
#include <signal.h>
#include <unistd.h>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <sys/wait.h>

#include "sheet_case.h"

namespace {
using namespace deform::bench;
using nlohmann::json;

struct Options {
  std::vector<std::string> scenes{"hanging", "sheet_p_1e-6", "sheet_p_1e-4"};
  std::vector<std::int64_t> nodes{33, 65, 129, 257, 513, 1025};
  std::vector<std::string> integrators{"backward_euler", "bdf2", "implicit_midpoint"};
  std::vector<std::string> solvers{"automatic", "cholmod"};
  std::vector<int> threads{1, 2};
  long steps = 0;
  double tolerance = 0;
  std::vector<double> newton_errors{0, 1e-4};
  int seconds = 600;
  std::string out;
};

int parse(int argc, char** argv, Options& o) {
  CLI::App app("Measures steps of the hanging sheet and of sheet P.");
  app.add_option("--scene", o.scenes, "hanging, sheet_p_1e-6, sheet_p_1e-4")
      ->check(CLI::IsMember({"hanging", "sheet_p_1e-6", "sheet_p_1e-4"}))
      ->delimiter(',');
  app.add_option("--nodes", o.nodes, "nodes a side")->check(CLI::PositiveNumber)->delimiter(',');
  app.add_option("--integrator", o.integrators, "of the hanging sheet")->delimiter(',');
  app.add_option("--solver", o.solvers, "linear solvers; automatic: chosen by deform")
      ->delimiter(',');
  app.add_option("--threads", o.threads)->check(CLI::PositiveNumber)->delimiter(',');
  app.add_option("--steps", o.steps, "at most so many (0: all of the first 0.4 s)");
  app.add_option("--tolerance", o.tolerance, "of Newton's method (0: the integrator's own)");
  app.add_option("--newton-error", o.newton_errors,
                 "that Newton's method may leave (0: its tolerance decides)")
      ->delimiter(',');
  app.add_option("--seconds", o.seconds, "time limit of a case")->check(CLI::PositiveNumber);
  app.add_option("--out", o.out, "JSON file (default: standard output)");
  CLI11_PARSE(app, argc, argv);
  return -1;
}

std::vector<SheetCase> cases(const Options& o) {
  std::vector<SheetCase> all;
  for (const std::string& scene : o.scenes) {
    const bool hanging = scene == "hanging";
    // Sheet P is the paper's, and so is its integrator.
    for (const std::string& integrator :
         hanging ? o.integrators : std::vector<std::string>{"semi_implicit"})
      for (const std::string& solver : o.solvers)
        for (const std::int64_t nodes : o.nodes)
          for (const int threads : o.threads)
            for (const double error : hanging ? o.newton_errors : std::vector<double>{0})
              all.push_back({scene, nodes, integrator, solver, threads, o.steps,
                             hanging ? o.tolerance : 0, error});
  }
  return all;
}

[[noreturn]] void measure_and_exit(const SheetCase& c, int pipe) {
  json result;
  try {
    result = measure(c);
  } catch (const std::exception& error) {
    result["status"] = error.what();
  }
  const std::string text = result.dump();
  const bool written = write(pipe, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  _exit(written ? 0 : 1);
}

/// All that comes from the pipe within the time; false when the time was up.
bool read_all(int pipe, int seconds, std::string& text) {
  pollfd wait{pipe, POLLIN, 0};
  // The child writes once, at its end: a limit for the first byte is a limit for the case.
  int ready = 0;
  do ready = poll(&wait, 1, 1000 * seconds);
  while (ready < 0 && errno == EINTR);
  if (ready <= 0) return false;
  char buffer[4096];
  for (ssize_t n = 0; (n = read(pipe, buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(n));
  return true;
}

json run(const SheetCase& c, int seconds) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    close(ends[0]);
    measure_and_exit(c, ends[1]);
  }
  close(ends[1]);
  std::string text;
  const bool in_time = read_all(ends[0], seconds, text);
  close(ends[0]);
  if (!in_time) kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  json result = description(c);
  if (!in_time)
    result["status"] = fmt::format("not done after {} s", seconds);
  else if (text.empty())
    result["status"] = fmt::format("crashed (signal {})", WTERMSIG(status));
  else
    result.update(json::parse(text));
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  Options options;
  if (const int code = parse(argc, argv, options); code >= 0) return code;
  json results = json::array();
  for (const SheetCase& c : cases(options)) {
    results.push_back(run(c, options.seconds));
    const json& last = results.back();
    fmt::print(stderr, "{} {}² {} {} {} threads: {} ms, {}\n", c.scene, c.nodes, c.integrator,
               c.solver, c.threads, last.contains("ms") ? last["ms"]["median"].dump() : "–",
               last["status"].get<std::string>());
    // After every case: what is measured stays when a later one is interrupted.
    if (!options.out.empty() && !(std::ofstream(options.out) << results.dump(1) << '\n')) {
      fmt::print(stderr, "{} cannot be written\n", options.out);
      return 1;
    }
  }
  if (options.out.empty()) std::cout << results.dump(1) << '\n';
  return 0;
}
