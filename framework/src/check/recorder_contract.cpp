/// Probes and outputs, on a sheet that hangs from one side.
#include <cmath>
#include <filesystem>
#include <random>
#include <set>

#include <fmt/format.h>

#include "check/bitwise.h"
#include "check/contracts.h"
#include "simulation/recorders.h"
#include "simulation/run_parts.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

constexpr int kSteps = 3;

/// A folder of its own, gone at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::random_device random;
    path_ =
        fs::temp_directory_path() / fmt::format("deform_check_{:08x}{:08x}", random(), random());
    fs::create_directory(path_);
  }
  ~TemporaryFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// What a plugin remembers must be all that another object of it needs.
void check_memory(const Plugin& from, Plugin& to, Checks& checks) {
  Memory saved, again;
  from.save(saved);
  to.load(saved);
  to.save(again);
  checks.holds("saved, loaded and saved again, its memory is the same",
               saved.entries() == again.entries(), "it differs");
}

/// All rows of the probes of one run.
std::vector<double> figures_of_run(const Subject& subject, const Terrain& terrain,
                                   const fs::path& folder, Checks& checks) {
  RunParts parts = make_run_parts(subject.scene(terrain), subject.registry());
  const RunContext context = make_run_context(parts, folder);
  begin_probes(parts, context);
  parts.probes->open(folder / "probes.csv");
  checks.holds("has columns", !parts.probes->columns().empty(), "columns() is empty after begin");
  std::vector<double> figures;
  for (int i = 0; i <= kSteps; ++i) {
    if (i > 0) parts.simulation->step();
    const Frame frame = parts.simulation->frame();
    parts.probes->follow(frame);
    parts.probes->record(frame, true);
    for (const ColumnSummary& column : parts.probes->summaries()) figures.push_back(column.last);
  }
  return figures;
}

void check_probe(const Subject& subject, const Terrain& terrain, Checks& checks) {
  const TemporaryFolder folder;
  const std::vector<double> figures = figures_of_run(subject, terrain, folder.path(), checks);
  const auto missing = std::ranges::count_if(figures, [](double x) { return std::isnan(x); });
  checks.report("figures in the rows",
                fmt::format("{}, of which {} empty", figures.size(), missing));
  checks.holds("same figures in another run",
               same_bits(figures_of_run(subject, terrain, folder.path(), checks), figures),
               "they differ");
  checks.holds("same figures on any number of threads", same_on_threads([&] {
                 return figures_of_run(subject, terrain, folder.path(), checks);
               }),
               "one thread and several differ");
}

void check_probe_memory(const Subject& subject, const Terrain& terrain, Checks& checks) {
  const TemporaryFolder folder;
  Simulation simulation = subject.simulation(terrain);
  const RunContext context{folder.path(), "check", simulation.system(),
                           [&simulation] { return simulation.mirrored(); }};
  const auto first = subject.make<Probe>(terrain).object,
             second = subject.make<Probe>(terrain).object;
  first->begin(context);
  for (int i = 0; i < kSteps; ++i) {
    simulation.step();
    first->follow(simulation.frame());
  }
  second->begin(context);
  check_memory(*first, *second, checks);
}

std::set<fs::path> files_below(const fs::path& folder) {
  std::set<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.insert(entry.path());
  return files;
}

void check_output(const Subject& subject, const Terrain& terrain, int frames, Checks& checks) {
  const TemporaryFolder outside;
  const fs::path folder = outside.path() / "run";
  fs::create_directory(folder);
  RunParts parts = make_run_parts(subject.scene(terrain), subject.registry());
  const RunContext context = make_run_context(parts, folder);
  parts.outputs->begin(context);
  BackgroundQueue queue;
  for (int i = 0; i < frames; ++i) {
    if (i > 0) parts.simulation->step();
    parts.outputs->record(parts.simulation->frame(), true, queue);
  }
  queue.drain();
  parts.outputs->end();
  const std::set<fs::path> files = files_below(folder);
  checks.holds("writes below the run's folder only", files_below(outside.path()) == files,
               "there are other files beside the folder");
  if (frames == 0) return;
  std::uintmax_t bytes = 0;
  for (const fs::path& file : files) bytes += fs::file_size(file);
  checks.holds("writes something", bytes > 0, "no file, or none with anything in it");
  checks.report("files and bytes of three frames", fmt::format("{}, {}", files.size(), bytes));
}

}  // namespace

void check_probe_contract(const Subject& subject, Checks& checks) {
  for (const Terrain& terrain : terrains(9, 7)) {
    checks.at(terrain.name);
    checks.runs("measures", [&] {
      check_probe(subject, terrain, checks);
      check_probe_memory(subject, terrain, checks);
    });
  }
}

void check_output_contract(const Subject& subject, Checks& checks) {
  for (const Terrain& terrain : {terrains(9, 7).front(), terrains(9, 7)[5]}) {
    checks.at(terrain.name);
    checks.runs("writes", [&] { check_output(subject, terrain, kSteps, checks); });
    checks.runs("ends well without a frame", [&] { check_output(subject, terrain, 0, checks); });
  }
}

}  // namespace deform
