/// The probes and outputs of a run.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "deform/record/output.h"
#include "deform/record/probe.h"

#include "parallel/background_queue.h"
#include "simulation/part_maker.h"
#include "simulation/probe_table.h"

namespace deform {

/// Measures a scene's probes and writes their figures to probes.csv. Everything that a probe throws
/// is reported with its name, as a PluginFailure.
class ProbeRecorder {
 public:
  /// Makes the probes; problems are left with the maker.
  ProbeRecorder(const std::vector<PluginUse>& uses, PartMaker& maker, const Setup& setup);

  /// Adds a probe that no plugin made, which the scene asks for at `pointer`. It measures whenever
  /// another one does; where there is none, at every step.
  void add(Named<Probe> probe, std::string pointer);

  /// Begins the probes, whose columns are known then. Throws InputError for what a probe rejects.
  void begin(const RunContext& context);
  /// Starts the file, or goes on after its first `keep` bytes.
  void open(const std::filesystem::path& file, std::size_t keep = 0);
  /// Has all rows put on disk; returns what the file holds.
  [[nodiscard]] WrittenFile sync();
  /// Ends the file; returns what it holds; nothing where it was not opened.
  std::optional<WrittenFile> close();
  /// To be called after every step.
  void follow(const Frame& frame);
  /// To be called within a step where it is not smooth.
  void follow_break(const Frame& frame);
  [[nodiscard]] bool due(long step) const;
  /// Writes a row with the figures that are due at this step, or all; no row when none is due, or
  /// when the step has one already.
  void record(const Frame& frame, bool all);

  /// What the probes remember and the figures so far. Loading comes after `begin`; it throws
  /// InputError when the memory is not that of these probes.
  void save(Memory& memory) const;
  void load(const Memory& memory);

  [[nodiscard]] bool none() const { return probes_.empty(); }
  [[nodiscard]] const std::vector<ProbeColumn>& columns() const { return columns_; }
  /// One a column.
  [[nodiscard]] const std::vector<ColumnSummary>& summaries() const { return summaries_; }

 private:
  struct Entry {
    Named<Probe> probe;
    long every = 1;  // 0: with any other
    std::string pointer;
    std::size_t first = 0, size = 0;  // its columns
  };
  [[nodiscard]] static bool is_due(const Entry& entry, long step) {
    return entry.every > 0 && step % entry.every == 0;
  }
  void measure(const Entry& entry, const Frame& frame);

  std::vector<Entry> probes_;
  std::vector<ProbeColumn> columns_;
  std::vector<ColumnSummary> summaries_;
  std::vector<double> row_;
  std::vector<double> figures_;  // of one probe, with a margin
  long last_row_ = -1;           // step
  std::unique_ptr<ProbeTable> table_;
};

/// Hands frames to a scene's outputs.
class OutputRecorder {
 public:
  OutputRecorder(const std::vector<PluginUse>& uses, PartMaker& maker, const Setup& setup);
  void begin(const RunContext& context);
  /// Writes the outputs that are due at this step, or all; none twice at a step. What can wait
  /// goes into the queue.
  void record(const Frame& frame, bool all, BackgroundQueue& queue);
  [[nodiscard]] bool due(long step) const;
  /// What the outputs remember. Loading comes after `begin`.
  void save(Memory& memory) const;
  void load(const Memory& memory);
  /// What the outputs have written into the run directory, by name. Nothing of those that do not
  /// say where they write.
  [[nodiscard]] std::vector<WrittenFile> files(const std::filesystem::path& folder) const;
  /// Ends every output that was begun, even where another one fails; then throws the first failure.
  void end();

 private:
  struct Entry {
    Named<Output> output;
    long every = 1;
    std::string place;  // Output::place
    long last = -1;     // step written
  };
  std::vector<Entry> outputs_;
  std::size_t begun_ = 0;
};

}  // namespace deform
