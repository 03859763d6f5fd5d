#include "simulation/recorders.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "plugin/common_parameters.h"
#include "plugin/guard.h"
#include "profile/profile.h"
#include "simulation/memory_sections.h"

namespace deform {
namespace {

/// What a figure is until its probe writes it: a NaN that no arithmetic gives, so that a figure
/// which was not written is told from one that is not there (kNoFigure).
const auto kUnwritten = std::bit_cast<double>(std::uint64_t{0x7FF8'0BAD'0BAD'0BAD});
/// Behind a probe's figures, for those that write too many.
constexpr std::size_t kMargin = 16;

/// Where a checkpoint keeps last, smallest and largest figure of each column.
constexpr const char* kFigures = "probes/figures";

bool is_written(double figure) {
  return std::bit_cast<std::uint64_t>(figure) != std::bit_cast<std::uint64_t>(kUnwritten);
}

}  // namespace

ProbeRecorder::ProbeRecorder(const std::vector<PluginUse>& uses, PartMaker& maker,
                             const Setup& setup) {
  for (const PluginUse& use : uses) {
    if (auto probe = maker.make<Probe>(use, setup)) {
      probes_.push_back({std::move(*probe), common_parameters<Probe>(use).every, use.pointer});
    }
  }
}

void ProbeRecorder::add(Named<Probe> probe, std::string pointer) {
  const long every = probes_.empty() ? 1 : 0;
  probes_.push_back({std::move(probe), every, std::move(pointer)});
}

void ProbeRecorder::begin(const RunContext& context) {
  std::vector<Problem> problems;
  for (Entry& entry : probes_) {
    guarded(entry.probe.origin, "beginning", [&] {
      try {
        entry.probe.object->begin(context);
        const std::vector<ProbeColumn> columns = entry.probe.object->columns();
        entry.first = columns_.size();
        entry.size = columns.size();
        for (const ProbeColumn& column : columns) {
          if (column.name.empty()) throw Error(ExitCode::plugin_failed, "a column has no name");
        }
        columns_.insert(columns_.end(), columns.begin(), columns.end());
      } catch (const InputError& e) {
        for (const Problem& problem : e.problems()) {
          problems.push_back(
              {entry.pointer, fmt::format("at {}: {}", entry.pointer, problem.message)});
        }
      }
    });
  }
  if (!problems.empty()) throw InputError(problems);
  columns_ = with_unique_names(std::move(columns_));
  summaries_.resize(columns_.size());
  row_.resize(columns_.size());
}

void ProbeRecorder::open(const std::filesystem::path& file, std::size_t keep) {
  table_ = std::make_unique<ProbeTable>(file, columns_, keep);
}

WrittenFile ProbeRecorder::sync() { return table_->sync(); }

std::optional<WrittenFile> ProbeRecorder::close() {
  if (!table_) return std::nullopt;
  return table_->close();
}

void ProbeRecorder::save(Memory& memory) const {
  std::vector<double> figures;
  for (const ColumnSummary& s : summaries_)
    figures.insert(figures.end(), {s.last, s.minimum, s.maximum});
  memory.put(kFigures, figures);
  for (const Entry& entry : probes_) {
    save_plugin(*entry.probe.object, entry.probe.origin, "probe/" + entry.probe.name, memory);
  }
}

void ProbeRecorder::load(const Memory& memory) {
  const std::vector<double>& figures = memory.get(kFigures, 3 * summaries_.size());
  for (std::size_t i = 0; i < summaries_.size(); ++i) {
    summaries_[i] = {figures[3 * i], figures[3 * i + 1], figures[3 * i + 2]};
  }
  for (const Entry& entry : probes_) {
    load_plugin(*entry.probe.object, entry.probe.origin, "probe/" + entry.probe.name, memory);
  }
}

void ProbeRecorder::follow(const Frame& frame) {
  const Span probes("probes");
  for (const Entry& entry : probes_) {
    const Span span(entry.probe.name);
    guarded(entry.probe.origin, "following a step", [&] { entry.probe.object->follow(frame); });
  }
}

void ProbeRecorder::follow_break(const Frame& frame) {
  const Span probes("probes");
  for (const Entry& entry : probes_) {
    const Span span(entry.probe.name);
    guarded(entry.probe.origin, "following a step",
            [&] { entry.probe.object->follow_break(frame); });
  }
}

void ProbeRecorder::measure(const Entry& entry, const Frame& frame) {
  const Span span(entry.probe.name);
  figures_.assign(entry.size + kMargin, kUnwritten);
  const Values figures = std::span(figures_).first(entry.size);
  guarded(entry.probe.origin, "measuring", [&] { entry.probe.object->measure(frame, figures); });
  const auto written = static_cast<std::size_t>(std::ranges::count_if(figures_, is_written));
  if (written != entry.size) {
    throw PluginFailure(fmt::format("plugin {} wrote {} figures, expected {}, one for each column",
                                    entry.probe.origin, written, entry.size));
  }
  std::ranges::copy(figures, row_.begin() + static_cast<std::ptrdiff_t>(entry.first));
  for (std::size_t i = entry.first; i < entry.first + entry.size; ++i) {
    if (std::isinf(row_[i])) {
      throw PluginFailure(
          fmt::format("plugin {} measured an infinite {}", entry.probe.origin, columns_[i].name));
    }
    summaries_[i].add(row_[i]);
  }
}

bool ProbeRecorder::due(long step) const {
  return std::any_of(probes_.begin(), probes_.end(),
                     [step](const Entry& entry) { return is_due(entry, step); });
}

void ProbeRecorder::record(const Frame& frame, bool all) {
  if (frame.step == last_row_ || !(all || frame.step == 0 || due(frame.step))) return;
  const Span span("probes");
  std::fill(row_.begin(), row_.end(), kNoFigure);
  for (const Entry& entry : probes_) {
    if (all || entry.every == 0 || is_due(entry, frame.step)) measure(entry, frame);
  }
  table_->append(frame.step, frame.state.time, row_);
  last_row_ = frame.step;
}

OutputRecorder::OutputRecorder(const std::vector<PluginUse>& uses, PartMaker& maker,
                               const Setup& setup) {
  std::map<std::string, std::string> pointers;  // by place
  for (const PluginUse& use : uses) {
    auto output = maker.make<Output>(use, setup);
    if (!output) continue;
    const std::string place =
        guarded(output->origin, "saying where it writes", [&] { return output->object->place(); });
    const auto [first, is_new] = pointers.emplace(place, use.pointer);
    if (!place.empty() && !is_new)
      maker.add({{use.pointer, fmt::format("at {}: writes into \"{}\" of the run directory, as "
                                           "the output at {} does: keep one of them",
                                           use.pointer, place, first->second)}});
    outputs_.push_back({std::move(*output), common_parameters<Output>(use).every, place});
  }
}

void OutputRecorder::begin(const RunContext& context) {
  for (const Entry& entry : outputs_) {
    ++begun_;  // one that fails on the way may have files open
    guarded(entry.output.origin, "beginning", [&] { entry.output.object->begin(context); });
  }
}

bool OutputRecorder::due(long step) const {
  return std::any_of(outputs_.begin(), outputs_.end(),
                     [step](const Entry& entry) { return step % entry.every == 0; });
}

void OutputRecorder::record(const Frame& frame, bool all, BackgroundQueue& queue) {
  const Span outputs("outputs");
  for (Entry& entry : outputs_) {
    if (frame.step == entry.last || !(all || frame.step % entry.every == 0)) continue;
    const Span span(entry.output.name);
    std::function<void()> rest =
        guarded(entry.output.origin, "writing", [&] { return entry.output.object->take(frame); });
    if (rest)
      queue.add([origin = entry.output.origin, rest = std::move(rest)] {
        guarded(origin, "writing", rest);
      });
    entry.last = frame.step;
  }
}

void OutputRecorder::save(Memory& memory) const {
  for (const Entry& entry : outputs_) {
    save_plugin(*entry.output.object, entry.output.origin, "output/" + entry.output.name, memory);
  }
}

void OutputRecorder::load(const Memory& memory) {
  for (const Entry& entry : outputs_) {
    load_plugin(*entry.output.object, entry.output.origin, "output/" + entry.output.name, memory);
  }
}

std::vector<WrittenFile> OutputRecorder::files(const std::filesystem::path& folder) const {
  namespace fs = std::filesystem;
  std::vector<WrittenFile> files;
  const auto add = [&](const fs::directory_entry& entry) {
    if (!entry.is_regular_file() || entry.path().extension() == ".part") return;
    files.push_back({entry.path().lexically_relative(folder).string(), entry.file_size(), ""});
  };
  for (const Entry& entry : outputs_) {
    if (entry.place.empty()) continue;
    const fs::directory_entry place(folder / entry.place);
    if (!place.is_directory()) {
      add(place);
      continue;
    }
    for (const auto& file : fs::recursive_directory_iterator(place)) add(file);
  }
  std::ranges::sort(files, {}, &WrittenFile::name);
  return files;
}

void OutputRecorder::end() {
  std::exception_ptr first;
  const std::size_t begun = std::exchange(begun_, 0);
  for (std::size_t i = 0; i < begun; ++i) {
    const Entry& entry = outputs_[i];
    try {
      guarded(entry.output.origin, "ending", [&] { entry.output.object->end(); });
    } catch (const Error&) {
      if (!first) first = std::current_exception();
    }
  }
  if (first) std::rethrow_exception(first);
}

}  // namespace deform
