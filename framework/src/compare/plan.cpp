#include "deform/compare/plan.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "deform/error.h"

#include "compare/forked.h"
#include "compare/run_names.h"
#include "files/files.h"
#include "json/json.h"
#include "json/json_pointer.h"
#include "plugin/common_parameters.h"
#include "plugin/guard.h"
#include "scene/scene_problems.h"
#include "simulation/part_maker.h"
#include "simulation/run_parts.h"
#include "text/nearest_name.h"

namespace deform {
namespace {

constexpr const char* kBase = "base";
constexpr const char* kVary = "--vary";

/// A grid's cell: its name, and what it puts where.
struct Cell {
  std::string name;
  std::vector<Replacement> replacements;
};

std::vector<Cell> grid_of(const std::vector<Variation>& variations) {
  const auto labels = value_labels(variations);
  std::vector<Cell> cells{{}};
  for (std::size_t v = 0; v < variations.size(); ++v) {
    std::vector<Cell> finer;
    for (const Cell& cell : cells) {
      for (std::size_t i = 0; i < variations[v].values.size(); ++i) {
        Cell next = cell;
        next.name += (next.name.empty() ? "" : "+") + labels[v][i];
        next.replacements.push_back({variations[v].pointer, variations[v].values[i], true, kVary});
        finer.push_back(std::move(next));
      }
    }
    cells = std::move(finer);
  }
  return cells;
}

/// Reads what a comparison needs of one scene, and gathers what is wrong with it.
class Planner {
 public:
  Planner(const ComparisonRequest& request, std::shared_ptr<const PluginRegistry> registry,
          const std::atomic<bool>* interrupted)
      : request_(request), registry_(std::move(registry)), interrupted_(interrupted) {}

  ComparisonPlan plan() {
    const std::optional<std::string> text = read_file(request_.scene);
    const Scene written = read_scene(request_.scene, *registry_);
    const std::vector<std::string> variants = chosen_variants(written);
    check_variations();
    throw_problems();
    plan_runs(variants);
    check_names();
    check_dropped();
    throw_problems();
    const Scene base = read_scene(request_.scene, *registry_, request_.replacements);
    ComparisonPlan plan;
    plan.base = base.completed;
    plan.base_files = base.files;
    plan.reference = choose_reference(base);
    plan.runs = std::move(runs_);
    if (read_file(request_.scene) != text)
      throw InputError(fmt::format("{} changed while its variants were read: run it again",
                                   request_.scene.string()));
    make_parts(plan);
    return plan;
  }

 private:
  void throw_problems() const {
    if (!problems_.empty()) throw InputError(problems_);
  }

  std::vector<std::string> chosen_variants(const Scene& written) {
    std::vector<std::string> all{kBase};
    all.insert(all.end(), written.variants.begin(), written.variants.end());
    if (request_.variants.empty()) {
      if (!request_.variations.empty()) return {kBase};
      if (all.size() > 1 && !written.base_compared) all.erase(all.begin());
      return all;
    }
    std::vector<std::string> chosen;
    for (const std::string& name : request_.variants) {
      if (std::ranges::find(all, name) == all.end()) {
        problems_.push_back(
            {"/variants", fmt::format("--variants: {} has no variant \"{}\"{}",
                                      request_.scene.string(), name, did_you_mean(name, all))});
      } else if (std::ranges::find(chosen, name) == chosen.end()) {
        chosen.push_back(name);
      }
    }
    return chosen;
  }

  /// What is put first must not be replaced afterwards: runs would be the same in silence.
  void check_variations() {
    std::vector<std::pair<std::string, std::string>> earlier;  // option, pointer
    for (const Replacement& set : request_.replacements)
      if (set.source == "--set") earlier.emplace_back(set.source, set.pointer);
    for (const Variation& variation : request_.variations) {
      for (const auto& [option, pointer] : earlier)
        if (is_within(pointer, variation.pointer))
          problems_.push_back(
              {variation.pointer,
               fmt::format(
                   "{0} {1} replaces what {2} {3} puts: give {3} behind it, or leave one out",
                   kVary, variation.pointer, option, pointer)});
      earlier.emplace_back(kVary, variation.pointer);
    }
  }

  /// A parameter that no run's plugin has varies nothing.
  void check_dropped() {
    if (runs_.empty() || !problems_.empty()) return;
    for (const Variation& variation : request_.variations)
      if (std::ranges::all_of(runs_, [&](const PlannedRun& run) {
            const auto& dropped = run.scene.dropped;
            return std::ranges::find(dropped, variation.pointer) != dropped.end();
          }))
        problems_.push_back(
            {variation.pointer, fmt::format("{} {}: the plugin of no run has such a parameter",
                                            kVary, variation.pointer)});
  }

  void plan_runs(const std::vector<std::string>& variants) {
    const std::vector<Cell> grid = grid_of(request_.variations);
    if (variants.size() * grid.size() > kMostRuns)
      throw InputError(fmt::format("{} runs are too many to compare, expected at most {}",
                                   variants.size() * grid.size(), kMostRuns));
    for (const std::string& variant : variants) {
      for (const Cell& cell : grid) {
        const bool named = cell.name.empty() || variants.size() > 1 || variant != kBase;
        std::string name = named ? variant : "";
        if (!cell.name.empty()) name += (name.empty() ? "" : "+") + cell.name;
        plan_run(name, variant, cell.replacements);
      }
    }
  }

  void plan_run(const std::string& name, const std::string& variant,
                const std::vector<Replacement>& varied) {
    std::vector<Replacement> all = request_.replacements;
    all.insert(all.end(), varied.begin(), varied.end());
    try {
      runs_.push_back({name, read_scene(request_.scene, *registry_, all, variant)});
    } catch (const InputError& e) {
      for (const Problem& problem : e.problems()) {
        if (problems_.size() >= SceneProblems::kMost) return;
        if (said_.insert(problem.message).second) problems_.push_back(problem);
      }
    }
  }

  /// Names become folders of the comparison directory, beside its files.
  void check_names() {
    constexpr std::size_t kLongest = 200;
    for (const PlannedRun& run : runs_) {
      const bool is_file = run.name == "comparison.csv" || run.name == "cost.csv" ||
                           run.name == "summary.json" || run.name == "manifest.json" ||
                           run.name == "report.html" || run.name == "report.png";
      if (is_file || run.name == kRefined || run.name.size() > kLongest)
        problems_.push_back(
            {"/variants",
             fmt::format("{}: a run cannot be called \"{}\", expected at most {} characters and no "
                         "name that a comparison has for something else",
                         request_.scene.string(), run.name.substr(0, 60), kLongest)});
    }
  }

  std::string choose_reference(const Scene& base) {
    const bool asked = !request_.reference.empty();
    std::string wanted = asked ? request_.reference : base.reference;
    if (wanted == kRefined || wanted.starts_with(std::string(kRefined) + ':')) {
      return plan_refined(wanted);
    }
    std::vector<std::string> names;
    for (const PlannedRun& run : runs_) names.push_back(run.name);
    if (std::ranges::find(names, wanted) != names.end()) return wanted;
    // The scene's reference need not be among what was chosen of it: then what is nearest to it.
    if (!asked && !(request_.variants.empty() && request_.variations.empty())) {
      const auto unchanged = std::ranges::find_if(
          runs_, [&](const PlannedRun& run) { return run.scene.completed == base.completed; });
      return unchanged == runs_.end() ? names.front() : unchanged->name;
    }
    throw InputError(fmt::format("{} names no run: \"{}\"{}",
                                 asked ? "--reference" : "/comparison/reference of the scene",
                                 wanted, did_you_mean(wanted, names)));
  }

  /// The same scene with nodes twice as close and a quarter of the step: errors of the first order
  /// in h and in the step are a half and a quarter then.
  std::string plan_refined(const std::string& wanted) {
    const std::size_t colon = wanted.find(':');
    const std::string of = colon == std::string::npos ? kBase : wanted.substr(colon + 1);
    const Scene scene = read_scene(request_.scene, *registry_, request_.replacements, of);
    std::vector<Replacement> finer = request_.replacements;
    const auto put = [&finer](const std::string& pointer, const std::string& value) {
      finer.push_back({pointer, value, false, "--reference refined"});
    };
    for (const auto& [pointer, value] : refinement_of(scene)) put("/surface" + pointer, value);
    put("/integrator/step", fmt::format("{}", scene.step / 4));
    put("/frames", fmt::format(R"({{"every": {}}})", 4 * scene.frame_interval()));
    for (const PluginUse& probe : scene.plugins[PluginKind::probe])
      put(probe.pointer + "/every", fmt::format("{}", 4 * common_parameters<Probe>(probe).every));
    put("/outputs", "[]");
    runs_.push_back({kRefined, read_scene(request_.scene, *registry_, finer, of)});
    return kRefined;
  }

  /// Plugins are made in a child: one that ends the process ends its own run alone.
  std::vector<std::pair<std::string, std::string>> refinement_of(const Scene& scene) {
    const std::string changes = in_child(
        [&] {
          PartMaker maker(scene, registry_);
          const auto surface = maker.make<Surface>(scene.surface(), maker.setup());
          maker.throw_problems();
          const auto refinement = guarded(surface->origin, "saying how it is refined",
                                          [&] { return surface->object->refinement(); });
          if (refinement.empty())
            throw InputError(fmt::format(
                "--reference refined: {} does not say which of its parameters make its nodes twice "
                "as close (Surface::refinement): name a variant with such a surface, --reference "
                "NAME",
                surface->origin));
          return Json(refinement).dump();
        },
        interrupted_);
    return Json::parse(changes).get<std::vector<std::pair<std::string, std::string>>>();
  }

  void make_parts(ComparisonPlan& plan) {
    std::vector<Problem> problems;
    for (PlannedRun& run : plan.runs) {
      try {
        const std::string columns =
            in_child([&] { return Json(columns_of(run.scene)).dump(); }, interrupted_);
        run.columns = Json::parse(columns).get<std::vector<std::string>>();
      } catch (const Error& e) {
        if (e.code() == ExitCode::interrupted) throw;
        run.refused = e.what();
        run.plugin_failed = e.code() == ExitCode::plugin_failed;
        if (const auto* bad = dynamic_cast<const InputError*>(&e)) {
          if (run.name == kRefined) throw not_refined(*bad);
          problems.insert(problems.end(), bad->problems().begin(), bad->problems().end());
        }
      }
    }
    const bool all =
        std::ranges::all_of(plan.runs, [](const auto& r) { return !r.refused.empty(); });
    if (all && !problems.empty()) throw InputError(std::move(problems));
  }

  /// Makes all that the run is made of; the columns of its probes.
  std::vector<std::string> columns_of(const Scene& scene) {
    RunParts parts = make_run_parts(scene, registry_);
    begin_probes(parts, make_run_context(parts, {}));
    std::vector<std::string> names;
    for (const ProbeColumn& column : parts.probes->columns()) names.push_back(column.name);
    return names;
  }

  /// What the scene lacks for a finer grid: a file of positions with more rows, say.
  static InputError not_refined(const InputError& why) {
    std::vector<Problem> problems = why.problems();
    for (Problem& problem : problems)
      problem.message =
          "--reference refined: the scene on a grid twice as fine: " + problem.message;
    return InputError(std::move(problems));
  }

  const ComparisonRequest& request_;
  std::shared_ptr<const PluginRegistry> registry_;
  const std::atomic<bool>* interrupted_;
  std::vector<PlannedRun> runs_;
  std::vector<Problem> problems_;
  std::set<std::string> said_;  // what runs share is said once
};

}  // namespace

std::vector<std::string> split_values(const std::string& text) {
  std::vector<std::string> values{""};
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\' && i + 1 < text.size()) {
      values.back() += c;
      values.back() += text[++i];
      continue;
    }
    if (c == '"') quoted = !quoted;
    if (!quoted && (c == '[' || c == '{')) ++depth;
    if (!quoted && (c == ']' || c == '}')) --depth;
    if (c == ',' && !quoted && depth == 0) {
      values.emplace_back();
    } else {
      values.back() += c;
    }
  }
  return values;
}

ComparisonPlan plan_comparison(const ComparisonRequest& request,
                               const std::shared_ptr<const PluginRegistry>& registry,
                               const std::atomic<bool>* interrupted) {
  return Planner(request, registry, interrupted).plan();
}

}  // namespace deform
